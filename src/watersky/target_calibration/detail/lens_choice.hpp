// SPDX-License-Identifier: MIT
#pragma once
/// Which lens model the views call for.
#include <functional>

#include "watersky/target_calibration/detail/lens_fit.hpp"
#include "watersky/target_calibration/target_calibration.hpp"

namespace watersky::detail {

/// A lens model of which some coefficients are estimated and the others are zero.
struct LensFamily {
  std::string name;
  LensModel model;
  std::vector<int> free;
};

/// In order of their parameters; of as many, the pinhole comes first.
[[nodiscard]] std::vector<LensFamily> families(LensChoice choice);

/// The family's fit, begun with the simpler ones' results, so that high orders do not run away.
[[nodiscard]] std::optional<LensFit> fit_family(std::span<const FitView> views,
                                                const LensFamily& family, const Lens& start,
                                                std::span<const TargetPose> poses);

/// What is chosen: its place in `families`, and all that were tried.
struct LensDecision {
  std::size_t chosen = 0;
  std::vector<LensCandidate> candidates;
};

/// A fit of each family to all views (nullopt: failed), and what is wrong with it: `fault` forbids
/// to take it; one that folds where nothing was seen is taken if the others predict much worse.
struct FamilyFit {
  std::optional<LensFit> fit;
  std::string fault;
  bool folds_unseen = false;
};
[[nodiscard]] LensDecision choose_lens(std::span<const FitView> views,
                                       const std::vector<LensFamily>& families,
                                       const std::vector<FamilyFit>& fits,
                                       double simpler_within_sigmas,
                                       const std::function<void(std::size_t)>& tell);

}  // namespace watersky::detail
