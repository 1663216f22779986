// SPDX-License-Identifier: MIT
#pragma once
/// What the tests and benchmarks of this folder share.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>

#include "support/temporary_folder.hpp"
#include "watersky/products/products.hpp"

namespace watersky::test {

/// Round floes of a power-law size distribution: 255 ice, 0 water.
inline cv::Mat drawn_floes(int rows, int columns, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1);
  cv::Mat ice(rows, columns, CV_8U, cv::Scalar(0));
  for (int i = 0; i < count; ++i) {
    const double radius = 2.5 / std::sqrt(1 - 0.998 * u(random));
    cv::ellipse(
        ice, {static_cast<int>(columns * u(random)), static_cast<int>(rows * u(random))},
        {static_cast<int>(radius + 1), static_cast<int>(radius * (0.5 + 0.5 * u(random)) + 1)},
        180 * u(random), 0, 360, cv::Scalar(255), cv::FILLED);
  }
  return ice;
}

/// Products as a survey of four legs near Ny-Ålesund (UTM 33) would leave them: the sea of `ice`
/// (255 ice), seen in overlapping footprints turned by 12°.
inline Products survey_products(const cv::Mat& ice, double cell_m, unsigned seed = 1) {
  const Projection projection = Projection::from_text("EPSG:32633").value();
  const Geodetic datum{Angle::degrees(78.9), Angle::degrees(11.9), 30.0};
  const Eigen::Vector2d centre = projection.forward(datum.latitude, datum.longitude).value();
  Products p(projection);
  p.flight_name = "Kongsfjorden <survey & test>";
  p.geotransform = {std::round(centre.x() - 0.5 * ice.cols * cell_m), cell_m, 0.0,
                    std::round(centre.y() + 0.5 * ice.rows * cell_m), 0.0,    -cell_m};
  p.datum = Datum(datum);

  cv::Mat looks(ice.size(), CV_16U, cv::Scalar(0));
  cv::Mat seen_s(ice.size(), CV_64F, cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
  constexpr double kStart_s = 1533430844.8;
  constexpr int kLegs = 4;
  constexpr int kFramesPerLeg = 7;
  const double leg_cells = 0.20 * ice.rows;
  for (int leg = 0; leg < kLegs; ++leg) {
    for (int i = 0; i < kFramesPerLeg; ++i) {
      const int step = leg % 2 == 0 ? i : kFramesPerLeg - 1 - i;
      const cv::RotatedRect seen(
          cv::Point2f(
              static_cast<float>(ice.cols * (0.17 + 0.66 * step / (kFramesPerLeg - 1)) + 12 * leg),
              static_cast<float>(ice.rows * 0.2 + leg * leg_cells)),
          cv::Size2f(static_cast<float>(0.21 * ice.cols), static_cast<float>(1.3 * leg_cells)),
          static_cast<float>(4 + leg));
      cv::Point2f corner[4];
      seen.points(corner);
      std::vector<cv::Point> polygon;
      std::vector<Eigen::Vector2d> footprint;
      for (const cv::Point2f& c : corner) {
        polygon.emplace_back(cvRound(c.x), cvRound(c.y));
        footprint.push_back(p.easting_northing_m({c.x, c.y}));
      }
      cv::Mat mask(ice.size(), CV_8U, cv::Scalar(0));
      cv::fillConvexPoly(mask, polygon, cv::Scalar(255));
      cv::add(looks, cv::Scalar(1), looks, mask);
      const double time_s = kStart_s + 2.5 * (leg * kFramesPerLeg + i);
      seen_s.setTo(cv::Scalar(time_s), mask);
      const Geodetic place =
          projection.inverse(p.easting_northing_m({seen.center.x, seen.center.y})).value();
      const double tilt = 0.02 * (leg + 1);
      p.used.push_back({.file = "frame_" + std::to_string(leg * kFramesPerLeg + i) + ".jpg",
                        .time = *time_from_seconds(time_s),
                        .camera = place,
                        .optical_axis = {0.0, -std::sin(tilt), std::cos(tilt)},
                        .footprint_easting_northing_m = footprint,
                        .gsd_m = 0.05,
                        .height_above_sea_m = 100.0 + leg,
                        .ice_fraction = 0.4});
    }
  }
  cv::RNG noise(seed);
  cv::Mat log_odds(ice.size(), CV_32F);
  cv::Mat grain(ice.size(), CV_32F);
  noise.fill(grain, cv::RNG::NORMAL, 0.0, 1.0);
  cv::GaussianBlur(grain, grain, {5, 5}, 1.0);
  p.rasters.probability.create(ice.size(), CV_32F);
  p.mosaic_bgra.create(ice.size(), CV_8UC4);
  for (int r = 0; r < ice.rows; ++r)
    for (int c = 0; c < ice.cols; ++c) {
      const int n = looks.at<std::uint16_t>(r, c);
      const bool is_ice = ice.at<std::uint8_t>(r, c) > 127;
      const float g = grain.at<float>(r, c);
      const double l = n * ((is_ice ? 0.85 : -0.75) + 0.35 * static_cast<double>(g));
      p.rasters.probability.at<float>(r, c) = n == 0 ? std::numeric_limits<float>::quiet_NaN()
                                                     : static_cast<float>(1 / (1 + std::exp(-l)));
      const auto shade = [&](double water, double white) {
        return cv::saturate_cast<std::uint8_t>((is_ice ? white : water) +
                                               14 * static_cast<double>(g));
      };
      p.mosaic_bgra.at<cv::Vec4b>(r, c) =
          n == 0 ? cv::Vec4b(0, 0, 0, 0)
                 : cv::Vec4b(shade(78, 232), shade(60, 228), shade(38, 220), 255);
    }
  p.rasters.looks = looks;
  p.rasters.last_seen_s = seen_s;
  p.left_out = {{"frame_28.jpg", "no pose within 0.5 s: the log ends 3.2 s before"},
                {"frame_29.jpg", "no pose within 0.5 s: the log ends 3.2 s before"},
                {"<b>bad</b>.jpg", "truncated JPEG & \"unreadable\""}};
  p.frames_total = p.used.size() + p.left_out.size();
  p.notes = {"The mount was not given: straight down, image top forward, was assumed.",
             "Ice was found to be brighter than water."};
  p.calibration = "camera.yaml";
  p.sea_level = "30.0 m below the datum";
  p.mapping_wall_s = 1.25;
  analyse(p);
  return p;
}

}  // namespace watersky::test
