// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/lens_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace watersky::detail {

namespace {

constexpr std::size_t kFolds = 10;

/// Mean squared residual of every view, each measured with a lens that was fitted without it.
std::vector<double> left_out_errors(std::span<const FitView> views, const LensFit& fit) {
  const std::size_t folds = std::min(kFolds, views.size());
  std::vector<double> errors(views.size(), std::numeric_limits<double>::infinity());
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<FitView> kept;
    std::vector<TargetPose> poses;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (v % folds != fold) kept.push_back(views[v]), poses.push_back(fit.poses[v]);
    const auto without = fit_lens(kept, fit.lens, poses, fit.free, false, 20);
    if (!without) continue;
    for (std::size_t v = fold; v < views.size(); v += folds) {
      const auto posed = fit_lens({&views[v], 1}, without->lens, {&fit.poses[v], 1}, {}, false, 20);
      double weight = 0;
      for (const FitPoint& p : views[v]) weight += p.weight;
      if (posed && weight > 0) errors[v] = posed->cost / weight;
    }
  }
  return errors;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// How much worse `a` is than `b`, in standard errors of the mean of their differences.
double standard_errors(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  std::vector<double> difference(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
  const double middle = mean(difference);
  if (!std::isfinite(middle)) return std::numeric_limits<double>::infinity();
  double square = 0;
  for (const double d : difference) square += (d - middle) * (d - middle);
  const double error = std::sqrt(square / (n * (n - 1)));
  return middle <= 0 ? 0 : middle / std::max(error, 1e-300);
}

}  // namespace

std::vector<LensFamily> families(LensChoice choice) {
  std::vector<LensFamily> all;
  const auto pinhole = [&](const char* name, std::vector<int> free) {
    if (choice != LensChoice::Fisheye)
      all.push_back({std::string("pinhole ") + name, LensModel::Pinhole, std::move(free)});
  };
  pinhole("k1", {0, 1, 2, 3, 4});
  pinhole("k1 k2", {0, 1, 2, 3, 4, 5});
  pinhole("k1 k2 p1 p2", {0, 1, 2, 3, 4, 5, 6, 7});
  if (choice != LensChoice::Pinhole)
    all.push_back({"fisheye k1 k2 k3 k4", LensModel::Fisheye, {0, 1, 2, 3, 4, 5, 6, 7}});
  pinhole("k1 k2 p1 p2 k3", {0, 1, 2, 3, 4, 5, 6, 7, 8});
  pinhole("k1 to k6 p1 p2", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  return all;
}

std::optional<LensFit> fit_family(std::span<const FitView> views, const LensFamily& family,
                                  const Lens& start, std::span<const TargetPose> poses) {
  Lens lens = start;
  std::vector<TargetPose> now(poses.begin(), poses.end());
  // The focal length with the lowest order first, then the centre, then all.
  for (const std::vector<int>& stage :
       {std::vector<int>{0, 1, 4}, std::vector<int>{0, 1, 2, 3, 4, 5}}) {
    if (stage.size() >= family.free.size()) break;
    const auto fit = fit_lens(views, lens, now, stage, false, 30);
    if (!fit) return std::nullopt;
    lens = fit->lens;
    now = fit->poses;
  }
  return fit_lens(views, lens, now, family.free);
}

LensDecision choose_lens(std::span<const FitView> views, const std::vector<LensFamily>& all,
                         const std::vector<FamilyFit>& fits, double simpler_within_sigmas,
                         const std::function<void(std::size_t)>& tell) {
  // What folds in a corner that no view covers is still right where there are views.
  constexpr double kMuchWorseSigmas = 3.0;
  LensDecision decision;
  std::vector<std::vector<double>> errors(all.size());
  std::optional<std::size_t> best, any;
  double points = 0;
  for (const FitView& view : views)
    for (const FitPoint& p : view) points += p.weight;
  for (std::size_t i = 0; i < all.size(); ++i) {
    tell(i);
    LensCandidate candidate;
    candidate.name = all[i].name;
    candidate.lens = all[i].model;
    candidate.parameters = static_cast<int>(all[i].free.size());
    candidate.fault = fits[i].fault;
    candidate.folds_unseen = fits[i].folds_unseen;
    if (fits[i].fit) {
      candidate.rms_px = std::sqrt(fits[i].fit->cost / points);
      errors[i] = left_out_errors(views, *fits[i].fit);
      candidate.left_out_rms_px = std::sqrt(mean(errors[i]));
      if (!any) any = i;
      if (candidate.fault.empty() && (!best || mean(errors[i]) < mean(errors[*best]))) best = i;
    }
    decision.candidates.push_back(std::move(candidate));
  }
  // Nothing without fault: the simplest that could be fitted.
  decision.chosen = best.value_or(any.value_or(0));
  if (best) {
    for (std::size_t i = 0; i < all.size(); ++i)
      if (fits[i].fit)
        decision.candidates[i].worse_by_sigmas = standard_errors(errors[i], errors[*best]);
    const auto simplest = [&](bool may_fold, double within) -> std::optional<std::size_t> {
      for (std::size_t i = 0; i < all.size(); ++i) {
        const LensCandidate& c = decision.candidates[i];
        if (fits[i].fit && c.fault.empty() && (may_fold || !c.folds_unseen) &&
            c.worse_by_sigmas <= within)
          return i;
      }
      return std::nullopt;
    };
    auto chosen = simplest(false, simpler_within_sigmas);
    if (!chosen) chosen = simplest(false, kMuchWorseSigmas);
    if (!chosen) chosen = simplest(true, simpler_within_sigmas);
    decision.chosen = chosen.value_or(*best);
  }
  decision.candidates[decision.chosen].chosen = fits[decision.chosen].fit.has_value();
  return decision;
}

}  // namespace watersky::detail
