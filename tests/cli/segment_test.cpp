// SPDX-License-Identifier: MIT
/// `watersky segment` on images that are right and on images that are not.
#include <gmock/gmock.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cli_support.hpp"
#include "support/real_data.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

class Segment : public ::testing::Test {
 protected:
  Segment() {
    fs::create_directories(images());
    fs::create_directories(masks());
  }
  [[nodiscard]] fs::path images() const { return folder_.path() / "images"; }
  [[nodiscard]] fs::path masks() const { return folder_.path() / "masks"; }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }
  [[nodiscard]] fs::path other() const { return folder_.path() / "other"; }

  static void write(const fs::path& file, const cv::Mat& image) {
    ASSERT_TRUE(cv::imwrite(file.string(), image));
  }
  [[nodiscard]] static cv::Mat read(const fs::path& file) {
    return cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  }

  /// Round floes on noisy water: the image and its mask, 255 where ice.
  static std::pair<cv::Mat, cv::Mat> scene(int seed, double water = 70, double contrast = 90,
                                           int type = CV_8U) {
    cv::RNG rng(static_cast<std::uint64_t>(seed));
    cv::Mat ice(160, 200, CV_8U, cv::Scalar(0));
    for (int i = 0; i < 14; ++i)
      cv::circle(ice, {rng.uniform(0, 200), rng.uniform(0, 160)}, rng.uniform(6, 22), 255, -1);
    cv::Mat level(ice.size(), CV_32F, cv::Scalar(water)), noise(ice.size(), CV_32F), image;
    level.setTo(water + contrast, ice);
    rng.fill(noise, cv::RNG::NORMAL, 0.0, 0.06 * std::abs(contrast));
    cv::Mat(level + noise).convertTo(image, type);
    return {image, ice};
  }
  void write_scene(const std::string& stem, int seed) const {
    const auto [image, ice] = scene(seed);
    write(images() / (stem + ".png"), image);
    write(masks() / (stem + ".png"), ice);
  }
  [[nodiscard]] Outcome segment(const std::string& options = "") const {
    return watersky("segment '" + images().string() + "' -o '" + out().string() + "' --json " +
                    options);
  }
  [[nodiscard]] std::string truth() const { return "--truth '" + masks().string() + "' "; }

  TemporaryFolder folder_;
};

