// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/view_selection.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "watersky/target_calibration/detail/lens_choice.hpp"

namespace watersky::detail {

namespace {

constexpr double kMostTilt_deg = 82;
constexpr double kGrossSigmas = 12;  // in the first fit, whose model may be too simple
constexpr double kLeast_px = 0.01;   // what is below stands out of nothing

std::string text(const char* format, double a, double b = 0) {
  char out[240];
  std::snprintf(out, sizeof out, format, a, b);
  return out;
}

/// Median, and the median absolute deviation scaled to a normal distribution's sigma.
struct Spread {
  double middle, sigma;
};
Spread spread_of(const std::vector<double>& values) {
  const double middle = median(values);
  std::vector<double> off;
  for (const double v : values) off.push_back(std::abs(v - middle));
  return {middle, 1.4826 * median(off)};
}

/// The largest distance from a point of `a` to the nearest of `b`: targets that are seen alike are
/// equal however their points are ordered. Stops beyond `enough_px`.
double largest_move_px(const DetectedTarget& a, const DetectedTarget& b, double enough_px) {
  double largest = 0;
  for (const TargetPoint& p : a.points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const TargetPoint& q : b.points)
      nearest = std::min(nearest, std::hypot(p.seen.u - q.seen.u, p.seen.v - q.seen.v));
    largest = std::max(largest, nearest);
    if (largest > enough_px) break;
  }
  return largest;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double residual_sigma_px(std::span<const FitView> views, const LensFit& fit) {
  std::vector<double> lengths;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const FitPoint& p : views[v])
      if (const auto r = residual(fit.lens, fit.poses[v], p)) lengths.push_back(r->norm());
  return median(lengths) / 1.1774;  // the median of a Rayleigh distribution
}

double rms_px(const FitView& view, const Lens& lens, const TargetPose& pose) {
  double sum = 0, n = 0;
  for (const FitPoint& p : view) {
    if (!(p.weight > 0)) continue;
    const auto r = residual(lens, pose, p);
    sum += r ? r->squaredNorm() : 1e6;
    n += 1;
  }
  return n > 0 ? std::sqrt(sum / n) : std::numeric_limits<double>::infinity();
}

double tilt_deg(const TargetPose& pose) {
  return 180 / std::numbers::pi * std::acos(std::min(1.0, std::abs(pose.rotation(2, 2))));
}

ViewSelection::ViewSelection(std::vector<CalibrationView>& views,
                             const CalibrationParameters& parameters)
    : views_(views), parameters_(parameters) {
  for (std::size_t v = 0; v < views_.size(); ++v) {
    if (!views_[v].target || !views_[v].reason.empty()) continue;
    active_.push_back(v);
    FitView points;
    for (const TargetPoint& p : views_[v].target->points)
      points.push_back({p.on_target, {p.seen.u, p.seen.v}, 1.0});
    points_.push_back(std::move(points));
  }
}

void ViewSelection::reject(std::size_t place, std::string reason) {
  views_[active_[place]].reason = std::move(reason);
  active_.erase(active_.begin() + static_cast<long>(place));
  points_.erase(points_.begin() + static_cast<long>(place));
}

Status ViewSelection::enough(const std::string& what) const {
  const auto least = static_cast<std::size_t>(parameters_.min_views);
  if (active_.size() >= least) return {};
  if (copies_ > 0 && active_.size() + copies_ >= least)
    return Error{ErrorCode::Degenerate,
                 std::to_string(active_.size() + copies_) + " views show the target at " +
                     (active_.size() == 1 ? std::string("one place")
                                          : "only " + std::to_string(active_.size()) + " places") +
                     ", and " + std::to_string(least) +
                     " are needed at least; move and tilt the target, or the camera, between "
                     "pictures"};
  std::string first;
  for (const CalibrationView& view : views_)
    if (!view.reason.empty()) {
      first = " (" + view.name + ": " + view.reason + ")";
      break;
    }
  return Error{ErrorCode::Degenerate, "only " + std::to_string(active_.size()) + " of " +
                                          std::to_string(views_.size()) + " views " + what +
                                          ", and " + std::to_string(least) +
                                          " are needed at least" + first +
                                          "; take more pictures of the whole target, sharp and "
                                          "from different sides"};
}

void ViewSelection::reject_copies() {
  const double enough = parameters_.least_move_px;
  for (std::size_t i = 0; i < active_.size();) {
    bool copy = false;
    for (std::size_t k = 0; k < i && !copy; ++k) {
      const DetectedTarget &a = *views_[active_[i]].target, &b = *views_[active_[k]].target;
      const double moved = std::max(largest_move_px(a, b, enough), largest_move_px(b, a, enough));
      if (moved > enough) continue;
      reject(i, "shows the target where " + views_[active_[k]].name +
                    text(" does (no point moved by more than %.2f px)", moved));
      ++copies_;
      copy = true;
    }
    if (!copy) ++i;
  }
}

void ViewSelection::reject_blurred() {
  std::vector<double> widths;
  for (const std::size_t v : active_)
    if (std::isfinite(views_[v].target->edge_width_px))
      widths.push_back(views_[v].target->edge_width_px);
  if (widths.size() < 4) return;
  const Spread usual = spread_of(widths);
  const double most = std::max({usual.middle + parameters_.outlier_mads * usual.sigma,
                                1.5 * usual.middle, usual.middle + 1.0});
  for (std::size_t i = active_.size(); i-- > 0;)
    if (const double width = views_[active_[i]].target->edge_width_px; width > most)
      reject(i, text("blurred: its edges are %.1f px wide, those of the median view %.1f px", width,
                     usual.middle));
}

struct ViewSelection::RobustFit {
  LensFit fit;
  std::vector<bool> posed;  ///< of the active views; `fit` has poses of those that are
  double sigma_px = 0.0;
};

/// A fit of middle order in which what is far off has little say.
std::optional<ViewSelection::RobustFit> ViewSelection::robust_fit(LensModel model, int width_px,
                                                                  int height_px) const {
  const auto start = start_lens(points_, model, width_px, height_px);
  if (!start) return std::nullopt;
  RobustFit found;
  std::vector<FitView> views;
  std::vector<TargetPose> poses;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    found.posed.push_back(start->poses[i].has_value());
    if (!start->poses[i]) continue;
    views.push_back(points_[i]);
    poses.push_back(*start->poses[i]);
  }
  const bool fisheye = model == LensModel::Fisheye;
  LensFamily family;
  for (LensFamily& f : families(fisheye ? LensChoice::Fisheye : LensChoice::Pinhole))
    if (f.free.size() == (fisheye ? 8 : 9)) family = std::move(f);
  // The start's own residuals are of the distortion too, so weights come with the second fit.
  auto fit = fit_family(views, family, start->lens, poses);
  for (int round = 0; fit && round < 4; ++round) {
    found.sigma_px = std::max(1e-6, residual_sigma_px(views, *fit));
    for (std::size_t i = 0; i < views.size(); ++i)
      for (FitPoint& p : views[i]) {
        const auto r = residual(fit->lens, fit->poses[i], p);
        p.weight = r ? std::min(1.0, 3 * found.sigma_px / std::max(r->norm(), 1e-9)) : 0.0;
      }
    fit = fit_lens(views, fit->lens, fit->poses, family.free, false, 20);
  }
  if (!fit) return std::nullopt;
  found.sigma_px = residual_sigma_px(views, *fit);
  found.fit = *std::move(fit);
  return found;
}

