// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/target_calibration.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "watersky/target_calibration/detail/lens_choice.hpp"
#include "watersky/target_calibration/detail/lens_fit.hpp"
#include "watersky/target_calibration/detail/view_selection.hpp"

namespace watersky {

namespace {

using namespace detail;

constexpr double kLeastTiltSpread_deg = 8;

std::string text(const char* format, double a, double b = 0) {
  char out[240];
  std::snprintf(out, sizeof out, format, a, b);
  return out;
}

double tilt_spread_deg(const LensFit& fit) {
  double least = 1;
  for (std::size_t i = 0; i < fit.poses.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      least =
          std::min(least, std::abs(fit.poses[i].rotation.col(2).dot(fit.poses[k].rotation.col(2))));
  return 180 / std::numbers::pi * std::acos(std::clamp(least, 0.0, 1.0));
}

struct Noise {
  double rms_px = 0.0;    ///< of residuals' lengths
  double sigma_px = 0.0;  ///< of a coordinate, degrees of freedom considered
  std::size_t points = 0;
};

Noise noise_of(std::span<const FitView> views, const LensFit& fit) {
  Noise noise;
  double sum = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const FitPoint& p : views[v]) {
      if (!(p.weight > 0)) continue;
      if (const auto r = residual(fit.lens, fit.poses[v], p)) sum += r->squaredNorm();
      ++noise.points;
    }
  const auto n = static_cast<double>(noise.points);
  const double freedom =
      2 * n - static_cast<double>(fit.free.size()) - 6 * static_cast<double>(views.size());
  noise.rms_px = std::sqrt(sum / n);
  noise.sigma_px = std::sqrt(sum / std::max(1.0, freedom));
  return noise;
}

/// Least squares' own covariance, each variance raised to what residuals summed by views tell
/// where that is larger; correlations stay.
Eigen::MatrixXd covariance_of(std::span<const FitView> views, const LensFit& fit) {
  const double sigma = noise_of(views, fit).sigma_px;
  const Eigen::MatrixXd plain = fit.unit_covariance * (sigma * sigma);
  const auto n = static_cast<double>(views.size());
  const Eigen::MatrixXd clustered =
      fit.unit_covariance * fit.clustered * fit.unit_covariance * (n / (n - 1));
  Eigen::VectorXd scale(plain.rows());
  for (Eigen::Index i = 0; i < scale.size(); ++i)
    scale[i] = plain(i, i) > 0 ? std::sqrt(std::max(1.0, clustered(i, i) / plain(i, i))) : 1.0;
  if (!scale.allFinite()) return plain;
  return scale.asDiagonal() * plain * scale.asDiagonal();
}

Result<CameraModel> model_of(const Lens& lens, int width_px, int height_px) {
  const auto& p = lens.parameters;
  Eigen::Matrix3d matrix;
  matrix << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1;
  const bool fisheye = lens.model == LensModel::Fisheye;
  return CameraModel::make(lens.model, width_px, height_px, matrix,
                           std::vector<double>(p.begin() + 4, p.begin() + (fisheye ? 8 : 12)));
}

std::vector<Pixel> corners(int width_px, int height_px) {
  const double right = width_px - 1.0, bottom = height_px - 1.0;
  return {{0, 0}, {right, 0}, {0, bottom}, {right, bottom}};
}

/// How well the focal length (relative) and the centre (of the longer side) are known; infinite for
/// not at all.
struct Known {
  double focal, centre;
  [[nodiscard]] bool enough(const CalibrationParameters& parameters) const {
    return focal <= parameters.max_focal_sigma && centre <= parameters.max_centre_sigma;
  }
};

Known known_of(std::span<const FitView> views, const LensFit& fit, int longest_px) {
  const Eigen::MatrixXd covariance = covariance_of(views, fit);
  const auto sigma = [&](int i) {
    return covariance(i, i) >= 0 ? std::sqrt(covariance(i, i))
                                 : std::numeric_limits<double>::infinity();
  };
  return {std::max(sigma(0) / fit.lens.parameters[0], sigma(1) / fit.lens.parameters[1]),
          std::max(sigma(2), sigma(3)) / longest_px};
}

/// What is wrong with a fit although its residuals may be the least.
void judge(FamilyFit& of, std::span<const FitView> views, int width_px, int height_px,
           const CalibrationParameters& parameters) {
  if (!of.fit) {
    of.fault = "it could not be fitted";
    return;
  }
  if (!of.fit->unit_covariance.allFinite()) {
    of.fault = "the views do not determine its coefficients";
    return;
  }
  if (!known_of(views, *of.fit, std::max(width_px, height_px)).enough(parameters)) {
    of.fault = "with it the views do not tell the focal length or the centre";
    return;
  }
  const auto model = model_of(of.fit->lens, width_px, height_px);
  if (!model) {
    of.fault = model.error().message;
    return;
  }
  // A point or two may lie beyond by their noise alone.
  constexpr double kMostBeyond = 0.005;
  double points = 0, beyond = 0;
  for (const FitView& view : views)
    for (const FitPoint& p : view)
      points += 1, beyond += model->direction({p.seen.x(), p.seen.y()}) ? 0 : 1;
  if (beyond > kMostBeyond * points) of.fault = "it folds back where points are";
  // A fisheye's picture may be a circle inside the image; a pinhole's fills it.
  if (of.fit->lens.model == LensModel::Fisheye) return;
  for (const Pixel& p : corners(width_px, height_px))
    of.folds_unseen = of.folds_unseen || !model->direction(p);
}

/// Degenerate where focal length or centre are known too badly.
Status determined(std::span<const FitView> views, const LensFit& fit, int longest_px,
                  const CalibrationParameters& parameters) {
  const Known known = known_of(views, fit, longest_px);
  const double spread = tilt_spread_deg(fit);
  if (known.enough(parameters) && spread >= 0.5 * kLeastTiltSpread_deg) return {};
  if (spread < kLeastTiltSpread_deg)
    return Error{ErrorCode::Degenerate,
                 "the target is tilted alike in all " + std::to_string(views.size()) + " views" +
                     text(" (within %.1f degrees), so the focal length cannot be told from the "
                          "distance; tilt it by 20 to 45 degrees, to either side and up and down",
                          spread)};
  const auto share = [](double x) {
    return std::isfinite(x) ? text("%.1f %%", 100 * x) : std::string("nothing");
  };
  return Error{ErrorCode::Degenerate,
               "the views determine the focal length to " + share(known.focal) +
                   " and the centre to " + share(known.centre) +
                   text(" of the image only (one sigma; %.1f %% and %.1f %% are asked for); add "
                        "views, nearer, and tilted more and to different sides",
                        100 * parameters.max_focal_sigma, 100 * parameters.max_centre_sigma)};
}

/// The views' figures, under the lens that was chosen.
void describe(std::vector<CalibrationView>& views, const ViewSelection& selection,
              const LensFit& fit) {
  const auto tell = [](CalibrationView& view, const FitView& points, const Lens& lens,
                       const TargetPose& pose) {
    view.tilt_deg = tilt_deg(pose);
    view.rms_px = rms_px(points, lens, pose);
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const FitPoint& p : points) {
      view.residuals.push_back(
          residual(lens, pose, p)
              .value_or(Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN())));
      view.left_out.push_back(!(p.weight > 0));
      middle += p.on_target / static_cast<double>(points.size());
    }
    view.distance = (pose.rotation.leftCols<2>() * middle + pose.translation).norm();
    Eigen::Matrix<double, 3, 4> camera_from_target;
    camera_from_target << pose.rotation, pose.translation;
    view.camera_from_target = camera_from_target;
  };
  for (std::size_t i = 0; i < selection.active().size(); ++i) {
    CalibrationView& view = views[selection.active()[i]];
    view.used = true;
    tell(view, selection.points()[i], fit.lens, fit.poses[i]);
  }
  for (CalibrationView& view : views) {
    if (view.used || !view.target) continue;
    FitView points;
    for (const TargetPoint& p : view.target->points)
      points.push_back({p.on_target, {p.seen.u, p.seen.v}, 1.0});
    const auto pose = pose_under(points, fit.lens);
    if (!pose) continue;
    // Discs' offsets are well below what views are rejected for.
    if (const auto posed = fit_lens({&points, 1}, fit.lens, {&*pose, 1}, {}, false, 30))
      tell(view, points, fit.lens, posed->poses[0]);
  }
}

