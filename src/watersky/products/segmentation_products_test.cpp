// SPDX-License-Identifier: MIT
#include "watersky/products/segmentation_products.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "support/temporary_folder.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/products/segmentation_pictures.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Left half water at `water`, right half ice at `ice`.
cv::Mat halves(float water, float ice, cv::Size size = {40, 30}) {
  cv::Mat p(size, CV_32F, cv::Scalar(water));
  p.colRange(size.width / 2, size.width).setTo(ice);
  return p;
}

SegmentedImage written(const fs::path& folder, const cv::Mat& p,
                       const ImageTruth* truth = nullptr) {
  SegmentedImage image;
  image.file = "some/pic,\"1\".jpg";
  image.stem = "pic";
  const Status status =
      write_segmented(folder, cv::Mat(p.size(), CV_8U, cv::Scalar(90)), p, truth, true, image);
  EXPECT_TRUE(status.ok()) << status.error().message;
  return image;
}

TEST(SegmentationPictures, ProbabilityIsRoundedAndTheUnknownIsNeutral) {
  const cv::Mat p = (cv::Mat_<float>(1, 6) << 0.0F, 1.0F, 0.7F, 0.4F, kNaN, 0.5F);
  const cv::Mat picture = probability_picture(p);
  const std::vector<unsigned char> values(picture.begin<unsigned char>(),
                                          picture.end<unsigned char>());
  EXPECT_THAT(values, ::testing::ElementsAre(0, 255, 179, 102, 128, 128));
  const cv::Mat unknown = unknown_picture(p);
  EXPECT_EQ(cv::countNonZero(unknown), 1);
  EXPECT_EQ(unknown.at<unsigned char>(0, 4), 255);
  EXPECT_TRUE(unknown_picture(cv::Mat(3, 3, CV_32F, cv::Scalar(0.5))).empty());
}

TEST(SegmentationPictures, OverlaysTintWaterLeaveIceAndOutlineIt) {
  const cv::Mat image(30, 40, CV_16U, cv::Scalar(30000));
  const cv::Mat p = halves(0.02F, 0.98F), picture = overlay_picture(image, p);
  ASSERT_EQ(picture.type(), CV_8UC3);
  ASSERT_EQ(picture.size(), image.size());
  const cv::Mat plain = displayed(image);
  EXPECT_EQ(picture.at<cv::Vec3b>(15, 35), plain.at<cv::Vec3b>(15, 35));
  EXPECT_NE(picture.at<cv::Vec3b>(15, 5), plain.at<cv::Vec3b>(15, 5));
  const cv::Vec3b outline(kIceOutline.blue, kIceOutline.green, kIceOutline.red);
  EXPECT_EQ(picture.at<cv::Vec3b>(15, 20), outline);
  // The edge of the picture is no edge of the ice.
  EXPECT_NE(picture.at<cv::Vec3b>(15, 39), outline);
}

TEST(SegmentationPictures, ErrorsAreColouredByTheirKind) {
  const cv::Mat image(30, 40, CV_8U, cv::Scalar(90));
  const cv::Mat p = halves(0.1F, 0.9F);
  cv::Mat ice = p > 0.5;
  const cv::Mat none = error_picture(image, p, ice);
  EXPECT_EQ(none.at<cv::Vec3b>(0, 0)[0], none.at<cv::Vec3b>(0, 0)[2]) << "gray where right";
  const cv::Mat all = error_picture(image, p, ~ice);
  EXPECT_LT(all.at<cv::Vec3b>(5, 35)[0], all.at<cv::Vec3b>(5, 35)[2]) << "false ice is red";
  EXPECT_GT(all.at<cv::Vec3b>(5, 5)[0], all.at<cv::Vec3b>(5, 5)[2]) << "missed ice is blue";
}

