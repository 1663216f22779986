// SPDX-License-Identifier: MIT
/// What a user gets for input that is wrong: one line that says what, where and what to do, and
/// nothing half-written.
#include <gmock/gmock.h>

#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

class BadInput : public ::testing::Test {
 protected:
  Outcome map(const std::string& options = "") {
    return watersky("map '" + flight().string() + "' -o '" + out().string() + "' " + options);
  }
  [[nodiscard]] fs::path flight() const { return folder_.path() / "flight"; }
  [[nodiscard]] fs::path out() const { return folder_.path() / "map"; }

  /// Changes a text file of the flight.
  void edit(const std::string& file, const std::function<std::string(std::string)>& change) {
    write_text(flight() / file, change(read_text(flight() / file)));
  }
  /// Swaps, removes or rewrites lines; line 0 is the header.
  void edit_lines(const std::string& file,
                  const std::function<void(std::vector<std::string>&)>& change) {
    edit(file, [&](const std::string& text) {
      std::istringstream in(text);
      std::vector<std::string> lines;
      for (std::string line; std::getline(in, line);) lines.push_back(line);
      change(lines);
      std::string all;
      for (const std::string& line : lines) all += line + "\n";
      return all;
    });
  }
  /// Nothing but the flight lies in the folder: no map, no temporary files.
  void expect_nothing_written() {
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      EXPECT_EQ(entry.path().filename(), "flight") << entry.path();
  }

  TemporaryFolder folder_;
};

TEST_F(BadInput, AFolderThatIsNotThere) {
  const Outcome o = map();
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr(flight().string()));
}

TEST_F(BadInput, AnEmptyFolder) {
  fs::create_directory(flight());
  const Outcome o = map("--sea-level ellipsoid:0");
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr(flight().string()));
  expect_nothing_written();
}

TEST_F(BadInput, ATruncatedJpegAmongGoodOnesIsLeftOutAndTheRestMapped) {
  copy_of_flight(folder_);
  const auto images = images_of(flight());
  ASSERT_GE(images.size(), 4u);
  for (const fs::path& png : images) {
    fs::path jpg = png;
    ASSERT_TRUE(cv::imwrite(jpg.replace_extension(".jpg").string(),
                            cv::imread(png.string(), cv::IMREAD_UNCHANGED)));
    fs::remove(png);
  }
  edit("frames.csv", [](std::string text) {
    for (std::size_t at = 0; (at = text.find(".png", at)) != std::string::npos;)
      text.replace(at, 4, ".jpg");
    return text;
  });
  const fs::path cut = fs::path(images[1]).replace_extension(".jpg");
  fs::resize_file(cut, fs::file_size(cut) / 2);

  const Outcome o = map("--json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto frames = o.json()["frames"];
  EXPECT_EQ(frames["total"], images.size());
  EXPECT_EQ(frames["used"], images.size() - 1);
  ASSERT_EQ(frames["left_out"].size(), 1u);
  EXPECT_THAT(frames["left_out"][0]["file"].get<std::string>(), HasSubstr(cut.filename().string()));
  EXPECT_FALSE(frames["left_out"][0]["reason"].get<std::string>().empty());
  EXPECT_TRUE(fs::exists(out() / "report.html"));
}

TEST_F(BadInput, AnImageSizeThatContradictsTheCalibration) {
  copy_of_flight(folder_);
  edit("camera.yaml", [](std::string text) {
    const auto at = text.find("image_width: 320");
    EXPECT_NE(at, std::string::npos) << text;
    return text.replace(at, 16, "image_width: 400");
  });
  const Outcome o = map();
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("400x256"));
  expect_nothing_written();
}

TEST_F(BadInput, OneImageOfAnotherSizeIsLeftOut) {
  copy_of_flight(folder_);
  const auto images = images_of(flight());
  cv::imwrite(images[2].string(), cv::Mat(100, 90, CV_8U, cv::Scalar(40)));
  const Outcome o = map("--json");
  // Two cameras in one flight: refused as a whole or the odd one named, but never mapped.
  if (o.status == 0) {
    ASSERT_EQ(o.json()["frames"]["left_out"].size(), 1u);
    EXPECT_THAT(o.json()["frames"]["left_out"][0]["file"].get<std::string>(),
                HasSubstr(images[2].filename().string()));
  } else {
    expect_one_line_error(o, 1);
    EXPECT_THAT(o.err, HasSubstr(images[2].filename().string()));
  }
}

TEST_F(BadInput, ANanInThePosesIsNamedWithItsLine) {
  copy_of_flight(folder_);
  edit_lines("poses.csv", [](auto& lines) {
    lines[5] = lines[5].substr(0, lines[5].find(',')) + ",nan,0,-80,1,0,0,0";
  });
  const Outcome o = map();
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("poses.csv:6"));
  expect_nothing_written();
}

TEST_F(BadInput, UnsortedPosesAreNamedWithTheirLine) {
  copy_of_flight(folder_);
  edit_lines("poses.csv", [](auto& lines) { std::swap(lines[5], lines[6]); });
  const Outcome o = map();
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("poses.csv:7"));
  expect_nothing_written();
}

