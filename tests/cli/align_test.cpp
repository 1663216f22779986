// SPDX-License-Identifier: MIT
/// `watersky align`, and what `watersky map` does with it.
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

constexpr double kDelay_s = 0.25;

/// A small flight of which only the arrivals are known; gusts make the delay visible.
const fs::path& late_flight() {
  static const TemporaryFolder folder;
  static const fs::path flight = [] {
    const fs::path path = folder.path() / "flight";
    const Outcome made =
        watersky("simulate '" + path.string() +
                 "' --legs 1 --leg-length-m 150 --width-px 320 --height-px 256 --focal-px 300 "
                 "--supersampling 1 --frame-rate-hz 3 --no-capture-recorded --arrival-delay-s 0.25 "
                 "--arrival-jitter-s 0.01 --gust-yaw-deg 3 --quiet");
    if (made.status != 0) ADD_FAILURE() << made.err;
    return path;
  }();
  return flight;
}

/// Rows of a CSV file as text, without its header.
std::vector<std::vector<std::string>> rows_of(const fs::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(read_text(file));
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

class Align : public ::testing::Test {
 protected:
  Outcome align(const fs::path& flight, const std::string& options = "") {
    return watersky("align '" + flight.string() + "' -o '" + out().string() + "' " + options);
  }
  [[nodiscard]] fs::path out() const { return folder_.path() / "aligned"; }

  /// A copy of the late flight to change.
  [[nodiscard]] fs::path copy() const {
    const fs::path path = folder_.path() / "flight";
    fs::copy(late_flight(), path, fs::copy_options::recursive);
    return path;
  }
  /// Only the first of its frames.
  void keep_frames(const fs::path& flight, std::size_t count) {
    std::istringstream in(read_text(flight / "frames.csv"));
    std::string text, line;
    for (std::size_t i = 0; i <= count && std::getline(in, line); ++i) text += line + "\n";
    write_text(flight / "frames.csv", text);
  }

  TemporaryFolder folder_;
};

TEST_F(Align, AnAnchorAndARangeFinderGoThroughFromFileToFile) {
  const fs::path flight = folder_.path() / "anchored";
  const Outcome made = watersky(
      "simulate '" + flight.string() +
      "' --legs 1 --leg-length-m 120 --width-px 320 --height-px 256 --focal-px 300 "
      "--supersampling 1 --frame-rate-hz 3 --nav-position-sigma-m 1 --nav-correlation-s 600 "
      "--nav-height-bias-m 5 --anchor --anchor-sightings 3 --range-rate-hz 5 --quiet");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(rows_of(flight / "anchors.csv").size(), 3u);
  EXPECT_GT(rows_of(flight / "range.csv").size(), 20u);
  const Outcome o = align(flight);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out + o.err, HasSubstr("Anchor anchor was used, seen in 3 frames"));
  EXPECT_THAT(o.out + o.err, HasSubstr("what anchors leave"));
  const auto json = nlohmann::json::parse(read_text(out() / "align.json"));
  ASSERT_EQ(json["anchors"].size(), 1u);
  EXPECT_EQ(json["anchors"][0]["used"], 3);
  EXPECT_LT(json["anchors"][0]["after_rms_m"], 0.4);
  EXPECT_NEAR(json["range_finder"]["height_as_given_m"], -5.0, 2.5);
  EXPECT_LT(std::abs(json["range_finder"]["height_after_m"].get<double>()), 0.3);
  EXPECT_LT(json["shared_offset_covariance_m2"][0][0], 0.1);
  // Nothing is lost on the way.
  EXPECT_EQ(read_text(out() / "range.csv"), read_text(flight / "range.csv"));
  EXPECT_EQ(rows_of(out() / "anchors.csv").size(), 3u);
  EXPECT_THAT(read_text(out() / "report.html"), HasSubstr("Known points"));

  // Another file in place of that one; what is wrong with it is said with its line.
  const fs::path list = folder_.path() / "gcp_list.txt";
  write_text(list, "EPSG:4326\n11.9 78.9 NaN 3 4\n");
  const Outcome bad = align(flight, "--overwrite --anchors '" + list.string() + "'");
  EXPECT_EQ(bad.status, 1);
  EXPECT_THAT(bad.err, HasSubstr("gcp_list.txt:2: has 5 words"));
}

