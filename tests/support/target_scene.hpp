// SPDX-License-Identifier: MIT
#pragma once
/// Views of calibration targets by known cameras, drawn ray by ray, and the same as bare points.
#include <Eigen/Dense>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "watersky/target_calibration/target_calibration.hpp"

namespace watersky::test {

struct ScenePose {
  Eigen::Matrix3d rotation;  ///< camera_from_target
  Eigen::Vector3d translation;
};

/// A target of this kind whose parts are seen at these levels.
struct Scene {
  TargetKind kind = TargetKind::Chessboard;
  TargetSize size{9, 6};
  double radius = 0.3;   ///< of circles, in spacings
  double board = 200;    ///< level of the board's ground
  double pattern = 40;   ///< of its dark squares or its circles
  double around = 110;   ///< of what is behind it
  double gradient = 0;   ///< levels from one side of the image to the other
  double noise = 1.5;    ///< sigma, levels
  double blur_px = 0.7;  ///< sigma, besides the pixel's own width
  double motion_px = 0;  ///< a smear along rows
};

inline CameraModel pinhole(double focal_px, std::vector<double> distortion, int width = 640,
                           int height = 480, double right = 6, double down = -4) {
  Eigen::Matrix3d a;
  a << focal_px, 0, 0.5 * (width - 1) + right, 0, focal_px * 1.002, 0.5 * (height - 1) + down, 0, 0,
      1;
  return CameraModel::make(LensModel::Pinhole, width, height, a, std::move(distortion)).value();
}

inline CameraModel fisheye(double focal_px, std::vector<double> distortion, int width = 640,
                           int height = 480) {
  Eigen::Matrix3d a;
  a << focal_px, 0, 0.5 * (width - 1) - 3, 0, focal_px, 0.5 * (height - 1) + 5, 0, 0, 1;
  return CameraModel::make(LensModel::Fisheye, width, height, a, std::move(distortion)).value();
}

/// Where the target's points are, in spacings, as detect_target() counts them.
inline std::vector<Eigen::Vector2d> points_of(TargetKind kind, TargetSize size) {
  std::vector<Eigen::Vector2d> points;
  for (int row = 0; row < size.rows; ++row)
    for (int column = 0; column < size.columns; ++column)
      points.emplace_back(kind == TargetKind::AsymmetricCircles ? 2 * column + row % 2 : column,
                          row);
  return points;
}

inline Eigen::Vector2d middle_of(TargetKind kind, TargetSize size) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  const auto points = points_of(kind, size);
  for (const auto& p : points) sum += p / static_cast<double>(points.size());
  return sum;
}

