// SPDX-License-Identifier: MIT
#pragma once
/// The registrars behind make_registrar().
#include <memory>

#include "watersky/registration/registration.hpp"

namespace watersky::detail {

/// What the thesis sets for a pair to be registered (4.3.2).
inline constexpr std::size_t kThesisFewestMatches = 4;
inline constexpr double kThesisMostMean_px = 5.0;
inline constexpr float kThesisTimesLeast = 2.0F;

[[nodiscard]] std::unique_ptr<Registrar> make_klt_registrar();

/// Orb, Sift, Akaze, Surf; what OpenCV cannot make is Unsupported.
[[nodiscard]] Result<std::unique_ptr<Registrar>> make_feature_registrar(RegistrationMethod method);

/// Indices of the matches no farther than twice the least distance. Where that is 0 those at 0.
[[nodiscard]] std::vector<std::size_t> within_twice_least(std::span<const float> distances);

/// Sets the two mean distances in B under `b_from_a`.
void measure_reprojection(Registration& found, const Eigen::Matrix3d& b_from_a,
                          std::span<const PointPair> inliers);

}  // namespace watersky::detail