ImageCoverage coverage_of(const ViewSelection& selection, const CameraModel& camera) {
  constexpr int kLonger = 10;
  const int width = camera.width_px(), height = camera.height_px();
  const double cell = std::max(width, height) / static_cast<double>(kLonger);
  ImageCoverage coverage;
  coverage.columns = std::max(1, static_cast<int>(std::lround(width / cell)));
  coverage.rows = std::max(1, static_cast<int>(std::lround(height / cell)));
  coverage.points.assign(static_cast<std::size_t>(coverage.columns * coverage.rows), 0);
  const double u0 = camera.camera_matrix()(0, 2), v0 = camera.camera_matrix()(1, 2);
  double farthest = 0, corner = 0;
  for (const FitView& view : selection.points())
    for (const FitPoint& p : view) {
      if (!(p.weight > 0)) continue;
      const int column = std::clamp(static_cast<int>((p.seen.x() + 0.5) / width * coverage.columns),
                                    0, coverage.columns - 1);
      const int row = std::clamp(static_cast<int>((p.seen.y() + 0.5) / height * coverage.rows), 0,
                                 coverage.rows - 1);
      ++coverage.points[static_cast<std::size_t>(row * coverage.columns + column)];
      farthest = std::max(farthest, std::hypot(p.seen.x() - u0, p.seen.y() - v0));
    }
  for (const Pixel& p : corners(width, height))
    corner = std::max(corner, std::hypot(p.u - u0, p.v - v0));
  const auto covered =
      std::count_if(coverage.points.begin(), coverage.points.end(), [](int n) { return n > 0; });
  coverage.share = static_cast<double>(covered) / static_cast<double>(coverage.points.size());
  coverage.radius_share = farthest / corner;
  return coverage;
}

