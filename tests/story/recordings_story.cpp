// SPDX-License-Identifier: MIT
// One flight, recorded in every form that there is: the sea on the map is the same.
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>

#include "story.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/log_flight_write.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/io/recording_write.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSea = R"(
    .........
    .###..#..
    .###.....
    .....##..
    ..#......)";

/// A form, and how far P(ice) may be off: on the mean over the sea, and by more than a half in
/// which share of it.
struct Form {
  std::string name;
  Status (*write)(const Flight& flight, const fs::path& path);
  std::string path;
  double mean, share;
};

void PrintTo(const Form& form, std::ostream* out) { *out << form.name; }

template <class Written>
Status status_of(const Written& written) {
  return written ? Status() : Status(written.error());
}

template <LogFormat format>
Status write_log(const Flight& flight, const fs::path& path) {
  return status_of(write_log_flight(flight, path, format));
}

class ARecordedSea : public ::testing::TestWithParam<Form> {};

TEST_P(ARecordedSea, IsTheSameOnTheMap) {
  const Form& form = GetParam();
  const auto simulation = story::simulation(story::sea(kSea), {.azimuth_deg = 40.0, .seed = 5});
  const Flight& flight = simulation.flight;
  const auto direct = story::map(flight);
  ASSERT_TRUE(direct) << direct.error().message;

  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / form.path;
  const Status written = form.write(flight, path);
  ASSERT_TRUE(written) << written.error().message;
  ReadOptions options;
  if (form.name != "FlightFolder" && form.name != "Mcap") {
    // What logs and bags have no record for.
    if (form.name != "Bag") {
      options.camera_file = path / "camera.yaml";
      options.mount =
          yaw_pitch_roll(flight.mount.rotation * forward_right_down_from_camera().conjugate());
    }
    options.sea_level =
        SeaLevelOption{SeaReference::Ellipsoid,
                       flight.sea_level->height_ellipsoid_m(flight.datum.origin()).value()};
  }
  const auto read = read_flight(path, options);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->frames.size(), flight.frames.size());
  const auto run = story::map(*read);
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_TRUE(run->left_out.empty()) << run->left_out.front().reason;

  int points = 0, far = 0;
  double sum = 0;
  for (double north = -25; north <= 25; north += 0.7)
    for (double east = -45; east <= 45; east += 0.7) {
      const double was = story::p_ice(*direct, simulation.truth, north, east);
      const double is = story::p_ice(*run, simulation.truth, north, east);
      if (std::isnan(was)) continue;
      ++points;
      const double off = std::isnan(is) ? 1.0 : std::abs(is - was);
      sum += off;
      far += off > 0.5;
    }
  ASSERT_GT(points, 5000);
  EXPECT_LE(sum / points, form.mean);
  EXPECT_LE(static_cast<double>(far) / points, form.share);
}

INSTANTIATE_TEST_SUITE_P(
    Story, ARecordedSea,
    ::testing::Values(
        Form{
            "FlightFolder",
            [](const Flight& f, const fs::path& p) { return status_of(write_flight_folder(f, p)); },
            "flight", 1e-4, 0.0},
        Form{"Mcap",
             [](const Flight& f, const fs::path& p) { return status_of(write_mcap_flight(f, p)); },
             "flight.mcap", 1e-4, 0.0},
        Form{"Bag",
             [](const Flight& f, const fs::path& p) { return status_of(write_bag_flight(f, p)); },
             "flight.bag", 1e-4, 0.0},
        // Milliseconds and 1e-7 degrees: a centimetre or two, in cells of half a metre.
        Form{"Tlog", write_log<LogFormat::Tlog>, "tlog", 0.01, 0.002},
        Form{"DataFlash", write_log<LogFormat::DataFlash>, "bin", 0.005, 0.001},
        Form{"Lsf", write_log<LogFormat::Lsf>, "lsf", 0.005, 0.001}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace watersky
