// SPDX-License-Identifier: MIT
#include "watersky/camera/sea_plane.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

namespace watersky {

namespace {

constexpr double kLeastHeight_m = 1e-3;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Of a closed line of (north, east); positive when it runs clockwise seen from above.
double signed_area_m2(const std::vector<Eigen::Vector2d>& line) {
  double twice = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    twice += cross(line[i] - line.front(), line[(i + 1) % line.size()] - line.front());
  return 0.5 * twice;
}

}  // namespace

Eigen::Matrix3d metres_from_cells(double dx_m, double dy_m) {
  Eigen::Matrix3d m;
  m << dx_m, 0, 0.5 * dx_m, 0, dy_m, 0.5 * dy_m, 0, 0, 0;
  return m;
}

Result<Eigen::Matrix3d> invert_homography(const Eigen::Matrix3d& h) {
  // Column by column: a grid whose origin is far away makes the third one long, and the others
  // seem to vanish beside it, without the camera being any nearer to the plane.
  const Eigen::Matrix3d normalised = h.colwise().normalized();
  if (!normalised.allFinite() || std::abs(normalised.determinant()) < 1e-13)
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

namespace {

/// Of the image's edge, at first; and where so few would cut off more than this share of the
/// outline's area (a lens whose circle grazes the sea), four times as many, and again.
constexpr int kSamplesPerSide = 32, kMostSamplesPerSide = 512;
constexpr double kMostCutOff = 0.002;
constexpr double kTurn = 2 * std::numbers::pi;

using Line = std::vector<Eigen::Vector2d>;

Eigen::Vector2d point_below(const SeaView& view) {
  return view.sea_from_camera().origin().v.head<2>();
}

bool on_image(const SeaView& view, const Eigen::Vector2d& north_east) {
  const auto pixel = view.pixel(Point<Sea>{{north_east.x(), north_east.y(), 0.0}});
  return pixel && view.camera().contains(*pixel);
}

/// The circle of the grazing limit.
Eigen::Vector2d on_limit(const SeaView& view, double azimuth) {
  return point_below(view) +
         view.max_distance_m() * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
}

double azimuth_of(const SeaView& view, const Eigen::Vector2d& north_east) {
  const Eigen::Vector2d d = north_east - point_below(view);
  return std::atan2(d.y(), d.x());
}

/// The image's edge, clockwise from its top left corner; a side is a unit of `t`. Where the
/// lens shows nothing, the last pixel towards the edge at which it does.
Pixel edge(const CameraModel& camera, double t) {
  const double w = camera.width_px(), h = camera.height_px();
  const double side = std::floor(t), f = t - side;
  Pixel p;
  switch (static_cast<int>(side + 4) % 4) {
    case 0: p = {-0.5 + f * w, -0.5}; break;
    case 1: p = {w - 0.5, -0.5 + f * h}; break;
    case 2: p = {w - 0.5 - f * w, h - 0.5}; break;
    default: p = {-0.5, h - 0.5 - f * h}; break;
  }
  if (camera.direction(p)) return p;
  Pixel inner{camera.camera_matrix()(0, 2), camera.camera_matrix()(1, 2)};
  if (!camera.contains(inner)) inner = {0.5 * (w - 1), 0.5 * (h - 1)};
  for (int i = 0; i < 50; ++i) {
    const Pixel middle{0.5 * (inner.u + p.u), 0.5 * (inner.v + p.v)};
    (camera.direction(middle) ? inner : p) = middle;
  }
  return inner;
}

std::optional<Point<Sea>> sea_at_edge(const SeaView& view, double t) {
  return view.sea_point(edge(view.camera(), t));
}

/// Where the edge passes the grazing limit between a position that sees the sea and one that
/// does not.
Eigen::Vector2d crossing(const SeaView& view, double seen, double unseen) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (seen + unseen);
    (sea_at_edge(view, middle) ? seen : unseen) = middle;
  }
  return sea_at_edge(view, seen)->v.head<2>();
}

/// What a walk around the image's edge sees of the sea: one closed line when it sees it all
/// the way, otherwise a line for each stretch, beginning and ending on the grazing limit.
struct EdgeWalk {
  std::vector<Line> lines;
  bool closed = false;
  double cut_off_m2 = 0.0;  ///< about what lies between the lines' straight pieces and the curves
};

/// What a line cuts off a curve through its points: each three of them span a triangle, and
/// between its two short sides and a parabola lies a third of its area. Two triangles tell of each
/// side. Corners of the image, whose `t` is a whole number, are corners.
double cut_off_m2(const Line& line, const std::vector<double>& t, bool closed) {
  const std::size_t n = line.size();
  if (n < 4 && !closed) return std::numeric_limits<double>::infinity();  // too few to tell
  double triangles_m2 = 0.0;
  for (std::size_t i = closed ? 0 : 1; i + (closed ? 0 : 1) < n; ++i)
    if (t[i] != std::floor(t[i])) {
      const Eigen::Vector2d &a = line[(i + n - 1) % n], &b = line[i], &c = line[(i + 1) % n];
      triangles_m2 += 0.5 * std::abs(cross(b - a, c - b));
    }
  return triangles_m2 / 3.0 / 2.0;
}

EdgeWalk walk_edge(const SeaView& view, int samples_per_side) {
  const int in_all = 4 * samples_per_side;
  std::vector<std::optional<Point<Sea>>> samples(static_cast<std::size_t>(in_all));
  int seen = 0, start = 0;  // start at a sample that is not seen, if there is one
  for (int i = 0; i < in_all; ++i) {
    samples[static_cast<std::size_t>(i)] =
        sea_at_edge(view, static_cast<double>(i) / samples_per_side);
    if (samples[static_cast<std::size_t>(i)])
      ++seen;
    else
      start = i;
  }
  EdgeWalk walk;
  walk.closed = seen == in_all;
  if (walk.closed) walk.lines.emplace_back();
  std::vector<double> along;  // `t` of the points of the line that is walked
  bool was_seen = walk.closed;
  for (int n = 0; n <= in_all - (walk.closed ? 1 : 0); ++n) {
    const auto& now = samples[static_cast<std::size_t>((start + n) % in_all)];
    const double t = static_cast<double>(start + n) / samples_per_side,
                 before = t - 1.0 / samples_per_side;
    if (now && !was_seen) {
      walk.lines.push_back({crossing(view, t, before)});
      along.assign(1, t);
    }
    if (now) {
      walk.lines.back().push_back(now->v.head<2>());
      along.push_back(t);
    }
    if (!now && was_seen) {
      walk.lines.back().push_back(crossing(view, before, t));
      along.push_back(t);
      walk.cut_off_m2 += cut_off_m2(walk.lines.back(), along, false);
    }
    was_seen = now.has_value();
  }
  if (walk.closed) walk.cut_off_m2 = cut_off_m2(walk.lines.front(), along, true);
  return walk;
}

/// How far to turn clockwise along the limit from where one line ends to where one begins.
double turn_between(const SeaView& view, const Line& ends, const Line& begins) {
  const double from = azimuth_of(view, ends.back());
  double turn = azimuth_of(view, begins.front()) - from;
  if (turn < 0) turn += kTurn;
  // A line that barely leaves the limit: rounding must not send it around the whole circle.
  if (turn > kTurn - 1e-6 && !on_image(view, on_limit(view, from + 0.5 * kTurn))) turn = 0;
  return turn;
}

/// Joins the lines of a walk along the limit into the outline. The walk goes clockwise and so
/// does the outline: each line's end is joined to the next beginning clockwise of it. A lens so
/// wide that it shows two separate pieces of the sea keeps the larger.
Line close_along_limit(const SeaView& view, const std::vector<Line>& lines) {
  constexpr double kStep = 3.0 * std::numbers::pi / 180;
  constexpr int kLeastSteps = 16;  // also a short arc bulges
  Line largest;
  double largest_area = 0;
  std::vector<bool> used(lines.size(), false);
  for (std::size_t first = 0; first < lines.size(); ++first) {
    Line outline;
    for (std::size_t i = first; !used[i];) {
      used[i] = true;
      outline.insert(outline.end(), lines[i].begin(), lines[i].end());
      std::size_t next = first;
      double turn = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < lines.size(); ++k)
        if (const double to = turn_between(view, lines[i], lines[k]); to < turn)
          turn = to, next = k;
      const double from = azimuth_of(view, lines[i].back());
      const int steps = std::max(kLeastSteps, static_cast<int>(turn / kStep));
      for (int step = 1; step < steps; ++step)
        outline.push_back(on_limit(view, from + turn * step / steps));
      i = next;
    }
    if (const double area = signed_area_m2(outline); area > largest_area)
      largest_area = area, largest = std::move(outline);
  }
  return largest;
}

