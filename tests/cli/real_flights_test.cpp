// SPDX-License-Identifier: MIT
/// Real photographs and a real log. Skips where they are absent: set WATERSKY_DATA to their folder.
#include <gmock/gmock.h>

#include "cli_support.hpp"
#include "support/real_data.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

fs::path data(const char* name) { return real_data(name).value_or(fs::path(name)); }

#define WATERSKY_NEEDS(path) \
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not here; set WATERSKY_DATA"

TEST(RealFlights, AllOfBrightonBeachIsPlaced) {
  WATERSKY_NEEDS(data("brighton_beach"));
  const TemporaryFolder folder;
  const Outcome o =
      watersky("map '" + data("brighton_beach").string() + "' -o '" +
               (folder.path() / "map").string() + "' --sea-level takeoff:-2 --cell-m 0.25 --json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto frames = o.json()["frames"];
  EXPECT_EQ(frames["total"], 18);
  EXPECT_EQ(frames["used"], 18);
}

TEST(RealFlights, AllOfTheCuavFlightIsPlacedByItsLog) {
  WATERSKY_NEEDS(data("cuav_flight"));
  const TemporaryFolder folder;
  const Outcome o = watersky("map '" + data("cuav_flight").string() + "' -o '" +
                             (folder.path() / "map").string() + "' --sea-level takeoff:0 --json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto frames = o.json()["frames"];
  EXPECT_EQ(frames["total"], 18);
  EXPECT_EQ(frames["used"], 18);
}

class DamagedLog : public ::testing::Test {
 protected:
  Outcome map_with(const std::string& log_bytes) {
    const fs::path log = folder_.path() / "damaged.tlog";
    write_text(log, log_bytes);
    fs::create_directory(folder_.path() / "photos");
    for (const auto& entry : fs::directory_iterator(data("cuav_flight")))
      if (entry.path().extension() == ".jpg")
        fs::create_symlink(fs::absolute(entry.path()),
                           folder_.path() / "photos" / entry.path().filename());
    return watersky("map '" + (folder_.path() / "photos").string() + "' --log '" + log.string() +
                    "' --camera '" + (data("cuav_flight") / "camera.yaml").string() +
                    "' --sea-level takeoff:0 --json -o '" + (folder_.path() / "map").string() +
                    "'");
  }
  TemporaryFolder folder_;
};

TEST_F(DamagedLog, CutInTheMiddleOfAPacketStillPlacesWhatItCovers) {
  WATERSKY_NEEDS(data("cuav_flight"));
  const std::string whole = read_text(data("cuav_flight") / "flight.tlog");
  const Outcome o = map_with(whole.substr(0, whole.size() - 11));
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.json()["frames"]["used"], 18);
}

TEST_F(DamagedLog, GarbageBetweenPacketsIsSteppedOver) {
  WATERSKY_NEEDS(data("cuav_flight"));
  std::string log = read_text(data("cuav_flight") / "flight.tlog");
  for (std::size_t at = 5000; at + 100 < log.size(); at += 20000)
    log.insert(at, "\xfe\xfd garbage \xfe\x09 between packets");
  const Outcome o = map_with(log);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_GE(o.json()["frames"]["used"].get<int>(), 17);
}

TEST_F(DamagedLog, FramesOutsideTheLogAreLeftOut) {
  WATERSKY_NEEDS(data("cuav_flight"));
  const std::string whole = read_text(data("cuav_flight") / "flight.tlog");
  const Outcome o = map_with(whole.substr(0, whole.size() / 10));
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("none of 18 frames"));
}

}  // namespace
}  // namespace watersky::test