/// The target's middle at `pixel`, `distance` spacings off, tilted about an axis in the image.
inline ScenePose pose_at(const CameraModel& camera, const Pixel& pixel, double distance,
                         double tilt_deg, double axis_deg, double turn_deg,
                         const Eigen::Vector2d& middle) {
  constexpr double kRadians = M_PI / 180;
  const Eigen::Vector3d axis(std::cos(axis_deg * kRadians), std::sin(axis_deg * kRadians), 0);
  ScenePose pose;
  pose.rotation = (Eigen::AngleAxisd(tilt_deg * kRadians, axis) *
                   Eigen::AngleAxisd(turn_deg * kRadians, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation = camera.direction(pixel)->v * distance - pose.rotation.leftCols<2>() * middle;
  return pose;
}

/// Views as somebody would take them who read docs/calibration.md: all over the image, tilted to
/// all sides. `fill`: how much of the image's height the target takes.
inline std::vector<ScenePose> good_poses(const CameraModel& camera, TargetKind kind,
                                         TargetSize size, int count, double fill = 0.5) {
  std::vector<ScenePose> poses;
  const auto middle = middle_of(kind, size);
  const double wide = (kind == TargetKind::AsymmetricCircles ? 2 : 1) * size.columns + 1;
  for (int i = 0; i < count; ++i) {
    const double u = 0.5 + 0.27 * std::cos(2.4 * i) * std::min(1.0, 0.4 + 0.12 * i);
    const double v = 0.5 + 0.25 * std::sin(2.4 * i) * std::min(1.0, 0.4 + 0.12 * i);
    const double distance =
        wide * camera.focal_px() / (fill * camera.height_px() * 4 / 3) * (1 + 0.12 * (i % 3));
    poses.push_back(pose_at(camera, {u * (camera.width_px() - 1), v * (camera.height_px() - 1)},
                            distance, 12 + 11 * (i % 4), 137.5 * i, (i % 3 - 1) * 12.0, middle));
  }
  return poses;
}

/// What a camera sees, drawn with 5 x 5 rays a pixel.
class TargetRenderer {
 public:
  explicit TargetRenderer(const CameraModel& camera) : camera_(camera) {
    // Rays are bent so little between neighbours that every second will do: 1e-3 px.
    const int rows = camera.height_px() / kStep + 2, cols = camera.width_px() / kStep + 2;
    rays_.create(rows, cols, CV_64FC3);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        const auto d = camera.direction({x * double{kStep} - 1, y * double{kStep} - 1});
        rays_.at<cv::Vec3d>(y, x) = d ? cv::Vec3d(d->v.x(), d->v.y(), d->v.z()) : cv::Vec3d();
      }
  }

  /// CV_32F.
  [[nodiscard]] cv::Mat render(const Scene& scene, const ScenePose& pose, unsigned seed) const {
    Eigen::Matrix3d target_from_ray;
    target_from_ray << pose.rotation.leftCols<2>(), pose.translation;
    target_from_ray = target_from_ray.inverse().eval();
    cv::Mat image(camera_.height_px(), camera_.width_px(), CV_32F);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const auto level = [&](double u, double v) {
          const double gx = (u + 1) / kStep, gy = (v + 1) / kStep;
          const int ix = static_cast<int>(gx), iy = static_cast<int>(gy);
          const double fx = gx - ix, fy = gy - iy;
          const cv::Vec3d d = (1 - fy) * ((1 - fx) * rays_.at<cv::Vec3d>(iy, ix) +
                                          fx * rays_.at<cv::Vec3d>(iy, ix + 1)) +
                              fy * ((1 - fx) * rays_.at<cv::Vec3d>(iy + 1, ix) +
                                    fx * rays_.at<cv::Vec3d>(iy + 1, ix + 1));
          const Eigen::Vector3d q = target_from_ray * Eigen::Vector3d(d[0], d[1], d[2]);
          return q.z() > 1e-9 ? level_at(scene, q.x() / q.z(), q.y() / q.z()) : scene.around;
        };
        // Where the pixel's corners agree there is nothing to divide.
        const double first = level(x - 0.45, y - 0.45);
        double sum = first;
        if (first == level(x + 0.45, y - 0.45) && first == level(x - 0.45, y + 0.45) &&
            first == level(x + 0.45, y + 0.45) && first == level(x, y)) {
          image.at<float>(y, x) = static_cast<float>(first);
        } else {
          sum = 0;
          for (int i = 0; i < kRays * kRays; ++i)
            sum += level(x + (i % kRays + 0.5) / kRays - 0.5, y + (i / kRays + 0.5) / kRays - 0.5);
          image.at<float>(y, x) = static_cast<float>(sum / (kRays * kRays));
        }
        image.at<float>(y, x) +=
            static_cast<float>(scene.gradient * (0.6 * x / image.cols + 0.4 * y / image.rows));
      }
    if (scene.blur_px > 0) cv::GaussianBlur(image, image, {}, scene.blur_px);
    if (scene.motion_px > 0) cv::blur(image, image, {static_cast<int>(scene.motion_px), 1});
    cv::Mat noise(image.size(), CV_32F);
    cv::RNG rng(seed);
    rng.fill(noise, cv::RNG::NORMAL, 0.0, scene.noise);
    return image + noise;
  }

 private:
  static constexpr int kStep = 2, kRays = 5;

  static double level_at(const Scene& scene, double x, double y) {
    const bool staggered = scene.kind == TargetKind::AsymmetricCircles;
    const double right = staggered ? 2 * scene.size.columns - 1 : scene.size.columns - 1;
    const double bottom = scene.size.rows - 1;
    const double margin = scene.kind == TargetKind::Chessboard ? 1.5 : 1.0;
    if (x < -margin || y < -margin || x > right + margin || y > bottom + margin)
      return scene.around;
    if (scene.kind == TargetKind::Chessboard) {
      if (x < -1 || y < -1 || x > right + 1 || y > bottom + 1) return scene.board;
      const int square = static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y));
      return square % 2 == 0 ? scene.pattern : scene.board;
    }
    const double row = std::round(y);
    const double shift = staggered && std::lround(row) % 2 != 0 ? 1 : 0;
    const double column = staggered ? 2 * std::round((x - shift) / 2) + shift : std::round(x);
    if (row < 0 || row > bottom || column < 0 || column > right) return scene.board;
    return std::hypot(x - column, y - row) < scene.radius ? scene.pattern : scene.board;
  }

  CameraModel camera_;
  cv::Mat rays_;
};

inline cv::Mat as_8_bit(const cv::Mat& levels) {
  cv::Mat out;
  levels.convertTo(out, CV_8U);
  return out;
}
/// Counts of a thermal camera: a few hundred above a large offset.
inline cv::Mat as_16_bit(const cv::Mat& levels, double scale = 1, double offset = 7000) {
  cv::Mat out;
  levels.convertTo(out, CV_16U, scale, offset);
  return out;
}

/// A view without an image: the target's points where the lens shows them, with noise.
inline CalibrationView bare_view(const CameraModel& camera, const ScenePose& pose, TargetSize size,
                                 double sigma_px, std::mt19937& random, std::string name) {
  std::normal_distribution<double> noise(0.0, sigma_px);
  CalibrationView view;
  view.name = std::move(name);
  view.target.emplace();
  view.target->size = size;
  for (const auto& p : points_of(TargetKind::Chessboard, size)) {
    const auto seen =
        camera.project(Vector<Camera>{pose.rotation.leftCols<2>() * p + pose.translation});
    if (!seen || !camera.contains(*seen)) continue;
    view.target->points.push_back({p, {seen->u + noise(random), seen->v + noise(random)}});
  }
  return view;
}

inline std::vector<CalibrationView> bare_views(const CameraModel& camera,
                                               const std::vector<ScenePose>& poses, TargetSize size,
                                               double sigma_px, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<CalibrationView> views;
  for (std::size_t i = 0; i < poses.size(); ++i)
    views.push_back(
        bare_view(camera, poses[i], size, sigma_px, random, "view" + std::to_string(i)));
  return views;
}

}  // namespace watersky::test