TEST_F(BadInput, DuplicateTimesInThePosesAreNamedWithTheirLine) {
  copy_of_flight(folder_);
  edit_lines("poses.csv", [](auto& lines) { lines.insert(lines.begin() + 6, lines[5]); });
  const Outcome o = map();
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("poses.csv:7"));
  expect_nothing_written();
}

TEST_F(BadInput, FramesOutsideTheLogAreLeftOutWithTheReason) {
  copy_of_flight(folder_);
  edit_lines("poses.csv", [](auto& lines) { lines.resize(lines.size() / 2); });
  const Outcome o = map("--json");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto frames = o.json()["frames"];
  ASSERT_GE(frames["left_out"].size(), 1u);
  EXPECT_GE(frames["used"].get<int>(), 1);
  EXPECT_EQ(frames["used"].get<std::size_t>() + frames["left_out"].size(),
            frames["total"].get<std::size_t>());
  EXPECT_THAT(frames["left_out"][0]["reason"].get<std::string>(), HasSubstr("after the last"));
}

TEST_F(BadInput, ACameraUnderWaterIsToldHowFar) {
  copy_of_flight(folder_);
  const Outcome o = map("--sea-level ellipsoid:1000");
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("below the sea"));
  expect_nothing_written();
}

TEST_F(BadInput, NoSeaLevelExplainsTheChoices) {
  copy_of_flight(folder_);
  edit_lines("flight.yaml", [](auto& lines) {
    std::erase_if(lines,
                  [](const std::string& line) { return line.find("sea_") != std::string::npos; });
  });
  const Outcome o = map();
  expect_one_line_error(o, 1);
  for (const char* choice : {"--sea-level", "takeoff:", "geoid:", "ellipsoid:"})
    EXPECT_THAT(o.err, HasSubstr(choice));
  expect_nothing_written();
}

TEST_F(BadInput, AnOutThatExistsIsNotTouched) {
  copy_of_flight(folder_);
  fs::create_directory(out());
  write_text(out() / "thesis.txt", "years of work");
  for (const char* option : {"", "--overwrite"}) {
    const Outcome o = map(option);
    expect_one_line_error(o, 1);
    EXPECT_THAT(o.err, HasSubstr(out().string()));
    EXPECT_EQ(read_text(out() / "thesis.txt"), "years of work");
    EXPECT_EQ(std::distance(fs::directory_iterator(out()), {}), 1);
  }
}

// A file size limit fails writes as a full disk does, for any user.
TEST_F(BadInput, AFullDiskLeavesNothingBehind) {
  copy_of_flight(folder_);
  const Outcome o = watersky("map '" + flight().string() + "' -o '" + out().string() + "'",
                             "trap '' XFSZ; ulimit -f 4; ");
  EXPECT_EQ(o.status, 1) << o.err;
  EXPECT_FALSE(fs::exists(out()));
  expect_nothing_written();
}

// A run that fails must not take what others put into the folders it had to make.
TEST_F(BadInput, AFailureTakesBackOnlyItsOwnFolders) {
  copy_of_flight(folder_);
  const fs::path deep = folder_.path() / "survey" / "today" / "map";
  const Outcome o = watersky("map '" + flight().string() + "' -o '" + deep.string() + "'",
                             "trap '' XFSZ; ulimit -f 4; ");
  EXPECT_EQ(o.status, 1) << o.err;
  expect_nothing_written();
}

TEST_F(BadInput, SimulateNeverReplacesARecording) {
  copy_of_flight(folder_);
  fs::remove(flight() / "simulation.txt");
  const Outcome o = watersky("simulate '" + flight().string() + "' --overwrite");
  expect_one_line_error(o, 1);
  EXPECT_TRUE(fs::exists(flight() / "flight.yaml"));
}

TEST_F(BadInput, CallsAtFaultEndWithStatus2) {
  copy_of_flight(folder_);
  for (const char* option : {"--cell-m 0", "--cell-m banana", "--sea-level high", "--mount 1,2",
                             "--ice purple", "--no-such-option", "--prior 1.5", "--focal-px -3",
                             "--focal-px nan", "--threads 1000000", "--projection EPSG:4326"}) {
    const Outcome o = map(option);
    EXPECT_EQ(o.status, 2) << option << ": " << o.err;
    EXPECT_FALSE(o.err.empty());
    expect_nothing_written();
  }
  EXPECT_EQ(watersky("").status, 2);
  EXPECT_EQ(watersky("sail").status, 2);
  EXPECT_EQ(watersky("map '" + flight().string() + "'").status, 2) << "-o is required";
}

TEST_F(BadInput, JsonCarriesTheErrorToo) {
  const Outcome o = map("--json");
  ASSERT_EQ(o.status, 1);
  const auto json = o.json();
  ASSERT_TRUE(json.is_object()) << o.out;
  EXPECT_EQ(json["error"]["code"], "not_found");
}

}  // namespace
}  // namespace watersky::test