Result<LensFit> ViewSelection::settle(LensChoice choice, int width_px, int height_px) {
  std::optional<RobustFit> robust;
  for (const LensModel model : {LensModel::Pinhole, LensModel::Fisheye}) {
    if (choice == LensChoice::Pinhole && model == LensModel::Fisheye) continue;
    if (choice == LensChoice::Fisheye && model == LensModel::Pinhole) continue;
    auto other = robust_fit(model, width_px, height_px);
    if (other && (!robust || other->sigma_px < robust->sigma_px)) robust = std::move(other);
  }
  if (!robust)
    return Error{ErrorCode::Degenerate,
                 "no lens explains the views; is the target flat and evenly spaced, and is it "
                 "tilted between views?"};
  LensFit fit = std::move(robust->fit);
  for (std::size_t i = active_.size(); i-- > 0;)
    if (!robust->posed[i]) reject(i, "no pose of the target explains what is seen");
  for (std::size_t i = active_.size(); i-- > 0;) {
    const double tilt = tilt_deg(fit.poses[i]);
    if (tilt < kMostTilt_deg) continue;
    reject(i, text("shows the target nearly from its edge (%.0f degrees)", tilt));
    fit.poses.erase(fit.poses.begin() + static_cast<long>(i));
  }
  // One view at a time: without it the others are judged anew.
  for (std::size_t round = 0; round <= views_.size() + 3; ++round) {
    WATERSKY_CHECK(enough("show the target without fault"));
    correct_discs(fit);
    leave_out_points(fit, kGrossSigmas);
    const bool rejected = reject_worst(fit);
    WATERSKY_CHECK(enough("show the target without fault"));
    auto next = fit_lens(points_, fit.lens, fit.poses, fit.free);
    if (!next) break;
    const bool still = std::abs(next->lens.parameters[0] - fit.lens.parameters[0]) <
                       1e-6 * next->lens.parameters[0];
    fit = *std::move(next);
    if (!rejected && still) break;
  }
  return fit;
}