Line whole_limit(const SeaView& view) {
  Line circle;
  constexpr int kSteps = 120;
  for (int i = 0; i < kSteps; ++i) circle.push_back(on_limit(view, kTurn * i / kSteps));
  return circle;
}

/// Without vertices on straight lines: a pinhole's nadir footprint has four.
Line corners_of(const Line& outline) {
  Line distinct;
  for (const auto& p : outline)
    if (distinct.empty() || p != distinct.back()) distinct.push_back(p);
  while (distinct.size() > 1 && distinct.back() == distinct.front()) distinct.pop_back();
  Line corners;
  for (std::size_t i = 0; i < distinct.size(); ++i) {
    const Eigen::Vector2d& before = corners.empty() ? distinct.back() : corners.back();
    const Eigen::Vector2d a = distinct[i] - before;
    const Eigen::Vector2d b = distinct[(i + 1) % distinct.size()] - distinct[i];
    if (std::abs(cross(a, b)) > 1e-9 * (a.squaredNorm() + b.squaredNorm()))
      corners.push_back(distinct[i]);
  }
  return corners.size() >= 3 ? corners : distinct;
}

/// The point of the footprint nearest to the point below the camera.
Eigen::Vector2d nearest_point(const SeaView& view) {
  const Eigen::Vector2d below = point_below(view);
  if (on_image(view, below)) return below;
  const Line& outline = view.footprint_north_east_m();
  Eigen::Vector2d nearest = outline.front();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i], along = outline[(i + 1) % outline.size()] - a;
    const double f =
        std::clamp((below - a).dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
    if ((a + f * along - below).norm() < (nearest - below).norm()) nearest = a + f * along;
  }
  return nearest;
}