/// How far the pixel of a direction moves with the parameters' uncertainty; NaN where the lens
/// does not reach.
double pixel_sigma(const TargetCalibration& result, const LensFit& fit, const Pixel& pixel) {
  const auto direction = result.camera.direction(pixel);
  Projection at;
  if (!direction || !project(fit.lens, direction->v, true, at))
    return std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd j(2, static_cast<Eigen::Index>(fit.free.size()));
  for (std::size_t i = 0; i < fit.free.size(); ++i)
    j.col(static_cast<Eigen::Index>(i)) = at.by_lens.col(fit.free[i]);
  return std::sqrt((j * result.covariance * j.transpose()).trace());
}

std::vector<std::string> notes_of(const TargetCalibration& result, const LensFit& fit) {
  std::vector<std::string> notes;
  const auto& a = result.camera.camera_matrix();
  if (result.used_views() < 8)
    notes.push_back("only " + std::to_string(result.used_views()) +
                    " views were used; 10 to 20 make sigmas smaller and faults easier to see");
  if (result.coverage.share < 0.6)
    notes.push_back(
        text("the target was seen in %.0f %% of the image only; add views with it near "
             "the edges and corners",
             100 * result.coverage.share));
  if (result.coverage.radius_share < 0.85)
    notes.push_back(
        text("no point lies farther out than %.0f %% of the way to the image's corner: "
             "the distortion beyond is extrapolated",
             100 * result.coverage.radius_share));
  std::size_t left_out = 0;
  for (const CalibrationView& view : result.views)
    if (view.used)
      left_out +=
          static_cast<std::size_t>(std::count(view.left_out.begin(), view.left_out.end(), true));
  if (50 * left_out > result.points)
    notes.push_back(std::to_string(left_out) +
                    " points were left out because their residuals "
                    "stand out: the target is not flat, or the lens model too simple");
  if (result.tilt_spread_deg < 25)
    notes.push_back(
        text("the target's tilt varies by %.0f degrees only; 40 and more tell the "
             "focal length better",
             result.tilt_spread_deg));
  const double ratio = a(0, 0) / a(1, 1) - 1;
  Eigen::VectorXd by = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fit.free.size()));
  by[0] = 1 / a(1, 1), by[1] = -a(0, 0) / (a(1, 1) * a(1, 1));
  if (std::abs(ratio) > std::max(0.003, 4 * std::sqrt(by.dot(result.covariance * by))))
    notes.push_back(
        text("the two focal lengths differ by %.2f %%: pixels are not square, or the "
             "target's rows and columns are not spaced alike",
             100 * ratio));
  const auto chosen = std::find_if(result.candidates.begin(), result.candidates.end(),
                                   [](const LensCandidate& c) { return c.chosen; });
  if (chosen != result.candidates.end() && !chosen->fault.empty())
    notes.push_back("no lens model is without fault; of the one that was taken, " + chosen->fault);
  if (chosen != result.candidates.end() && chosen->folds_unseen)
    notes.push_back(
        "the lens model folds back before it reaches the image's corners, which then "
        "show nothing: add views there");
  return notes;
}

}  // namespace

std::size_t TargetCalibration::used_views() const {
  return static_cast<std::size_t>(
      std::count_if(views.begin(), views.end(), [](const CalibrationView& v) { return v.used; }));
}

