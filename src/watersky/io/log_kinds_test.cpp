// SPDX-License-Identifier: MIT
// Photographs beside an autopilot's own log, of whichever kind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/make_photo.hpp"
#include "support/real_data.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/inspect.hpp"
#include "watersky/io/read_flight.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

void put_photo(const fs::path& file) {
  test::Photo photo;
  photo.make = photo.model = "";
  test::write(file, test::make_photo(photo));
}

class LogKinds : public testing::Test {
 protected:
  void SetUp() override {
    const auto data = test::real_data("autopilot_logs");
    if (!data) GTEST_SKIP() << "the real data is not here";
    data_ = *data;
    test::write(folder_.path() / "camera.yaml",
                std::string("image_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, "
                            "data: [60., 0., 31.5, 0., 60., 23.5, 0., 0., 1.]}\n"));
  }
  void copy(const std::string& from, const std::string& to) {
    test::write(folder_.path() / to, read_bytes(data_ / from).value());
  }
  /// How many frames have a pose.
  static std::size_t placed(const Flight& flight) {
    std::size_t n = 0;
    for (const ImageFrame& frame : flight.frames)
      n += flight.camera_pose(frame, std::chrono::milliseconds(500)).ok() ? 1 : 0;
    return n;
  }
  TemporaryFolder folder_;
  fs::path data_;
};

TEST_F(LogKinds, AsManyPhotographsAsCamRecordsAreAllPlaced) {
  copy("arduplane_sitl_cam.BIN", "00000042.BIN");
  test::write(folder_.path() / "firmware.bin", std::string("something else"));
  for (int i = 0; i < 25; ++i)
    put_photo(folder_.path() / ("IMG_" + std::to_string(1000 + i) + ".jpg"));
  EXPECT_EQ(recording_kind(folder_.path()).value(), RecordingKind::PhotographsWithLog);
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  const auto flight = read_flight(folder_.path(), options);
  ASSERT_TRUE(flight) << flight.error().message;
  EXPECT_EQ(flight->frames.size(), 25u);
  EXPECT_EQ(placed(*flight), 25u);
  EXPECT_THAT(flight->notes, Contains("image times are from the log's CAM records"));
}

TEST_F(LogKinds, DunesLogIsReadByTheSchemaBesideIt) {
  copy("dune_x8/Data.lsf.gz", "Data.lsf.gz");
  copy("dune_x8/IMC.xml.gz", "IMC.xml.gz");
  // The log is of 2026-11-22, 04:41:23 to 04:42:27.
  for (const char* name : {"20261122T044130Z.jpg", "20261122T044210Z.jpg"})
    put_photo(folder_.path() / name);
  ReadOptions options;
  options.sea_level = SeaLevelOption{SeaReference::Ellipsoid, 0};
  const auto flight = read_flight(folder_.path(), options);
  ASSERT_TRUE(flight) << flight.error().message;
  EXPECT_EQ(placed(*flight), 2u);
  const auto pose = flight->camera_pose(flight->frames[1], std::chrono::milliseconds(500)).value();
  EXPECT_NEAR(-pose.sea_from_camera.origin().v.z(), 150.0, 1.0);
  EXPECT_EQ(inspect(folder_.path() / "Data.lsf.gz")->facts.at("schema"), "the IMC.xml beside it");
  // DUNE says nothing of where it took off.
  options.sea_level = SeaLevelOption{SeaReference::TakeOff, 0};
  EXPECT_EQ(read_flight(folder_.path(), options).error().code, ErrorCode::NotFound);

  test::write(folder_.path() / "IMC.xml.gz", std::string("no schema"));
  const auto again = read_flight(folder_.path());
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_THAT(again->notes, Contains(HasSubstr("read by the schema that we know")));
}

TEST_F(LogKinds, ACutLsfIsReadAsFarAsItGoes) {
  auto bytes = read_bytes(data_ / "dune_x8/Data.lsf.gz").value();
  bytes.resize(bytes.size() * 2 / 3);
  test::write(folder_.path() / "Data.lsf.gz", bytes);
  const Inspection found = inspect(folder_.path() / "Data.lsf.gz").value();
  EXPECT_GT(found.counts.at("EstimatedState"), 300u);
  EXPECT_LT(found.counts.at("EstimatedState"), 641u);
  EXPECT_THAT(found.notes, Contains(HasSubstr("its gzip ends or is damaged at byte")));
}

TEST_F(LogKinds, InspectTellsWhatTheLogsHold) {
  const Inspection bin = inspect(data_ / "arduplane_sitl_cam.BIN").value();
  EXPECT_EQ(bin.kind, "dataflash");
  EXPECT_EQ(bin.counts.at("CAM"), 25u);
  EXPECT_NEAR(bin.rates_hz.at("ATT"), 25.0, 0.1);
  EXPECT_THAT(bin.facts.at("firmware"), HasSubstr("ArduPlane V4.7.0-dev"));
  EXPECT_NEAR(bin.extent->south_deg, 78.2253, 0.001);
  EXPECT_NEAR(to_seconds(*bin.last - *bin.first), 60, 0.5);
  const Inspection lsf = inspect(data_ / "dune_x8/Data.lsf.gz").value();
  EXPECT_EQ(lsf.kind, "lsf");
  EXPECT_EQ(lsf.counts.at("EstimatedState"), 641u);
  EXPECT_NEAR(lsf.rates_hz.at("EstimatedState"), 10.0, 0.1);
  EXPECT_NEAR(lsf.extent->north_deg, 78.2327, 0.001);
  EXPECT_EQ(lsf.facts.at("system 0x0c0c"), "11202 packets");
}

TEST(LogFiles, OfNoKindThatWeReadAreRefusedWithTheKindsThatWeDo) {
  const TemporaryFolder folder;
  put_photo(folder.path() / "a.jpg");
  test::write(folder.path() / "flight.ulg", std::string("x"));
  ReadOptions options;
  options.log = folder.path() / "flight.ulg";
  EXPECT_THAT(read_flight(folder.path(), options).error().message, HasSubstr(".bin (DataFlash)"));
  // A log alone is no flight.
  test::write(folder.path() / "flight.bin", std::string("\xA3\x95"));
  EXPECT_THAT(read_flight(folder.path() / "flight.bin").error().message,
              HasSubstr("a log without images"));
  EXPECT_EQ(inspect(folder.path() / "flight.bin").error().code, ErrorCode::InvalidInput);
}

}  // namespace
}  // namespace watersky
