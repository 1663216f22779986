// SPDX-License-Identifier: MIT
#include "watersky/align/detail/known_points.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "watersky/align/detail/adjustment.hpp"
#include "watersky/align/detail/median.hpp"

namespace watersky::align {

namespace {

std::string metres(double m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f m", m);
  return text;
}

/// A place over the flat sea of Local.
Result<Eigen::Vector3d> local_of(const LocalFrame& local, const AnchorPlace& place) {
  WATERSKY_TRY(const Eigen::Vector3d p,
               local.local(Geodetic{place.latitude, place.longitude, place.height_m}));
  if (place.above == HeightAbove::Ellipsoid) return p;
  return Eigen::Vector3d(p.x(), p.y(), -place.height_m);
}

}  // namespace

KnownPoints known_points_of(const Flight& flight, const LocalFrame& local,
                            const Navigation& navigation, const std::vector<std::size_t>& of,
                            const std::vector<AdjustedFrame>& frames) {
  KnownPoints out;
  std::map<std::string, int> frame_of;
  for (std::size_t k = 0; k < of.size(); ++k)
    frame_of.emplace(flight.frames[of[k]].name, static_cast<int>(k));
  const double rows = flight.camera.height_px();
  for (std::size_t a = 0; a < flight.anchors.size(); ++a) {
    const Anchor& anchor = flight.anchors[a];
    // A list of points may know many pictures that are not of this flight: one note a reason.
    std::map<std::string, std::vector<std::string>> left_out;
    const auto leave_out = [&](const AnchorSighting& sighting, const std::string& why) {
      left_out[why].push_back(sighting.frame);
    };
    for (std::size_t i = 0; i < anchor.sightings.size(); ++i) {
      const AnchorSighting& sighting = anchor.sightings[i];
      const auto frame = frame_of.find(sighting.frame);
      if (frame == frame_of.end()) {
        leave_out(sighting, "the flight has no such frame, or no pose for it");
        continue;
      }
      const auto direction = flight.camera.direction(sighting.px);
      if (!direction || !(direction->v.z() > 0.05)) {
        leave_out(sighting, "the camera's lens shows nothing at that pixel");
        continue;
      }
      const AdjustedFrame& seen_by = frames[static_cast<std::size_t>(frame->second)];
      // Where the frame's time is yet to be found, an anchor moves on with it from here.
      const Time time = navigation.epoch() + seconds(seen_by.base_s);
      const auto place = anchor.at(time);
      if (!place) {
        leave_out(sighting, place.error().message);
        continue;
      }
      const auto point = local_of(local, *place);
      if (!point) {
        leave_out(sighting, point.error().message);
        continue;
      }
      KnownPoint known;
      known.anchor = a;
      known.sighting = i;
      known.frame = frame->second;
      known.direction = direction->v.hnormalized();
      known.row = (sighting.px.v + 0.5) / rows - 0.5;
      known.point_m = *point;
      known.at_s = seen_by.base_s;
      known.sigma_px = sighting.sigma_px;
      known.sigma_m = anchor.sigma_m;
      known.sigma_height_m = anchor.sigma_height_m;
      if (seen_by.delayed) {
        constexpr double kBack_s = 0.5;
        if (const auto earlier = anchor.at(time - seconds(kBack_s)))
          if (const auto from = local_of(local, *earlier))
            known.velocity_m_s = (*point - *from) / kBack_s;
      }
      out.points.push_back(known);
    }
    for (const auto& [why, names] : left_out)
      out.notes.push_back(
          "Anchor " + anchor.name + ": its sighting in " + names.front() +
          (names.size() > 1 ? " and those in " + std::to_string(names.size() - 1) + " others were"
                            : std::string(" was")) +
          " left out: " + why + ".");
    if (anchor.sightings.empty())
      out.notes.push_back("Anchor " + anchor.name + " is marked in no frame and was not used.");
  }
  return out;
}

KnownHeights known_heights_of(const Flight& flight, const LocalFrame& local,
                              const Navigation& navigation, Duration max_gap, double range_sigma_m,
                              double most_m) {
  constexpr double kTogether_s = 5.0;
  const double least_cosine = std::cos(Angle::degrees(30).radians());
  const double attitude_rad =
      std::max(Angle::degrees(0.5).radians(),
               navigation.typical_sigma().roll_pitch_yaw_rad.head<2>().maxCoeff());
  struct Together {
    std::vector<double> time_s, error_m, sigma_m;
  };
  std::map<std::int64_t, Together> windows;
  KnownHeights out;
  std::size_t used = 0;
  for (const RangeSample& range : flight.ranges) {
    const auto pose = flight.trajectory.at(range.time, max_gap);
    const auto body = pose ? local.local(pose->world_from_body) : Result<LocalPose>(pose.error());
    if (!body) continue;
    const double cosine = (body->rotation * Eigen::Vector3d::UnitZ()).z();
    if (cosine < least_cosine) continue;
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    const double t_s = navigation.since_epoch_s(range.time);
    Together& w = windows[static_cast<std::int64_t>(std::floor(t_s / kTogether_s))];
    w.time_s.push_back(t_s);
    w.error_m.push_back(range.range_m * cosine + body->position_m.z());
    w.sigma_m.push_back(
        std::hypot(range_sigma_m, range.sigma_m, range.range_m * sine * attitude_rad));
    ++used;
  }
  if (flight.ranges.empty()) return out;
  if (used == 0) {
    out.notes.emplace_back(
        "None of the range finder's measurements has a pose at its time with less than 30° of "
        "tilt; they were not used.");
    return out;
  }
  std::vector<double> errors;
  for (auto& [key, w] : windows) {
    KnownHeight h;
    h.t_s = median(w.time_s);
    h.error_m = median(w.error_m);
    h.sigma_m = median(w.sigma_m);
    h.samples = w.time_s.size();
    errors.push_back(h.error_m);
    out.heights.push_back(h);
  }
  if (const double all_m = median(errors); std::abs(all_m) > most_m) {
    out.heights.clear();
    out.notes.push_back("The range finder puts the aircraft " + metres(std::abs(all_m)) +
                        (all_m > 0 ? " higher" : " lower") +
                        " than poses and sea level do, which contradict it; it was not used. Check "
                        "its unit, and the sea level.");
    return out;
  }
  weigh_heights(out.heights, errors);
  return out;
}

void weigh_heights(std::vector<KnownHeight>& heights, const std::vector<double>& residuals_m) {
  // By their distance from each other: what all have in common is what is looked for.
  const double middle = median(residuals_m);
  for (std::size_t k = 0; k < heights.size(); ++k) {
    const double x = (residuals_m[k] - middle) / (3.0 * heights[k].sigma_m);
    heights[k].robust = std::abs(x) > 4.0 ? 0.0 : 1.0 / (1.0 + x * x);
  }
}

void whiten(const Adjustment& adjustment, std::vector<KnownPoint>& points) {
  std::map<std::size_t, double> sightings;
  for (const KnownPoint& p : points) sightings[p.anchor] += 1.0;
  for (KnownPoint& p : points) {
    const auto seen = adjustment.see_known(p, adjustment.state);
    if (!seen) continue;
    const double h = p.sigma_m * p.sigma_m, v = p.sigma_height_m * p.sigma_height_m;
    const Eigen::Matrix2d covariance = p.sigma_px * p.sigma_px * Eigen::Matrix2d::Identity() +
                                       sightings[p.anchor] * seen->by_point *
                                           Eigen::Vector3d(h, h, v).asDiagonal() *
                                           seen->by_point.transpose();
    p.whiten = covariance.llt().matrixL().solve(Eigen::Matrix2d::Identity());
  }
}

std::optional<Eigen::Vector2d> anchor_error_m(const Adjustment& adjustment,
                                              const KnownPoint& point) {
  const auto seen = adjustment.see_known(point, adjustment.state);
  if (!seen) return std::nullopt;
  const Eigen::Matrix2d by_place = seen->by_point.leftCols<2>();
  if (std::abs(by_place.determinant()) < 1e-9 * by_place.squaredNorm()) return std::nullopt;
  return Eigen::Vector2d(-by_place.inverse() * seen->residual_px);
}

namespace {

/// One sighting's idea of how far off all is.
struct Vote {
  KnownPoint point;
  Eigen::Vector2d offset_m;
  Eigen::Matrix2d own_m2;    ///< of the pixel and of how frames lie to each other
  Eigen::Matrix2d place_m2;  ///< of the anchor
  double px_per_m = 0.0;
};

constexpr double kAgree = 16.0;         ///< four sigmas, squared
constexpr double kNavigation = 25.0;    ///< five sigmas, squared
constexpr double kPlausible = 9.0;      ///< three sigmas, squared
constexpr double kClear = 0.5;          ///< votes by which a winner must lead
constexpr double kHeightShare = 0.002;  ///< what frames are off by each other, however well known

double squared(const Eigen::Vector2d& d, const Eigen::Matrix2d& covariance) {
  return d.dot(covariance.inverse() * d);
}

}  // namespace

AnchorChoice choose_anchors(const Adjustment& adjustment, const std::vector<KnownPoint>& points,
                            double offset_sigma_m) {
  AnchorChoice out;
  const auto known = adjustment.knowledge();
  std::vector<Vote> votes;
  for (const KnownPoint& p : points) {
    const auto error_m = anchor_error_m(adjustment, p);
    const auto seen = adjustment.see_known(p, adjustment.state);
    if (!error_m || !seen) {
      out.rejected.push_back({p});
      continue;
    }
    const Eigen::Matrix2d metres = seen->by_point.leftCols<2>().inverse();
    Eigen::Matrix2d px2 = p.sigma_px * p.sigma_px * Eigen::Matrix2d::Identity();
    if (known)
      px2 += seen->by_camera * known->camera[static_cast<std::size_t>(p.frame)] *
             seen->by_camera.transpose();
    Vote vote{p, *error_m, metres * px2 * metres.transpose(), Eigen::Matrix2d::Zero(), 0.0};
    const double floor_m = kHeightShare * std::abs(adjustment.camera(p.frame).position_m.z());
    vote.own_m2 += floor_m * floor_m * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d by_height = metres * seen->by_point.col(2) * p.sigma_height_m;
    vote.place_m2 =
        p.sigma_m * p.sigma_m * Eigen::Matrix2d::Identity() + by_height * by_height.transpose();
    vote.px_per_m = std::sqrt(std::abs(seen->by_point.leftCols<2>().determinant()));
    votes.push_back(vote);
  }
  if (votes.empty()) return out;
  std::map<std::size_t, double> sightings;
  for (const Vote& v : votes) sightings[v.point.anchor] += 1.0;
  Eigen::Matrix2d navigation_m2 = offset_sigma_m * offset_sigma_m * Eigen::Matrix2d::Identity();
  if (known) navigation_m2 += known->shared_m2;

  const auto agree = [](const Vote& a, const Vote& b) {
    Eigen::Matrix2d covariance = a.own_m2 + b.own_m2;
    if (a.point.anchor != b.point.anchor) covariance += a.place_m2 + b.place_m2;
    return squared(a.offset_m - b.offset_m, covariance) < kAgree;
  };
  const auto from_navigation = [&](const Vote& v) {
    return squared(v.offset_m, navigation_m2 + v.own_m2 + v.place_m2);
  };
  // Every anchor has one vote, shared among its sightings, and so has the navigation.
  const auto score = [&](const Vote& idea) {
    double sum = std::exp(-from_navigation(idea) / (2.0 * kPlausible));
    for (const Vote& v : votes)
      if (agree(v, idea)) sum += 1.0 / sightings[v.point.anchor];
    return sum;
  };
  const Vote* best = nullptr;
  double best_score = 0.0;
  for (const Vote& idea : votes)
    if (const double s = score(idea); s > best_score) best = &idea, best_score = s;
  bool undecided = false;
  for (const Vote& idea : votes)
    undecided = undecided || (!agree(idea, *best) && from_navigation(idea) < kPlausible &&
                              score(idea) > best_score - kClear);

  // The mean of those that agree, and once more those that agree with it.
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d weighed = Eigen::Vector2d::Zero();
  std::map<std::size_t, bool> anchors;
  for (const Vote& v : votes) {
    if (!agree(v, *best)) continue;
    anchors[v.point.anchor] = true;
    const Eigen::Matrix2d weight = (v.own_m2 + sightings[v.point.anchor] * v.place_m2).inverse();
    information += weight;
    weighed += weight * v.offset_m;
  }
  const Eigen::Vector2d mean = information.inverse() * weighed;
  out.against_navigation = anchors.size() < 2 && from_navigation(*best) > kNavigation;
  out.undecided = undecided && !out.against_navigation;
  out.offset_m = mean;
  for (const Vote& v : votes) {
    const bool used = !out.against_navigation && !out.undecided && agree(v, *best);
    const double off_m = out.against_navigation ? v.offset_m.norm() : (v.offset_m - mean).norm();
    if (used)
      out.used.push_back(v.point);
    else
      out.rejected.push_back({v.point, off_m, off_m * v.px_per_m});
  }
  return out;
}

}  // namespace watersky::align
