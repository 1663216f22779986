// SPDX-License-Identifier: MIT
#include "watersky/align/detail/starting_priors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace watersky::align {

namespace {

constexpr double kDelayUnknownSigma_s = 0.3, kDelayGivenSigma_s = 0.05;
/// What an attitude is good for where the recording does not say; positions a share of the height.
constexpr double kAttitudeSigma_rad = 0.5 * std::numbers::pi / 180;
constexpr double kPositionShare = 0.01;
/// Beyond this many times what was said or assumed of the navigation, residuals are believed to
/// come from elsewhere.
constexpr double kMostGrowth = 5.0;
constexpr double kEncoderSigma_deg = 1.0, kGimbalLatencySigma_s = 0.05, kDriftSigma_m_s = 0.5;

}  // namespace

void set_navigation_priors(AdjustmentPriors& priors, const PoseSigma& said, double height_m) {
  for (int k = 0; k < 3; ++k) {
    const double position_m = said.position_north_east_down_m[k];
    const double attitude_rad = said.roll_pitch_yaw_rad[k];
    priors.knot[k] = position_m > 0 ? position_m : kPositionShare * height_m;
    priors.knot[k + 3] = attitude_rad > 0 ? attitude_rad : kAttitudeSigma_rad;
  }
  priors.knot_most = kMostGrowth * priors.knot;
}

AdjustmentPriors starting_priors(const Flight& flight, const AlignParameters& p,
                                 const PoseSigma& said, double height_m) {
  AdjustmentPriors priors;
  std::tie(priors.position_correlation_s, priors.attitude_correlation_s) =
      kCorrelationIdeas_s.front();
  set_navigation_priors(priors, said, height_m);
  Globals::Vector& g = priors.globals;
  g.segment<3>(Globals::kMount)
      .setConstant(flight.mount.sigma_rad > 0 ? flight.mount.sigma_rad
                                              : Angle::degrees(p.mount_sigma_deg).radians());
  // Where the ruler's error is less than a fraction of a pixel there is nothing to look for.
  if (p.lever_arm_sigma_m > 0.5 * height_m / flight.camera.focal_px())
    g.segment<3>(Globals::kLever).setConstant(p.lever_arm_sigma_m);
  g[Globals::kFocal] = flight.calibration.focal_sigma_px > 0
                           ? flight.calibration.focal_sigma_px / flight.camera.focal_px()
                           : 0.01 * p.focal_sigma_percent;
  g[Globals::kHeight] = flight.sea_level->sigma_m;
  if (flight.gimbal_reference) {
    g.segment<3>(Globals::kEncoder).setConstant(Angle::degrees(kEncoderSigma_deg).radians());
    g[Globals::kLatency] = kGimbalLatencySigma_s;
  }
  if (p.estimate_ice_drift) g.segment<2>(Globals::kDrift).setConstant(kDriftSigma_m_s);
  priors.delay_walk_s = p.delay_walk_s;
  priors.delay_s = flight.delay_s ? kDelayGivenSigma_s : kDelayUnknownSigma_s;
  priors.jitter_s = 0.0;
  return priors;
}

}  // namespace watersky::align
