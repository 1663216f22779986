// SPDX-License-Identifier: MIT
#pragma once
/// What the benchmarks of the map share: a camera over a flat sea, and something to see.
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/geo/rotation.hpp"
#include "watersky/map/grid_view.hpp"
#include "watersky/map/position_uncertainty.hpp"

namespace watersky::bench {

inline CameraModel pinhole(int width, int height) {
  Eigen::Matrix3d a;
  a << 0.9 * width, 0, 0.5 * width - 0.5, 0, 0.9 * width, 0.5 * height - 0.5, 0, 0, 1;
  return CameraModel::make(LensModel::Pinhole, width, height, a).value();
}

/// Cell (0, 0)'s north-west corner at (north_m, east_m) of the sea under the first camera.
inline Eigen::Matrix3d sea_from_grid(double cell_m, double north_m, double east_m) {
  Eigen::Matrix3d m;
  m << 0, -cell_m, north_m - 0.5 * cell_m, cell_m, 0, east_m + 0.5 * cell_m, 0, 0, 1;
  return m;
}

/// Grey levels of floes: smooth, with a threshold of 127 half ice.
inline cv::Mat floes(int width, int height) {
  cv::Mat noise(height, width, CV_8U);
  cv::randu(noise, 0, 256);
  cv::blur(noise, noise, {15, 15});
  return noise;
}

/// How uncertain places are by a camera at a height whose position is known to 1 m and whose
/// attitude to 1°: as mapping carries a pose's covariance to the sea, so at its cost.
inline PositionCovariance place_covariance(const Rigid3<Sea, Camera>& pose, const GridView& grid) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  covariance.bottomRightCorner<3, 3>() *= std::pow(0.01745, 2);
  const Eigen::Matrix2d cells_from_m = grid.sea_from_grid.topLeftCorner<2, 2>().inverse();
  return [=, &grid](const Eigen::Vector2d& at) -> Eigen::Matrix2d {
    const Eigen::Vector2d place = (grid.sea_from_grid * at.homogeneous()).head<2>();
    const Eigen::Vector3d& camera = pose.origin().v;
    const Eigen::Vector3d ray(place.x() - camera.x(), place.y() - camera.y(), -camera.z());
    Eigen::Matrix<double, 3, 6> moved;
    moved << Eigen::Matrix3d::Identity(), -skew(ray);
    Eigen::Matrix<double, 2, 3> to_sea;
    to_sea << 1, 0, -ray.x() / ray.z(), 0, 1, -ray.y() / ray.z();
    const Eigen::Matrix<double, 2, 6> by_pose = cells_from_m * to_sea * moved;
    return by_pose * covariance * by_pose.transpose();
  };
}

}  // namespace watersky::bench
