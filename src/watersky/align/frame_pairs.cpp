// SPDX-License-Identifier: MIT
#include "watersky/align/frame_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <list>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "watersky/camera/reduced_image.hpp"
#include "watersky/camera/sea_plane.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky {

namespace {

/// Of images decoded reduced: what JPEG decoders can do.
constexpr std::array kReductions{1, 2, 4, 8};
/// Places where a predicted homography is sampled, each way.
constexpr int kSamples = 12;
constexpr std::size_t kFewestSamples = 9;
/// In the geometric bins of how long ago, candidates whose overlap is worked out exactly.
constexpr std::size_t kExactCandidates = 4;

using Line = std::vector<Eigen::Vector2d>;

std::vector<cv::Point2f> hull_of(const Line& line, const Eigen::Vector2d& origin) {
  std::vector<cv::Point2f> points, hull;
  for (const Eigen::Vector2d& p : line)
    points.emplace_back(static_cast<float>(p.x() - origin.x()),
                        static_cast<float>(p.y() - origin.y()));
  cv::convexHull(points, hull);
  return hull;
}

struct Box {
  Eigen::Vector2d low, high;
  [[nodiscard]] double area() const { return (high - low).prod(); }
};

/// Empty, and so overlapping nothing, of no line.
Box box_of(const Line& line) {
  if (line.empty()) return {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  Box box{line.front(), line.front()};
  for (const Eigen::Vector2d& p : line) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

/// Never less than the footprints' own overlap could be of the smaller box, but cheap: it orders
/// candidates.
double box_share(const Box& a, const Box& b) {
  const Eigen::Vector2d side = a.high.cwiseMin(b.high) - a.low.cwiseMax(b.low);
  if (!(side.minCoeff() > 0)) return 0.0;
  return side.prod() / std::min(a.area(), b.area());
}

/// Boxes by the cells of a grid, so that a frame meets only those near it.
class BoxGrid {
 public:
  explicit BoxGrid(const std::vector<Box>& boxes) {
    std::vector<double> sides;
    sides.reserve(boxes.size());
    for (const Box& box : boxes) sides.push_back((box.high - box.low).maxCoeff());
    const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
    if (middle != sides.end()) {
      std::nth_element(sides.begin(), middle, sides.end());
      cell_m_ = std::max(*middle, 1e-3);
    }
  }
  void add(std::size_t i, const Box& box) {
    each_cell(box, [&](std::int64_t key) { cells_[key].push_back(i); });
  }
  /// Those added whose cells `box` touches, each once, in the order in which they were added.
  [[nodiscard]] std::vector<std::size_t> near(const Box& box) const {
    std::vector<std::size_t> found;
    each_cell(box, [&](std::int64_t key) {
      if (const auto it = cells_.find(key); it != cells_.end())
        found.insert(found.end(), it->second.begin(), it->second.end());
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

 private:
  template <class Use>
  void each_cell(const Box& box, Use&& use) const {
    // A sight to the horizon would touch cells without end: beyond some it is held to its middle.
    constexpr std::int64_t kMost = 16;
    const auto cell = [&](double m) { return static_cast<std::int64_t>(std::floor(m / cell_m_)); };
    const auto range = [&](double low, double high) {
      std::int64_t first = cell(low), last = cell(high);
      if (last - first >= kMost) {
        first = cell(0.5 * (low + high)) - kMost / 2;
        last = first + kMost - 1;
      }
      return std::pair(first, last);
    };
    const auto [x0, x1] = range(box.low.x(), box.high.x());
    const auto [y0, y1] = range(box.low.y(), box.high.y());
    for (std::int64_t x = x0; x <= x1; ++x)
      for (std::int64_t y = y0; y <= y1; ++y) use(x * 0x9E3779B1LL + y);
  }
  double cell_m_ = 1.0;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

std::optional<Point<World>> sea_in_world(const CameraModel& camera, const PlacedFrame& frame,
                                         const Pixel& pixel, double least_sine) {
  const auto ray = camera.direction(pixel);
  if (!ray) return std::nullopt;
  const Eigen::Vector3d d = (frame.pose.sea_from_camera * *ray).v;
  if (!(d.z() >= least_sine)) return std::nullopt;
  const Eigen::Vector3d& c = frame.pose.sea_from_camera.origin().v;
  return frame.world_from_sea * Point<Sea>{c - (c.z() / d.z()) * d};
}

/// Pairs by the sea plane over a grid of A's pixels within `low` and `high`.
std::vector<PointPair> predicted_pairs(const CameraModel& camera, const PlacedFrame& a,
                                       const PlacedFrame& b, double least_sine, cv::Point2d low,
                                       cv::Point2d high) {
  std::vector<PointPair> pairs;
  const Rigid3<Camera, World> camera_from_world = b.pose.world_from_camera.inverse();
  for (int i = 0; i < kSamples; ++i)
    for (int k = 0; k < kSamples; ++k) {
      const Pixel p{low.x + (high.x - low.x) * i / (kSamples - 1),
                    low.y + (high.y - low.y) * k / (kSamples - 1)};
      const auto sea = sea_in_world(camera, a, p, least_sine);
      if (!sea) continue;
      const auto q = camera.project(camera_from_world * *sea);
      if (q && camera.contains(*q)) pairs.push_back({{p.u, p.v}, {q->u, q->v}});
    }
  return pairs;
}

}  // namespace

PlacedFrames place_frames(const Flight& flight, const FramePairParameters& parameters,
                          std::span<const std::size_t> which) {
  PlacedFrames out;
  const ViewLimits limits{Angle::degrees(parameters.min_grazing_deg)};
  const std::size_t count = which.empty() ? flight.frames.size() : which.size();
  out.frames.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t index = which.empty() ? i : which[i];
    const ImageFrame& frame = flight.frames[index];
    const auto pose = flight.camera_pose(frame, seconds(parameters.max_pose_gap_s));
    if (!pose) {
      out.left_out.push_back({frame.name, pose.error().message});
      continue;
    }
    const auto view = SeaView::make(flight.camera, pose->sea_from_camera, limits);
    if (!view) {
      out.left_out.push_back({frame.name, view.error().message});
      continue;
    }
    PlacedFrame placed{
        index, *pose, pose->world_from_camera * pose->sea_from_camera.inverse(), {}, view->gsd_m()};
    Line outline;
    for (const Eigen::Vector2d& p : view->footprint_north_east_m())
      outline.emplace_back((placed.world_from_sea * Point<Sea>{{p.x(), p.y(), 0.0}}).v.head<2>());
    const Eigen::Vector2d origin = outline.front();
    for (const cv::Point2f& p : hull_of(outline, origin))
      placed.footprint_m.emplace_back(origin + Eigen::Vector2d(p.x, p.y));
    out.frames.push_back(std::move(placed));
  }
  std::stable_sort(
      out.frames.begin(), out.frames.end(),
      [](const PlacedFrame& a, const PlacedFrame& b) { return a.pose.time < b.pose.time; });
  return out;
}

double overlap_share(const PlacedFrame& a, const PlacedFrame& b) {
  if (a.footprint_m.size() < 3 || b.footprint_m.size() < 3) return 0.0;
  // Floats near the footprints keep a millimetre wherever the datum is.
  const Eigen::Vector2d origin = a.footprint_m.front();
  const auto pa = hull_of(a.footprint_m, origin), pb = hull_of(b.footprint_m, origin);
  std::vector<cv::Point2f> both;
  const double common = cv::intersectConvexConvex(pa, pb, both);
  const double smaller = std::min(cv::contourArea(pa), cv::contourArea(pb));
  return smaller > 0 ? std::clamp(common / smaller, 0.0, 1.0) : 0.0;
}

std::vector<FrameOverlap> choose_pairs(std::span<const PlacedFrame> placed,
                                       const FramePairParameters& parameters) {
  std::vector<Box> boxes;
  boxes.reserve(placed.size());
  for (const PlacedFrame& frame : placed) boxes.push_back(box_of(frame.footprint_m));
  BoxGrid grid(boxes);

  std::vector<FrameOverlap> chosen;
  struct Candidate {
    std::size_t frame;
    double box_share;
  };
  for (std::size_t b = 0; b < placed.size(); ++b) {
    if (b > 0)
      if (const double share = overlap_share(placed[b - 1], placed[b]);
          share >= parameters.min_overlap && share > 0)
        chosen.push_back({b - 1, b, share, true});
    // By how long ago, in powers of two: [2, 4), [4, 8), …
    std::map<int, std::vector<Candidate>, std::greater<>> bins;
    if (parameters.most_revisits > 0)
      for (const std::size_t a : grid.near(boxes[b])) {
        if (b - a < 2) continue;
        const double share = box_share(boxes[a], boxes[b]);
        if (share > 0 && share >= 0.5 * parameters.min_overlap)
          bins[std::ilogb(static_cast<double>(b - a))].push_back({a, share});
      }
    int left = parameters.most_revisits;
    for (auto& [bin, candidates] : bins) {
      if (left == 0) break;
      const std::size_t tried = std::min(kExactCandidates, candidates.size());
      std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(tried),
                        candidates.end(), [](const Candidate& x, const Candidate& y) {
                          return std::pair(-x.box_share, x.frame) <
                                 std::pair(-y.box_share, y.frame);
                        });
      FrameOverlap best;
      for (std::size_t i = 0; i < tried; ++i)
        if (const double share = overlap_share(placed[candidates[i].frame], placed[b]);
            share > best.share)
          best = {candidates[i].frame, b, share, false};
      if (best.share > 0 && best.share >= parameters.min_overlap) {
        chosen.push_back(best);
        --left;
      }
    }
    grid.add(b, boxes[b]);
  }
  std::sort(chosen.begin(), chosen.end(), [](const FrameOverlap& x, const FrameOverlap& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  return chosen;
}

std::optional<Eigen::Matrix3d> predicted_homography(const CameraModel& camera, const PlacedFrame& a,
                                                    const PlacedFrame& b, Angle min_grazing) {
  const double least_sine = std::max(sin(min_grazing), 1e-3);
  const cv::Point2d first(0, 0), last(camera.width_px() - 1, camera.height_px() - 1);
  std::vector<PointPair> pairs = predicted_pairs(camera, a, b, least_sine, first, last);
  if (pairs.empty()) return std::nullopt;
  // Once more, denser, where they overlap.
  const cv::Point2d step = (last - first) * (1.0 / (kSamples - 1));
  cv::Point2d low = last, high = first;
  for (const PointPair& pair : pairs) {
    low = {std::min(low.x, pair.a.x), std::min(low.y, pair.a.y)};
    high = {std::max(high.x, pair.a.x), std::max(high.y, pair.a.y)};
  }
  pairs = predicted_pairs(camera, a, b, least_sine,
                          {std::max(first.x, low.x - step.x), std::max(first.y, low.y - step.y)},
                          {std::min(last.x, high.x + step.x), std::min(last.y, high.y + step.y)});
  if (pairs.size() < kFewestSamples) return std::nullopt;
  std::vector<cv::Point2d> from, to;
  for (const PointPair& pair : pairs) {
    from.push_back(pair.a);
    to.push_back(pair.b);
  }
  cv::Mat h;
  try {
    h = cv::findHomography(from, to, 0);
  } catch (const cv::Exception&) {  // all on a line
    return std::nullopt;
  }
  if (h.empty() || !cv::checkRange(h)) return std::nullopt;
  Eigen::Matrix3d out;
  for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
  return out;
}

namespace {

/// A picture ready for registration, and how much smaller than the full one it is.
struct Prepared {
  RegistrationFrame frame;
  int reduction = 1;
  std::string reason;  ///< why it is not there
};

/// The pictures used last.
class PreparedFrames {
 public:
  PreparedFrames(const Flight& flight, const Registrar& registrar,
                 const FramePairParameters& parameters)
      : flight_(flight), registrar_(registrar), parameters_(parameters) {}

  [[nodiscard]] Prepared of(std::size_t frame) {
    const auto held = held_.find(frame);
    if (held != held_.end()) {
      order_.splice(order_.begin(), order_, held->second.at);
      return held->second.prepared;
    }
    while (held_.size() >= static_cast<std::size_t>(parameters_.most_prepared)) {
      held_.erase(order_.back());
      order_.pop_back();
    }
    auto made = make(flight_.frames[frame]);
    Prepared prepared = made ? *std::move(made) : Prepared{{}, 1, made.error().message};
    order_.push_front(frame);
    held_.emplace(frame, Held{order_.begin(), prepared});
    return prepared;
  }

 private:
  struct Held {
    std::list<std::size_t>::iterator at;
    Prepared prepared;
  };

  [[nodiscard]] Result<Prepared> make(const ImageFrame& frame) const {
    const CameraModel& camera = flight_.camera;
    const int longer = std::max(camera.width_px(), camera.height_px());
    int wanted = (longer + parameters_.longer_side_px - 1) / parameters_.longer_side_px;
    if (wanted > 2 && wanted % 2 == 1) ++wanted;  // decoders reduce by even numbers
    int decoded = 1;
    for (const int r : kReductions)
      if (wanted % r == 0) decoded = r;
    if (!frame.load) return Error{ErrorCode::NotFound, "it has no image"};
    WATERSKY_TRY(cv::Mat image, frame.load({.color = false, .reduction = decoded}));
    const auto is_reduced_by = [&](int r) {
      return image.cols == (camera.width_px() + r - 1) / r &&
             image.rows == (camera.height_px() + r - 1) / r;
    };
    int still = wanted / decoded;
    if (!is_reduced_by(decoded)) {
      if (!is_reduced_by(1))
        return Error{ErrorCode::InvalidInput, "its image does not have the calibration's " +
                                                  std::to_string(camera.width_px()) + "x" +
                                                  std::to_string(camera.height_px()) + " pixels"};
      still = wanted;
    }
    if (still > 1) image = reduced_by(image, still);
    WATERSKY_TRY(RegistrationFrame prepared, registrar_.prepare(image));
    return Prepared{std::move(prepared), wanted, ""};
  }

  const Flight& flight_;
  const Registrar& registrar_;
  const FramePairParameters& parameters_;
  std::list<std::size_t> order_;
  std::unordered_map<std::size_t, Held> held_;
};

Eigen::Matrix3d full_from_reduced(int n) {
  Eigen::Matrix3d m;
  m << n, 0, 0.5 * (n - 1), 0, n, 0.5 * (n - 1), 0, 0, 1;
  return m;
}

/// The best known first, then always the one farthest from those taken.
std::vector<PointPair> spread(const std::vector<PointPair>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<double> nearest(all.size(), std::numeric_limits<double>::infinity());
  std::vector<PointPair> taken;
  std::size_t next = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].covariance.trace() < all[next].covariance.trace()) next = i;
  while (taken.size() < most) {
    const cv::Point2d at = all[next].a;
    taken.push_back(all[next]);
    for (std::size_t i = 0; i < all.size(); ++i)
      nearest[i] = std::min(nearest[i], cv::norm(all[i].a - at));
    next = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) -
                                    nearest.begin());
  }
  return taken;
}

}  // namespace

Result<std::vector<RegisteredPair>> register_pairs(const Flight& flight,
                                                   std::span<const PlacedFrame> placed,
                                                   std::span<const FrameOverlap> pairs,
                                                   const FramePairParameters& parameters,
                                                   const Progress& progress) {
  WATERSKY_CHECK(validate(parameters));
  WATERSKY_TRY(const auto registrar, make_registrar(RegistrationMethod::Klt));
  PreparedFrames prepared(flight, *registrar, parameters);
  const cv::Size full(flight.camera.width_px(), flight.camera.height_px());
  const Angle min_grazing = Angle::degrees(parameters.min_grazing_deg);

  std::vector<RegisteredPair> out;
  out.reserve(pairs.size());
  for (const FrameOverlap& pair : pairs) {
    report(progress, "register", out.size(), pairs.size());
    WATERSKY_REQUIRE(pair.a < placed.size() && pair.b < placed.size());
    const PlacedFrame &a = placed[pair.a], &b = placed[pair.b];
    RegisteredPair found;
    found.a = a.frame;
    found.b = b.frame;
    found.consecutive = pair.consecutive;
    found.predicted_share = pair.share;
    const Prepared pa = prepared.of(a.frame), pb = prepared.of(b.frame);
    for (const auto& [frame, picture] : {std::pair(a.frame, &pa), std::pair(b.frame, &pb)})
      if (!picture->frame.data() && found.reason.empty())
        found.reason = flight.frames[frame].name + ": " + picture->reason;
    if (!found.reason.empty()) {
      out.push_back(std::move(found));
      continue;
    }
    std::optional<Eigen::Matrix3d> start = predicted_homography(flight.camera, a, b, min_grazing);
    if (start && !is_plausible(*start, full)) start.reset();
    if (start)
      start = full_from_reduced(pb.reduction).inverse() * *start * full_from_reduced(pa.reduction);
    WATERSKY_TRY(const Registration registration, registrar->align(pa.frame, pb.frame, start));
    found.start = registration.start;
    found.reason = registration.reason;
    if (registration.fit) {
      const auto to_full = [](int n, cv::Point2d p) {
        return cv::Point2d(n * p.x + 0.5 * (n - 1), n * p.y + 0.5 * (n - 1));
      };
      std::vector<PointPair> points;
      for (const PointPair& p : registration.fit->inliers)
        points.push_back({to_full(pa.reduction, p.a), to_full(pb.reduction, p.b),
                          p.covariance * (1.0 * pb.reduction * pb.reduction)});
      found.fit = fit_homography(points,
                                 full_from_reduced(pb.reduction) * registration.fit->b_from_a *
                                     full_from_reduced(pa.reduction).inverse(),
                                 full);
      if (found.fit) {
        found.points = spread(points, static_cast<std::size_t>(parameters.most_points));
        found.reason.clear();
      } else {
        found.reason = "the corners do not determine a homography";
      }
    }
    out.push_back(std::move(found));
  }
  report(progress, "register", out.size(), pairs.size());
  return out;
}

}  // namespace watersky