TEST_F(Segment, WritesWhatItsHelpPromises) {
  write_scene("a", 1);
  write_scene("b", 2);
  const Outcome o = segment(truth() + "--ice brighter --method otsu");
  ASSERT_EQ(o.status, 0) << o.err;
  const auto json = o.json();
  EXPECT_EQ(json["images"].size(), 2u);
  EXPECT_GT(json["figures"]["accuracy"], 0.97);
  EXPECT_GT(json["figures"]["iou"], 0.9);
  EXPECT_LT(json["figures"]["concentration_error"], 0.03);
  EXPECT_EQ(nlohmann::json::parse(read_text(out() / "segment.json"))["figures"], json["figures"]);
  for (const char* stem : {"a", "b"}) {
    const cv::Mat ice = read(out() / (std::string(stem) + "_ice.png"));
    EXPECT_EQ(ice.type(), CV_8UC1);
    EXPECT_EQ(ice.size(), cv::Size(200, 160));
    EXPECT_EQ(cv::countNonZero((ice != 179) & (ice != 102)), 0) << "round(255 · 0.7 and 0.4)";
    EXPECT_FALSE(read(out() / (std::string(stem) + "_overlay.jpg")).empty());
  }
  EXPECT_THAT(read_text(out() / "report.html"), HasSubstr("Reliability diagram"));
  EXPECT_THAT(read_text(out() / "segmentation.csv"), HasSubstr("concentration"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 3)
      << "images, masks and out: no temporary folder stays";
}

TEST_F(Segment, EveryMethodFindsTheSameFloes) {
  write_scene("a", 3);
  for (const char* method :
       {"learned", "learned-fast", "learned-best", "otsu", "local-otsu", "edges", "watershed"}) {
    const Outcome o =
        segment(truth() + "--ice brighter --overwrite --method " + std::string(method));
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_EQ(o.json()["method"], method);
    EXPECT_GT(o.json()["figures"]["accuracy"], 0.97) << method;
  }
  const Outcome o = segment("--method magic");
  expect_one_line_error(o, 2);
  EXPECT_THAT(o.err, HasSubstr("watershed"));
}

TEST_F(Segment, AnImagesResultDependsOnItAlone) {
  for (int i = 0; i < 4; ++i) write_scene("s" + std::to_string(i), 10 + i);
  write(images() / "water.png", scene(9, 70, 0.0).first + 5);
  ASSERT_EQ(segment().status, 0);
  for (const char* stem : {"s2", "water"}) {
    fs::remove_all(other());
    ASSERT_EQ(watersky("segment '" + (images() / (std::string(stem) + ".png")).string() + "' -o '" +
                       other().string() + "' --threads 1")
                  .status,
              0);
    const std::string file = std::string(stem) + "_ice.png";
    EXPECT_TRUE(read_text(out() / file) == read_text(other() / file)) << stem;
  }
}

TEST_F(Segment, ASequenceTellsItsImagesOfOneClass) {
  for (int i = 0; i < 4; ++i) write_scene("s" + std::to_string(i), 20 + i);
  cv::Mat water(160, 200, CV_8U);
  cv::randn(water, 70, 5);
  write(images() / "water.png", water);
  const auto concentration = [&](const Outcome& o) {
    const auto json = o.json();
    for (const auto& image : json["images"])
      if (image["stem"] == "water") return image["concentration"];
    return nlohmann::json("missing");
  };
  EXPECT_TRUE(concentration(segment("--method otsu --ice brighter")).is_null());
  EXPECT_TRUE(fs::exists(out() / "water_unknown.png"));
  const auto known = concentration(segment("--method otsu --ice brighter --sequence --overwrite"));
  ASSERT_TRUE(known.is_number());
  EXPECT_LT(known.get<double>(), 0.01);
  EXPECT_FALSE(fs::exists(out() / "water_unknown.png"));
}

TEST_F(Segment, SixteenBitsAndColourAsWellAsGray) {
  const auto [deep, ice] = scene(4, 21000, 900, CV_16U);
  write(images() / "deep.tif", deep);
  write(masks() / "deep.png", ice);
  cv::Mat colour(ice.size(), CV_8UC3, cv::Scalar(90, 70, 30));
  colour.setTo(cv::Scalar(225, 215, 205), ice);
  cv::GaussianBlur(colour, colour, {3, 3}, 0);
  write(images() / "colour.jpg", colour);
  write(masks() / "colour.png", ice);
  const Outcome o = segment(truth() + "--ice brighter --method otsu");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_GT(o.json()["figures"]["worst_accuracy"], 0.97);
}

TEST_F(Segment, ConstantAndSaturatedImagesAreNotKnown) {
  write(images() / "black.png", cv::Mat(40, 50, CV_8U, cv::Scalar(0)));
  write(images() / "saturated.png", cv::Mat(40, 50, CV_8UC3, cv::Scalar::all(255)));
  write(images() / "warm.tif", cv::Mat(40, 50, CV_16U, cv::Scalar(30000)));
  const Outcome o = segment();
  ASSERT_EQ(o.status, 0) << o.err;
  const auto json = o.json();
  for (const auto& image : json["images"]) {
    EXPECT_TRUE(image["concentration"].is_null()) << image["stem"];
    EXPECT_EQ(image["unknown_share"], 1.0);
    const cv::Mat ice = read(out() / (image["stem"].get<std::string>() + "_ice.png"));
    EXPECT_EQ(cv::countNonZero(ice != 128), 0);
  }
}

TEST_F(Segment, EqualStemsAreRefusedBeforeAnythingIsDone) {
  write_scene("a", 5);
  write(images() / "a.jpg", scene(6).first);
  const Outcome o = segment();
  expect_one_line_error(o, 2);
  EXPECT_THAT(o.err, HasSubstr("a_ice.png"));
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(Segment, OneBadImageDoesNotStopTheOthers) {
  write_scene("a", 7);
  write_text(images() / "bad.jpg", "no image");
  const Outcome o = segment();
  EXPECT_EQ(o.status, 1);
  EXPECT_EQ(o.json()["images"].size(), 1u);
  ASSERT_EQ(o.json()["left_out"].size(), 1u);
  EXPECT_THAT(o.json()["left_out"][0]["file"].get<std::string>(), HasSubstr("bad.jpg"));
  EXPECT_THAT(o.err, HasSubstr("bad.jpg"));
  EXPECT_TRUE(fs::exists(out() / "a_ice.png"));
  EXPECT_FALSE(fs::exists(out() / "bad_ice.png"));
}

TEST_F(Segment, NothingButBadImagesIsAnErrorAndLeavesNothing) {
  write_text(images() / "bad.png", "no image");
  const Outcome o = segment();
  expect_one_line_error(o, 1);
  EXPECT_THAT(o.err, HasSubstr("bad.png"));
  EXPECT_FALSE(fs::exists(out()));
  fs::remove(images() / "bad.png");
  expect_one_line_error(segment(), 1);
  expect_one_line_error(watersky("segment /no/such/image.png -o '" + out().string() + "'"), 1);
  expect_one_line_error(watersky("segment -o '" + out().string() + "'"), 2);
  expect_one_line_error(watersky("segment '" + images().string() + "'"), 2);
}

TEST_F(Segment, MasksThatDoNotFitAreNamedAndTheRestIsScored) {
  write_scene("a", 8);
  write_scene("b", 9);
  write_scene("c", 10);
  write_scene("d", 11);
  write(masks() / "b.png", cv::Mat(10, 20, CV_8U, cv::Scalar(1)));
  write(masks() / "c.png", cv::Mat(160, 200, CV_16U, cv::Scalar(1)));
  fs::remove(masks() / "d.png");
  const Outcome o = segment(truth());
  EXPECT_EQ(o.status, 1);
  EXPECT_EQ(o.json()["images"].size(), 4u);
  EXPECT_EQ(o.json()["figures"]["scored_images"], 1);
  EXPECT_THAT(o.err, HasSubstr("20x10"));
  EXPECT_THAT(o.err, HasSubstr("8 bit"));
  EXPECT_THAT(o.err, HasSubstr("d.png: there is no mask"));
  EXPECT_EQ(o.json()["images"][0]["score"]["pixels"], 160 * 200);
  EXPECT_TRUE(o.json()["images"][1]["score"].is_null());
  expect_one_line_error(segment("--overwrite --truth /no/such/masks"), 1);
}

TEST_F(Segment, PondsCountAsTheUserSays) {
  const auto [image, ice] = scene(12);
  write(images() / "a.png", image);
  cv::Mat classes(ice.size(), CV_8U, cv::Scalar(2));
  classes.setTo(1, ice);
  classes.rowRange(0, 40).setTo(0);
  write(masks() / "a.png", classes);
  const auto water = segment(truth() + "--ice brighter");
  const auto pond = segment(truth() + "--ice brighter --pond-is ice --overwrite");
  const auto concentration = [](const Outcome& o) {
    return o.json()["images"][0]["score"]["true_concentration"].get<double>();
  };
  EXPECT_NEAR(concentration(pond) - concentration(water), 0.25, 1e-9);
  EXPECT_EQ(pond.json()["pond_is"], "ice");
}

TEST_F(Segment, AMaskedPartIsNeitherSegmentedNorScored) {
  const auto [image, ice] = scene(13);
  cv::Mat ship = image.clone();
  ship.colRange(0, 60).setTo(255);
  write(images() / "a.png", ship);
  write(masks() / "a.png", ice);
  cv::Mat sea(image.size(), CV_8U, cv::Scalar(255));
  sea.colRange(0, 60).setTo(0);
  write(folder_.path() / "sea.png", sea);
  const std::string mask = "--mask '" + (folder_.path() / "sea.png").string() + "' ";
  const Outcome o = segment(truth() + mask + "--ice brighter --method otsu");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.json()["images"][0]["score"]["pixels"], 160 * 140);
  EXPECT_GT(o.json()["figures"]["accuracy"], 0.97);
  const cv::Mat unknown = read(out() / "a_unknown.png");
  EXPECT_EQ(cv::countNonZero(unknown), 160 * 60);
  write(folder_.path() / "sea.png", cv::Mat(9, 9, CV_8U, cv::Scalar(255)));
  const Outcome small = segment(mask + "--overwrite");
  expect_one_line_error(small, 1);
  EXPECT_THAT(small.err, HasSubstr("9x9"));
}

TEST_F(Segment, ReplacesOnlyARunOfOursAndOnlyWhenTold) {
  write_scene("a", 14);
  ASSERT_EQ(segment().status, 0);
  expect_one_line_error(segment(), 1);
  EXPECT_EQ(segment("--overwrite").status, 0);
  fs::remove_all(out());
  fs::create_directory(out());
  EXPECT_EQ(segment().status, 0) << "an empty folder may be filled";
  fs::remove_all(out());
  fs::create_directory(out());
  write_text(out() / "letter.txt", "dear");
  expect_one_line_error(segment("--overwrite"), 1);
  EXPECT_TRUE(fs::exists(out() / "letter.txt"));
}

TEST_F(Segment, TrainMakesAModelThatSegmentUses) {
  for (int i = 0; i < 3; ++i) write_scene("t" + std::to_string(i), 30 + i);
  write(images() / "unlabelled.png", scene(40).first);
  const fs::path model = folder_.path() / "my.ice-model";
  const std::string train =
      "segment train '" + images().string() + "' '" + masks().string() +
      "' --mask-values binary --variants 3 --drawn 8 --samples 300 --passes 6 "
      "--json -o '" +
      model.string() + "' ";
  const Outcome o = watersky(train);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.json()["images"], 4);
  EXPECT_EQ(o.json()["with_mask"], 3);
  expect_one_line_error(watersky(train), 2);
  const std::string first = read_text(model);
  ASSERT_EQ(watersky(train + "--overwrite").status, 0);
  EXPECT_EQ(read_text(model), first) << "the same images and parameters give the same model";

  const std::string use = truth() + "--ice brighter --model '" + model.string() + "' ";
  const Outcome segmented = segment(use);
  EXPECT_EQ(segmented.json()["model"], model.string());
  EXPECT_GT(segmented.json()["figures"]["accuracy"], 0.95);
  expect_one_line_error(segment(use + "--overwrite --method otsu"), 2);
}

