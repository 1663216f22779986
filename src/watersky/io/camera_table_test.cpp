// SPDX-License-Identifier: MIT
#include "watersky/io/camera_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace watersky {
namespace {

using ::testing::HasSubstr;

PhotoMetadata photo(const std::string& make, const std::string& model, int w, int h,
                    double focal_mm) {
  PhotoMetadata m;
  m.make = make;
  m.model = model;
  m.width_px = w;
  m.height_px = h;
  if (focal_mm > 0) m.focal_length_mm = focal_mm;
  return m;
}

// The focal length that the data's description gives for Brighton, "about 2340 px".
TEST(CameraTable, KnowsThePhantom3OfBrightonBeach) {
  const auto i = intrinsics_from(photo("DJI", "FC300S", 4000, 2250, 3.61));
  ASSERT_TRUE(i) << i.error().message;
  EXPECT_NEAR(i->camera.focal_px(), 2340, 5);
  EXPECT_THAT(i->source.description, HasSubstr("Phantom 3"));
  EXPECT_NEAR(i->source.focal_sigma_px, 0.02 * 2340, 1);
  EXPECT_EQ(i->camera.camera_matrix()(0, 2), 1999.5);
}

// The nominal intrinsics that come with cuav_flight: 3.04 mm over 2.24 µm binned pixels.
TEST(CameraTable, KnowsTheBinnedPiCameraHoweverItIsNamed) {
  for (const char* model : {"RP_imx219", "/base/soc/i2c0mux/i2c@1/imx219@10"}) {
    const auto i = intrinsics_from(photo("RaspberryPi", model, 1640, 1232, 0));
    ASSERT_TRUE(i) << i.error().message;
    EXPECT_NEAR(i->camera.focal_px(), 3.04 / 0.00224, 2);
  }
}

TEST(CameraTable, FocalLengthsOfFixedLensesAgreeWithPublishedCalibrations) {
  // Nominal focal lengths in pixels, by the makers: 8.8 mm over 2.41 µm and so on.
  EXPECT_NEAR(intrinsics_from(photo("DJI", "FC6310R", 5472, 3648, 8.8))->camera.focal_px(), 3650,
              30);
  EXPECT_NEAR(intrinsics_from(photo("Hasselblad", "L1D-20c", 5472, 3648, 10.26))->camera.focal_px(),
              4253, 40);
  EXPECT_NEAR(intrinsics_from(photo("DJI", "ZenmuseP1", 8192, 5460, 35))->camera.focal_px(), 7988,
              50);
}

TEST(CameraTable, TheMakersCalibrationGoesFirst) {
  PhotoMetadata m = photo("DJI", "FC6310R", 5472, 3648, 8.8);
  m.dewarp = {3678.87,  3671.84,     10.1,          27.29,     -0.268652,
              0.114663, 0.000015685, -0.0000460703, -0.0350261};
  const auto i = intrinsics_from(m).value();
  EXPECT_EQ(i.camera.camera_matrix()(0, 0), 3678.87);
  EXPECT_EQ(i.camera.camera_matrix()(1, 2), 1823.5 + 27.29);
  EXPECT_TRUE(i.camera.distorts());
  m.dewarped = true;
  EXPECT_FALSE(intrinsics_from(m)->camera.distorts());
  m.dewarp.clear();
  m.calibrated_focal_px = 3666.67;
  EXPECT_THAT(intrinsics_from(m)->source.description, HasSubstr("CalibratedFocalLength"));
}

TEST(CameraTable, UnknownCamerasGoByWhatExifSaysOrNotAtAll) {
  PhotoMetadata m = photo("Acme", "Eye 3", 4000, 3000, 5.0);
  const auto none = intrinsics_from(m);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::NotFound);
  EXPECT_THAT(none.error().message, HasSubstr("--camera"));
  EXPECT_THAT(none.error().message, HasSubstr("--focal-px"));
  m.focal_plane_px_per_mm = 500;
  EXPECT_NEAR(intrinsics_from(m)->camera.focal_px(), 2500, 1e-9);
  m.focal_plane_px_per_mm.reset();
  m.focal_length_35mm_mm = 43.27;
  EXPECT_NEAR(intrinsics_from(m)->camera.focal_px(), 5000, 1e-9);
  EXPECT_NEAR(intrinsics_from(m)->source.focal_sigma_px, 400, 1e-9);
  EXPECT_FALSE(intrinsics_from(photo("", "", 4000, 3000, 0)));
}

TEST(CameraTable, RefusesFisheyesAndCrops) {
  EXPECT_THAT(intrinsics_from(photo("GoPro", "HERO4 Black", 4000, 3000, 3)).error().message,
              HasSubstr("fisheye"));
  EXPECT_THAT(intrinsics_from(photo("DJI", "FC300S", 1000, 1000, 3.61)).error().message,
              HasSubstr("crop"));
}

TEST(CameraTable, AScaledCopyKeepsItsFieldOfView) {
  const double full = intrinsics_from(photo("DJI", "FC300S", 4000, 3000, 3.61))->camera.focal_px();
  EXPECT_NEAR(intrinsics_from(photo("DJI", "FC300S", 1000, 750, 3.61))->camera.focal_px(), full / 4,
              1e-9);
}

}  // namespace
}  // namespace watersky