TEST_F(Align, FindsWhenTheImagesWereTakenAndWritesItDown) {
  const Outcome o = align(late_flight(), "--json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto frames = rows_of(out() / "frames.csv");
  ASSERT_EQ(frames.size(), rows_of(late_flight() / "frames.csv").size());
  std::vector<std::string> pose_times;
  for (const auto& row : rows_of(out() / "poses.csv")) pose_times.push_back(row[0]);
  double mean_delay_s = 0.0;
  for (const auto& row : frames) {
    ASSERT_FALSE(row[1].empty()) << row[0];
    EXPECT_THAT(pose_times, ::testing::Contains(row[1])) << "a pose at the very capture";
    mean_delay_s += (std::stod(row[2]) - std::stod(row[1])) / static_cast<double>(frames.size());
  }
  // Arrivals are never early: jitter of 10 ms makes the mean delay 8 ms longer.
  EXPECT_NEAR(mean_delay_s, kDelay_s + 0.008, 0.02);
  EXPECT_THAT(read_text(out() / "poses.csv"), HasSubstr("sigma_north_m"));
  EXPECT_THAT(read_text(out() / "flight.yaml"), HasSubstr("mount:"));
  EXPECT_THAT(read_text(out() / "report.html"), HasSubstr("Before and after"));

  const auto json = nlohmann::json::parse(read_text(out() / "align.json"));
  // Poses and mount are right in this flight, so that a constant delay may be all it needs.
  EXPECT_NE(json["method"], "as given") << json["reason"];
  EXPECT_NEAR(json["delay"]["mean_s"], kDelay_s, 0.02);
  EXPECT_LT(json["disagreement"]["after"]["median_m"],
            json["disagreement"]["as_given"]["median_m"]);
  EXPECT_EQ(json["frames"]["used"], frames.size());
  EXPECT_EQ(json["per_frame"].size(), frames.size());
  EXPECT_GE(json["estimates"].size(), 3u);
  for (const auto& estimate : json["estimates"])
    for (const char* field :
         {"name", "unit", "given", "value", "sigma", "sigma_before", "observed"})
      EXPECT_TRUE(estimate.contains(field)) << field;
  EXPECT_EQ(o.json()["frames"], json["frames"]);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1)
      << "no temporary folder stays";

  const Outcome read = watersky("inspect '" + out().string() + "' --json");
  EXPECT_EQ(read.status, 0) << read.err;
}

TEST_F(Align, SaysInWordsWhatWasFoundAndWhatWasNot) {
  const Outcome o = align(late_flight());
  ASSERT_EQ(o.status, 0) << o.err;
  for (const char* words : {"delay", "±", "places disagree, as given", "after", "report.html"})
    EXPECT_THAT(o.out, HasSubstr(words));
}

TEST_F(Align, ImagesAreKeptAsTheyAreUnlessTold) {
  const fs::path flight = copy();
  keep_frames(flight, 6);
  ASSERT_EQ(align(flight, "--delay-s 0.25").status, 0);
  const std::string first = images_of(out()).front().filename();
  EXPECT_TRUE(read_text(out() / "images" / first) == read_text(flight / "images" / first));
  ASSERT_EQ(align(flight, "--delay-s 0.25 --images jpeg --overwrite").status, 0);
  EXPECT_EQ(images_of(out()).front().extension(), ".jpg");
}

TEST_F(Align, OfOneFrameNothingIsLearntAndItsTimeIsNotGuessed) {
  const fs::path flight = copy();
  keep_frames(flight, 1);
  const Outcome o = align(flight);
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("delay"));
  EXPECT_FALSE(fs::exists(out()));

  const Outcome told = align(flight, "--delay-s 0.25 --json");
  ASSERT_EQ(told.status, 0) << told.err;
  EXPECT_EQ(told.json()["method"], "as given");
  EXPECT_FALSE(told.json()["reason"].get<std::string>().empty());
}

TEST_F(Align, FeaturelessWaterIsWrittenAsItWasGivenAndSaidSo) {
  const fs::path flight = copy();
  for (const fs::path& image : images_of(flight))
    cv::imwrite(image.string(), cv::Mat(256, 320, CV_8U, cv::Scalar(60)));
  const Outcome o = align(flight, "--delay-s 0.25");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("Not aligned"));
  EXPECT_THAT(o.out, HasSubstr("delay                      not observed, stays 250.0 ms"));
  const auto frames = rows_of(out() / "frames.csv");
  for (const auto& row : frames) EXPECT_NEAR(std::stod(row[2]) - std::stod(row[1]), kDelay_s, 1e-6);
  EXPECT_THAT(read_text(out() / "report.html"), HasSubstr("Not aligned"));
}