/// Metres a pixel at a place, along the coarser direction: one over the smaller singular value
/// of the derivative of the pixel by the place.
double gsd_m_at(const SeaView& view, const Eigen::Vector2d& at) {
  const double height_m = view.height_m();
  const double slant_m = std::hypot((at - point_below(view)).norm(), height_m);
  const double step_m = 1e-4 * height_m;
  Eigen::Matrix2d derivative;
  for (int axis = 0; axis < 2; ++axis) {
    Point<Sea> before{{at.x(), at.y(), 0}}, after = before;
    before.v[axis] -= step_m;
    after.v[axis] += step_m;
    const auto p = view.pixel(before), q = view.pixel(after);
    if (!p || !q)  // at the very edge of the lens: as on the axis
      return slant_m / view.camera().focal_px() * (slant_m / height_m);
    derivative.col(axis) = Eigen::Vector2d(q->u - p->u, q->v - p->v) / (2 * step_m);
  }
  const double sum = derivative.squaredNorm(), product = std::abs(derivative.determinant());
  const double larger =
      std::sqrt(0.5 * (sum + std::sqrt(std::max(0.0, sum * sum - 4 * product * product))));
  return larger / product;
}

}  // namespace

Result<SeaView> SeaView::make(const CameraModel& camera, const Rigid3<Sea, Camera>& sea_from_camera,
                              const ViewLimits& limits) {
  const auto fail = [](std::string message) {
    return Error{ErrorCode::Degenerate, std::move(message)};
  };
  const Eigen::Vector3d& c = sea_from_camera.origin().v;
  if (!c.allFinite() || !(std::abs(sea_from_camera.rotation().norm() - 1) < 1e-6))
    return fail("the camera's pose is not a number");
  const double height_m = -c.z();
  if (!(height_m > kLeastHeight_m)) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the camera is %s the sea surface (%.3f m above it); check the sea level and the "
                  "pose's height",
                  height_m < -kLeastHeight_m ? "below" : "in", height_m);
    return fail(text);
  }

  if (!(limits.min_grazing < Angle::degrees(90.0)))
    return Error{ErrorCode::Usage, "the grazing limit must be below 90°"};

  SeaView view(camera, sea_from_camera);
  view.max_distance_m_ = height_m / std::tan(std::max(limits.min_grazing.radians(), 1e-3));

  Line outline;
  for (int samples = kSamplesPerSide; samples <= kMostSamplesPerSide; samples *= 4) {
    const EdgeWalk walk = walk_edge(view, samples);
    view.cut_ = !walk.closed;
    if (walk.closed) {
      outline = walk.lines.front();
    } else if (!walk.lines.empty()) {
      outline = close_along_limit(view, walk.lines);
    } else if (on_image(view, point_below(view))) {
      outline = whole_limit(view);  // a wide lens may hold the whole circle
    }
    if (walk.cut_off_m2 <= kMostCutOff * std::abs(signed_area_m2(outline))) break;
  }
  if (outline.empty()) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "no part of the image sees the sea steeper than the grazing limit of %.1f° "
                  "(camera %.1f m above the sea)",
                  limits.min_grazing.degrees(), height_m);
    return fail(text);
  }
  if (!(signed_area_m2(outline) > 0))
    return fail("the image sees the sea all around, but upside down: the camera looks up");
  view.footprint_ = corners_of(outline);

  const auto middle =
      view.sea_point({0.5 * (camera.width_px() - 1), 0.5 * (camera.height_px() - 1)});
  view.gsd_m_ = gsd_m_at(view, middle ? Eigen::Vector2d(middle->v.head<2>()) : nearest_point(view));
  return view;
}

}  // namespace watersky
