// SPDX-License-Identifier: MIT
#include "watersky/camera/sea_plane.hpp"

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

namespace watersky {

Eigen::Matrix3d metres_from_cells(double dx_m, double dy_m) {
  Eigen::Matrix3d m;
  m << dx_m, 0, 0.5 * dx_m, 0, dy_m, 0.5 * dy_m, 0, 0, 0;
  return m;
}

Result<Eigen::Matrix3d> invert_homography(const Eigen::Matrix3d& h) {
  const Eigen::Matrix3d normalised = h / h.cwiseAbs().maxCoeff();
  if (!normalised.allFinite() || std::abs(normalised.determinant()) < 1e-15)
    return Error{ErrorCode::Degenerate, "the camera lies in the plane it should map"};
  return Eigen::Matrix3d(h.inverse());
}

std::optional<Point<Sea>> SeaView::sea_point(const Pixel& pixel) const {
  const auto ray = camera_.direction(pixel);
  if (!ray) return std::nullopt;
  const Eigen::Vector3d d = (sea_from_camera_ * *ray).v;
  if (!(d.z() > 0)) return std::nullopt;
  const Eigen::Vector3d& c = sea_from_camera_.origin().v;
  const Eigen::Vector2d offset = d.head<2>() * (-c.z() / d.z());
  // The relative slack keeps a point found by bisection on the limit.
  if (!(offset.norm() <= max_distance_m_ * (1 + 1e-9))) return std::nullopt;
  return Point<Sea>{{c.x() + offset.x(), c.y() + offset.y(), 0.0}};
}

std::optional<Pixel> SeaView::pixel(const Point<Sea>& p_sea) const {
  return camera_.project(sea_from_camera_.inverse() * p_sea);
}

Result<SeaView> SeaView::make(const CameraModel& camera, const Rigid3<Sea, Camera>& sea_from_camera,
                              const ViewLimits& limits) {
  const Eigen::Vector3d& c = sea_from_camera.origin().v;
  if (!c.allFinite() || !sea_from_camera.rotation().coeffs().allFinite())
    return Error{ErrorCode::Degenerate, "the camera's pose is not a number"};
  const double height_m = -c.z();
  if (!(height_m > 1e-3)) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the camera is %.1f m below the sea surface; check the sea level and the pose's height",
                  -height_m);
    return Error{ErrorCode::Degenerate, height_m > -1e-3 ? "the camera lies in the sea surface; check the sea level" : text};
  }

  SeaView view(camera, sea_from_camera);
  const double min_grazing = std::max(limits.min_grazing.radians(), 1e-3);
  view.max_distance_m_ = height_m / std::tan(min_grazing);

  // Walk around the image's edge; where the walk leaves the usable sea and comes back, close the
  // outline along the circle of the grazing limit.
  constexpr int kPerSide = 32;
  const double w = camera.width_px(), h = camera.height_px();
  const auto border = [&](double t) -> Pixel {  // a side a unit: top, right, bottom, left
    const double side = std::floor(t), f = t - side;
    switch (static_cast<int>(side + 4) % 4) {
      case 0: return {-0.5 + f * w, -0.5};
      case 1: return {w - 0.5, -0.5 + f * h};
      case 2: return {w - 0.5 - f * w, h - 0.5};
      default: return {-0.5, h - 0.5 - f * h};
    }
  };
  const auto sees = [&](double t) { return view.sea_point(border(t)); };
  const auto crossing = [&](double seen, double unseen) {
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (seen + unseen);
      (sees(middle) ? seen : unseen) = middle;
    }
    return sees(seen)->v.head<2>().eval();
  };
  const Eigen::Vector2d below = c.head<2>();
  const auto on_circle = [&](double azimuth) -> Eigen::Vector2d {
    return below + view.max_distance_m_ * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
  };
  const auto on_image = [&](const Eigen::Vector2d& p) {
    const auto pixel = view.pixel(Point<Sea>{{p.x(), p.y(), 0.0}});
    return pixel && camera.contains(*pixel);
  };

  constexpr int kSamples = 4 * kPerSide;
  std::vector<std::optional<Point<Sea>>> samples(kSamples);
  int start = -1;  // a seen sample whose predecessor is unseen
  bool any_seen = false;
  for (int i = 0; i < kSamples; ++i) {
    samples[static_cast<std::size_t>(i)] = sees(static_cast<double>(i) / kPerSide);
    any_seen |= samples[static_cast<std::size_t>(i)].has_value();
    view.cut_ |= !samples[static_cast<std::size_t>(i)].has_value();
  }
  for (int i = 0; i < kSamples && start < 0; ++i)
    if (samples[static_cast<std::size_t>(i)] && !samples[static_cast<std::size_t>((i + kSamples - 1) % kSamples)]) start = i;

  auto& outline = view.footprint_;
  if (!any_seen) {
    // A wide lens may hold the whole circle; otherwise there is nothing to map.
    if (!on_image(below) || !on_image(on_circle(0)))
      return Error{ErrorCode::Degenerate, "no part of the image sees the sea above the grazing limit"};
    for (int i = 0; i < 120; ++i) outline.push_back(on_circle(2 * std::numbers::pi * i / 120));
  } else {
    if (start < 0) start = 0;  // all seen
    const auto close_along_limit = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
      const auto off = [&](const Eigen::Vector2d& p) { return std::abs((p - below).norm() / view.max_distance_m_ - 1); };
      if (off(from) > 1e-6 || off(to) > 1e-6) return;  // cut by the lens, not by the limit
      const double a = std::atan2(from.y() - below.y(), from.x() - below.x());
      double turn = std::atan2(to.y() - below.y(), to.x() - below.x()) - a;
      if (turn < 0) turn += 2 * std::numbers::pi;
      if (!on_image(on_circle(a + 0.5 * turn))) turn -= 2 * std::numbers::pi;
      const int steps = std::max(1, static_cast<int>(std::abs(turn) / (3.0 * std::numbers::pi / 180)));
      for (int i = 1; i < steps; ++i) outline.push_back(on_circle(a + turn * i / steps));
    };
    std::optional<Eigen::Vector2d> left_at;
    for (int n = 0; n < kSamples; ++n) {
      const int i = (start + n) % kSamples, before = (i + kSamples - 1) % kSamples;
      const auto& now = samples[static_cast<std::size_t>(i)];
      const bool was_seen = samples[static_cast<std::size_t>(before)].has_value();
      const double t = static_cast<double>(i) / kPerSide, t_before = t - 1.0 / kPerSide;
      if (now && !was_seen) {
        const Eigen::Vector2d entry = crossing(t, t_before);
        if (left_at) close_along_limit(*left_at, entry);
        outline.push_back(entry);
      } else if (!now && was_seen) {
        left_at = crossing(t_before, t);
        outline.push_back(*left_at);
      }
      if (now) outline.push_back(now->v.head<2>());
    }
    if (left_at) close_along_limit(*left_at, outline.front());
  }

  // Drop vertices on straight lines: a pinhole's nadir footprint has four.
  std::vector<Eigen::Vector2d> corners;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& before = corners.empty() ? outline.back() : corners.back();
    const Eigen::Vector2d a = outline[i] - before, b = outline[(i + 1) % outline.size()] - outline[i];
    const double cross = a.x() * b.y() - a.y() * b.x();
    if (std::abs(cross) > 1e-9 * (a.squaredNorm() + b.squaredNorm())) corners.push_back(outline[i]);
  }
  if (corners.size() >= 3) outline = std::move(corners);

  Eigen::Vector2d at = outline.front();
  for (const auto& p : outline)
    if ((p - below).squaredNorm() < (at - below).squaredNorm()) at = p;
  if (const auto middle = view.sea_point({0.5 * (w - 1), 0.5 * (h - 1)})) at = middle->v.head<2>();
  const double slant_m = std::hypot((at - below).norm(), height_m);
  view.gsd_m_ = slant_m / camera.focal_px() * (slant_m / height_m);
  return view;
}

}  // namespace watersky