Result<TargetCalibration> calibrate_views(std::vector<CalibrationView> views, int width_px,
                                          int height_px, LensChoice choice,
                                          const CalibrationParameters& parameters,
                                          const Progress& progress) {
  WATERSKY_CHECK(validate(parameters));
  ViewSelection selection(views, parameters);
  WATERSKY_CHECK(selection.enough("show the target"));
  selection.reject_copies();
  selection.reject_blurred();
  WATERSKY_CHECK(selection.enough("show the target sharp and at a place of its own"));
  WATERSKY_TRY(const LensFit settled, selection.settle(choice, width_px, height_px));
  const int longest = std::max(width_px, height_px);
  // Without tilt all that follows is noise. With it, another model may know what this one does not.
  if (tilt_spread_deg(settled) < kLeastTiltSpread_deg)
    WATERSKY_CHECK(determined(selection.points(), settled, longest, parameters));

  // Every model is fitted to the same points of the same views.
  const std::vector<LensFamily> all = families(choice);
  std::vector<FamilyFit> fits;
  std::optional<LensStart> start;  // of the lens model that did not settle
  for (const LensFamily& family : all) {
    FamilyFit of;
    if (family.model == settled.lens.model) {
      Lens lens = settled.lens;
      for (int i = 4; i < kLensParameters; ++i)
        if (std::find(family.free.begin(), family.free.end(), i) == family.free.end())
          lens.parameters[static_cast<std::size_t>(i)] = 0;
      of.fit = fit_lens(selection.points(), lens, settled.poses, family.free);
    } else {
      if (!start) start = start_lens(selection.points(), family.model, width_px, height_px);
      std::vector<TargetPose> poses;
      for (std::size_t i = 0; start && i < start->poses.size(); ++i)
        if (start->poses[i]) poses.push_back(*start->poses[i]);
      if (start && poses.size() == selection.points().size())
        of.fit = fit_family(selection.points(), family, start->lens, poses);
    }
    judge(of, selection.points(), width_px, height_px, parameters);
    fits.push_back(std::move(of));
  }
  LensDecision decision =
      choose_lens(selection.points(), all, fits, parameters.simpler_within_sigmas,
                  [&](std::size_t i) { report(progress, "lens models", i, all.size()); });
  report(progress, "lens models", all.size(), all.size());
  if (!fits[decision.chosen].fit)
    return Error{ErrorCode::Degenerate,
                 "no lens model could be fitted; is the target flat and tilted between views?"};

  LensFit fit = *fits[decision.chosen].fit;
  for (std::size_t round = 0; round <= views.size() + 3; ++round) {
    selection.correct_discs(fit);
    selection.leave_out_points(fit, parameters.point_outlier_sigmas);
    const bool rejected = selection.reject_worst(fit);
    WATERSKY_CHECK(selection.enough("show the target without fault"));
    auto next = fit_lens(selection.points(), fit.lens, fit.poses, fit.free);
    if (!next) break;
    const bool still =
        std::abs(next->lens.parameters[0] - fit.lens.parameters[0]) < 1e-7 * fit.lens.parameters[0];
    fit = *std::move(next);
    if (!rejected && still) break;
  }
  WATERSKY_CHECK(determined(selection.points(), fit, longest, parameters));

  WATERSKY_TRY(CameraModel camera, model_of(fit.lens, width_px, height_px));
  TargetCalibration result(std::move(camera));
  result.covariance = covariance_of(selection.points(), fit);
  const int count = fit.lens.model == LensModel::Fisheye ? 8 : kLensParameters;
  for (int i = 0; i < count; ++i) {
    const auto at = std::find(fit.free.begin(), fit.free.end(), i);
    EstimatedParameter p{std::string(parameter_name(fit.lens.model, i)),
                         fit.lens.parameters[static_cast<std::size_t>(i)], 0.0,
                         at != fit.free.end()};
    const auto place = at - fit.free.begin();
    if (p.estimated) p.sigma = std::sqrt(result.covariance(place, place));
    result.parameters.push_back(std::move(p));
  }
  const Noise noise = noise_of(selection.points(), fit);
  result.rms_px = noise.rms_px;
  result.sigma_px = noise.sigma_px;
  result.points = noise.points;
  describe(views, selection, fit);
  const DetectedTarget& target = *views[selection.active().front()].target;
  result.kind = target.kind;
  result.size = target.size;
  result.views = std::move(views);
  result.candidates = std::move(decision.candidates);
  result.tilt_spread_deg = tilt_spread_deg(fit);
  result.coverage = coverage_of(selection, result.camera);
  for (const Pixel& p : corners(width_px, height_px)) {
    const double sigma = pixel_sigma(result, fit, p);
    if (!(sigma <= result.corner_sigma_px)) result.corner_sigma_px = sigma;
  }
  result.middle_sigma_px = pixel_sigma(result, fit, {0.5 * (width_px - 1), 0.5 * (height_px - 1)});
  result.notes = notes_of(result, fit);
  return result;
}

}  // namespace watersky