TEST_F(Segment, AModelThatIsNotOneIsToldByItsFault) {
  write_scene("a", 33);
  const fs::path model = folder_.path() / "bad.ice-model";
  const auto fault = [&](const std::string& text) {
    write_text(model, text);
    const Outcome o = segment("--model '" + model.string() + "'");
    expect_one_line_error(o, 1);
    EXPECT_THAT(o.err, HasSubstr("bad.ice-model"));
    EXPECT_FALSE(fs::exists(out()));
    return o.err;
  };
  EXPECT_THAT(fault("hello"), HasSubstr("not a Watersky ice model"));
  EXPECT_THAT(fault("watersky ice model 99\n"), HasSubstr("version"));
  EXPECT_THAT(fault("watersky ice model 1\nfeatures 1\n"), HasSubstr("cut short"));
  expect_one_line_error(segment("--model /no/such.ice-model"), 1);
}

TEST(SegmentReal, OtsuFindsThePolarityOfEveryThermalImage) {
  const auto data = real_data("tir_sea_ice");
  if (!data) GTEST_SKIP() << "the labelled thermal images are not here";
  const TemporaryFolder folder;
  const Outcome o = watersky("segment '" + (*data / "images").string() + "' -o '" +
                             (folder.path() / "out").string() + "' --method otsu --truth '" +
                             (*data / "masks").string() + "' --json");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.json()["figures"]["images"], 11);
  EXPECT_GT(o.json()["figures"]["accuracy"], 0.89);
  EXPECT_GT(o.json()["figures"]["iou"], 0.85);
  EXPECT_GT(o.json()["figures"]["worst_accuracy"], 0.7);
}

}  // namespace
}  // namespace watersky::test