bool ViewSelection::reject_worst(LensFit& fit) {
  std::vector<double> rms;
  for (std::size_t i = 0; i < active_.size(); ++i)
    rms.push_back(rms_px(points_[i], fit.lens, fit.poses[i]));
  const Spread usual = spread_of(rms);
  const double most = std::max(
      {usual.middle + parameters_.outlier_mads * usual.sigma, 1.6 * usual.middle, kLeast_px});
  std::optional<std::size_t> worst;
  std::string reason;
  if (const auto it = std::max_element(rms.begin(), rms.end()); it != rms.end() && *it > most) {
    worst = static_cast<std::size_t>(it - rms.begin());
    reason = text(
        "its residuals stand out: %.2f px rms, in the median view %.2f px; the target is "
        "badly detected, or bends or moves",
        *it, usual.middle);
  }
  // A view of which many points were left out is no better than one with a large residual.
  for (std::size_t i = 0; i < active_.size() && !worst; ++i) {
    const auto out = std::count_if(points_[i].begin(), points_[i].end(),
                                   [](const FitPoint& p) { return !(p.weight > 0); });
    if (10 * out <= static_cast<long>(points_[i].size())) continue;
    worst = i;
    reason = "the residuals of " + std::to_string(out) + " of its " +
             std::to_string(points_[i].size()) +
             " points stand out; the target is badly detected, or bends or moves";
  }
  if (!worst) return false;
  reject(*worst, std::move(reason));
  fit.poses.erase(fit.poses.begin() + static_cast<long>(*worst));
  return true;
}

void ViewSelection::leave_out_points(const LensFit& fit, double sigmas) {
  const double most = std::max(kLeast_px, sigmas * residual_sigma_px(points_, fit));
  for (std::size_t i = 0; i < active_.size(); ++i)
    for (FitPoint& p : points_[i]) {
      const auto r = residual(fit.lens, fit.poses[i], p);
      p.weight = r && r->norm() <= most ? 1.0 : 0.0;
    }
}

void ViewSelection::correct_discs(const LensFit& fit) {
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const DetectedTarget& target = *views_[active_[i]].target;
    for (std::size_t k = 0; k < points_[i].size(); ++k) {
      const Pixel& seen = target.points[k].seen;
      points_[i][k].seen =
          Eigen::Vector2d(seen.u, seen.v) -
          disc_offset(fit.lens, fit.poses[i], points_[i][k].on_target, target.radius);
    }
  }
}

}  // namespace watersky::detail