TEST(SegmentationProducts, AnImageHasItsFilesAndFigures) {
  const test::TemporaryFolder folder;
  const cv::Mat p = halves(0.25F, 0.75F);
  const ImageTruth truth{p > 0.5, {}};
  const SegmentedImage image = written(folder.path(), p, &truth);
  EXPECT_EQ(image.concentration, 0.5);
  EXPECT_EQ(image.mean_p_ice, 0.5);
  EXPECT_EQ(image.unknown_share, 0.0);
  ASSERT_TRUE(image.score);
  EXPECT_EQ(image.score->accuracy, 1.0);
  const cv::Mat ice = cv::imread((folder.path() / "pic_ice.png").string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(ice.type(), CV_8UC1);
  EXPECT_EQ(ice.size(), p.size());
  EXPECT_TRUE(fs::exists(folder.path() / "pic_overlay.jpg"));
  EXPECT_TRUE(fs::exists(folder.path() / "pic_errors.jpg"));
  EXPECT_FALSE(fs::exists(folder.path() / "pic_unknown.png"));
}

TEST(SegmentationProducts, NothingKnownIsNullAndNotHalf) {
  const test::TemporaryFolder folder;
  SegmentationRun run;
  run.images.push_back(written(folder.path(), cv::Mat(30, 40, CV_32F, cv::Scalar(kNaN))));
  EXPECT_TRUE(std::isnan(run.images[0].concentration));
  EXPECT_TRUE(fs::exists(folder.path() / "pic_unknown.png"));
  const auto json = segment_json(run);
  EXPECT_TRUE(json["images"][0]["concentration"].is_null());
  EXPECT_TRUE(json["figures"]["mean_concentration"].is_null());
  EXPECT_EQ(json["images"][0]["unknown_share"], 1.0);
  EXPECT_THAT(segmentation_report_html(run), HasSubstr("nothing known"));
}

TEST(SegmentationProducts, AllWaterIsNoneAndAllIceIsAll) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(written(folder.path(), cv::Mat(9, 9, CV_32F, cv::Scalar(0.4))).concentration, 0.0);
  EXPECT_EQ(written(folder.path(), cv::Mat(9, 9, CV_32F, cv::Scalar(0.7))).concentration, 1.0);
}

TEST(SegmentationProducts, ATruthThatDoesNotFitIsAFaultOfTheTruth) {
  const test::TemporaryFolder folder;
  const ImageTruth truth{cv::Mat(9, 9, CV_8U, cv::Scalar(0)), {}};
  const SegmentedImage image = written(folder.path(), halves(0.4F, 0.7F), &truth);
  EXPECT_FALSE(image.score);
  EXPECT_THAT(image.truth_fault, HasSubstr("9x9"));
  EXPECT_TRUE(fs::exists(folder.path() / "pic_ice.png"));
}

TEST(SegmentationProducts, TheSummaryAgreesWithItself) {
  const test::TemporaryFolder folder;
  SegmentationRun run;
  run.truth = "masks";
  const cv::Mat p = halves(0.4F, 0.7F);
  cv::Mat ice = p > 0.5;
  ice.rowRange(0, 15).setTo(0);
  const ImageTruth truth{ice, {}};
  run.images.push_back(written(folder.path(), p, &truth));
  run.left_out.push_back({"<bad>.jpg", "is no image"});
  ASSERT_TRUE(write_segmentation_summary(folder.path(), run).ok());
  const auto json = nlohmann::json::parse(std::ifstream(folder.path() / "segment.json"));
  EXPECT_EQ(json["figures"]["accuracy"], 0.75);
  EXPECT_EQ(json["left_out"][0]["reason"], "is no image");
  EXPECT_EQ(json["reliability"].size(), 2u);

  const auto csv = CsvTable::parse(segmentation_csv(run), "segmentation.csv").value();
  ASSERT_EQ(csv.rows(), 1u);
  EXPECT_EQ(csv.cell(0, *csv.column("file")), "some/pic,\"1\".jpg");
  EXPECT_EQ(csv.number(0, *csv.column("accuracy")).value(), 0.75);
  EXPECT_EQ(csv.number(0, *csv.column("concentration_error")).value(), 0.25);

  const std::string html = segmentation_report_html(run);
  EXPECT_THAT(html, HasSubstr("&lt;bad&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<bad>")));
  EXPECT_THAT(html, HasSubstr("Reliability diagram"));
  EXPECT_THAT(html, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST(SegmentationProducts, ReplacesOnlyWhatIsItsOwn) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(check_segment_output(folder.path() / "new", false).ok());
  EXPECT_TRUE(check_segment_output(folder.path(), false).ok()) << "empty";
  std::ofstream(folder.path() / "letters.txt") << "dear";
  EXPECT_EQ(check_segment_output(folder.path(), false).error().code, ErrorCode::Exists);
  EXPECT_EQ(check_segment_output(folder.path(), true).error().code, ErrorCode::Exists);
  ASSERT_TRUE(write_segmentation_summary(folder.path(), SegmentationRun{}).ok());
  EXPECT_EQ(check_segment_output(folder.path(), false).error().code, ErrorCode::Exists);
  EXPECT_TRUE(check_segment_output(folder.path(), true).ok());
}

}  // namespace
}  // namespace watersky