TEST_F(Align, NoSeaLevelExplainsTheChoices) {
  const fs::path flight = copy();
  std::istringstream in(read_text(flight / "flight.yaml"));
  std::string text;
  for (std::string line; std::getline(in, line);)
    if (line.find("sea_") == std::string::npos) text += line + "\n";
  write_text(flight / "flight.yaml", text);
  const Outcome o = align(flight);
  expect_one_line_error(o, 1);
  for (const char* choice : {"--sea-level", "takeoff:", "geoid:", "ellipsoid:"})
    EXPECT_THAT(o.err, HasSubstr(choice));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(Align, ReplacesOnlyAnAlignmentOfOursAndOnlyWhenTold) {
  const fs::path flight = copy();
  keep_frames(flight, 6);
  for (const char* option : {"", "--overwrite"}) {
    const Outcome itself = watersky("align '" + flight.string() + "' -o '" + flight.string() +
                                    "' --delay-s 0.25 " + option);
    expect_one_line_error(itself, 1);
  }
  ASSERT_EQ(align(flight, "--delay-s 0.25").status, 0);
  const Outcome again = align(flight, "--delay-s 0.25");
  expect_one_line_error(again, 1);
  EXPECT_THAT(again.err, HasSubstr("--overwrite"));
  EXPECT_EQ(align(flight, "--delay-s 0.25 --overwrite").status, 0);
  fs::remove(out() / "align.json");
  expect_one_line_error(align(flight, "--delay-s 0.25 --overwrite"), 1);
  EXPECT_TRUE(fs::exists(out() / "poses.csv"));
}

TEST_F(Align, ImagesThatCannotBeReadEndInOneLineAndNoFolder) {
  const fs::path flight = copy();
  for (const auto& image : fs::directory_iterator(flight / "images"))
    fs::resize_file(image.path(), 300);
  const Outcome o = align(flight, "--delay-s 0.25 --quiet");
  EXPECT_EQ(o.status, 1);
  EXPECT_THAT(o.err, HasSubstr(flight.string()));
  EXPECT_THAT(o.err, HasSubstr("none of"));
  EXPECT_THAT(o.err, HasSubstr("frame_0"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(Align, AFullDiskLeavesNothingBehind) {
  const fs::path flight = copy();
  keep_frames(flight, 6);
  const Outcome o =
      watersky("align '" + flight.string() + "' -o '" + out().string() + "' --delay-s 0.25",
               "trap '' XFSZ; ulimit -f 4; ");
  EXPECT_EQ(o.status, 1) << o.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(Align, CallsAtFaultEndWithStatus2) {
  const fs::path polygons = folder_.path() / "land.geojson";
  write_text(polygons,
             R"({"type":"Polygon","coordinates":[[[11,78],[12,78],[12,79],[11,79],[11,78]]]})");
  for (const std::string& option :
       {std::string("--images gif"), std::string("--tracked-points 1"),
        "--mask '" + polygons.string() + "'", std::string("--delay-s nan")})
    EXPECT_EQ(align(late_flight(), option).status, 2) << option;
  EXPECT_EQ(watersky("align '" + late_flight().string() + "'").status, 2) << "-o is required";
}

TEST_F(Align, MapDoesItByItselfAndCanBeToldNotTo) {
  const fs::path flight = late_flight();
  const Outcome o = watersky("map '" + flight.string() + "' -o '" +
                             (folder_.path() / "map").string() + "' --no-mosaic --json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto run = o.json();
  EXPECT_NE(run["alignment"]["method"], "as given");
  EXPECT_NEAR(run["alignment"]["delay"]["mean_s"], kDelay_s, 0.02);
  EXPECT_GT(run["timings_s"]["alignment"], 0.0);
  EXPECT_EQ(run["frames"]["used"], rows_of(flight / "frames.csv").size());
  EXPECT_THAT(read_text(folder_.path() / "map" / "report.html"), HasSubstr("Alignment</h2>"));

  // Without it nobody knows when these images were taken.
  const Outcome raw = watersky("map '" + flight.string() + "' -o '" +
                               (folder_.path() / "raw").string() + "' --no-align");
  expect_one_line_error(raw, 1);
  EXPECT_THAT(raw.err, HasSubstr("delay"));
  const Outcome told =
      watersky("map '" + flight.string() + "' -o '" + (folder_.path() / "told").string() +
               "' --no-align --no-mosaic --delay-s 0.25 --json");
  ASSERT_EQ(told.status, 0) << told.err;
  EXPECT_TRUE(told.json()["alignment"].is_null());
}

TEST_F(Align, MapLeavesOutEachFrameOnce) {
  const fs::path flight = copy();
  const auto rows = rows_of(flight / "poses.csv");
  std::istringstream in(read_text(flight / "poses.csv"));
  std::string text, line;
  for (std::size_t i = 0; i < rows.size() * 2 / 3 && std::getline(in, line); ++i)
    text += line + "\n";
  write_text(flight / "poses.csv", text);
  const Outcome o = watersky("map '" + flight.string() + "' -o '" +
                             (folder_.path() / "map").string() + "' --no-mosaic --json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto frames = o.json()["frames"];
  std::vector<std::string> files;
  for (const auto& l : frames["left_out"]) files.push_back(l["file"]);
  std::sort(files.begin(), files.end());
  EXPECT_GE(files.size(), 1u);
  EXPECT_EQ(std::unique(files.begin(), files.end()), files.end());
  EXPECT_EQ(frames["used"].get<std::size_t>() + files.size(), frames["total"].get<std::size_t>());
  EXPECT_EQ(frames["total"], rows_of(flight / "frames.csv").size());
}

}  // namespace
}  // namespace watersky::test
