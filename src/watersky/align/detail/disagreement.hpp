// SPDX-License-Identifier: MIT
#pragma once
/// How far apart the poses of a flight put the places that two frames show.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "watersky/align/frame_pairs.hpp"
#include "watersky/flight/flight.hpp"

namespace watersky::detail {

/// Delays at which poses are looked up, -0.6 to 0.6 s; between them they are interpolated.
inline constexpr int kDelays = 13;
inline constexpr int kNoDelay = kDelays / 2;
inline constexpr double kDelayStep_s = 0.1;
inline constexpr int kQuarters = 4;

/// One frame's camera in World, at each delay, and the sea below it.
struct SeenFrame {
  std::array<Eigen::Quaterniond, kDelays> rotation;
  std::array<Eigen::Vector3d, kDelays> origin;
  Eigen::Vector3d sea = Eigen::Vector3d::Zero();  ///< the point of the sea under it
  Eigen::Vector3d up = -Eigen::Vector3d::UnitZ();
  double time_s = 0.0;  ///< since any one moment
  [[nodiscard]] double height_m() const { return (origin[kNoDelay] - sea).dot(up); }
};

/// nullopt where the frame cannot be placed.
[[nodiscard]] std::optional<SeenFrame> see_frame(const Flight& flight, const ImageFrame& frame,
                                                 Duration max_gap);

/// A pair's tie points as unit directions of the camera, for images stored as they are and turned
/// by one, two or three quarters (empty where the image's size does not allow it).
struct PairRays {
  std::size_t a = 0, b = 0;  ///< of the seen frames
  std::array<std::vector<Eigen::Vector3d>, kQuarters> rays_a, rays_b;
};

/// Of at most `most` of a pair's points.
[[nodiscard]] PairRays pair_rays(const CameraModel& camera, const RegisteredPair& pair,
                                 std::size_t a, std::size_t b, std::size_t most);

/// What may be off without being a fault.
struct Nuisance {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< of the camera in its own axes, rad
  double log_height = 0.0;                         ///< of the true height over the recorded
  double delay_s = 0.0;  ///< poses are to be taken so much later than they were
  /// Of the ice; of its two axes along the sea in World.
  Eigen::Vector2d drift_m_s = Eigen::Vector2d::Zero();
};
/// Beyond these it is a fault, and must not pass for none; a height to be found is free.
inline constexpr double kMostTurn_rad = 0.14, kMostLogHeight = 0.16, kMostDrift_m_s = 1.5;
struct NuisancePrior {
  double turn_rad = 0.06;
  double log_height = 0.08;
  double delay_s = 0.4;
  double drift_m_s = 0.3;
  [[nodiscard]] bool free_height() const { return log_height > 0.5; }
};

/// `quarters[i]`: by how much frame i's image is stored turned; empty: none is.
using Quarters = std::vector<int>;

struct Fit {
  Nuisance nuisance;
  std::vector<double> pair_m;     ///< root mean square over the pair's points
  double cost = 0.0;              ///< Cauchy's, of pairs, and the prior's
  double sigma_log_height = 0.0;  ///< one sigma, from the residuals
};

class Disagreement {
 public:
  /// `noise_m`: what a pair may disagree by without a fault; `cap_m`: where it stops counting
  /// more, and what a place counts that one of the poses puts above the horizon.
  Disagreement(std::vector<PairRays> pairs, double noise_m, double cap_m)
      : pairs_(std::move(pairs)), noise_m_(noise_m), cap_m_(cap_m) {}

  [[nodiscard]] const std::vector<PairRays>& pairs() const { return pairs_; }
  [[nodiscard]] double noise_m() const { return noise_m_; }
  [[nodiscard]] double cap_m() const { return cap_m_; }

  [[nodiscard]] double of_pair(std::size_t pair, std::span<const SeenFrame> frames, int quarters_a,
                               int quarters_b, const Nuisance& nuisance = {}) const;
  [[nodiscard]] double cost_of(double pair_m) const;

  /// The nuisances under which the pairs agree best, robustly.
  [[nodiscard]] Fit fit(std::span<const SeenFrame> frames, const Quarters& quarters,
                        const NuisancePrior& prior) const;

  /// Where a frame of a pair puts the pair's points, as they lay at time 0 if the ice drifts; not
  /// finite above the horizon.
  [[nodiscard]] std::vector<Eigen::Vector3d> on_sea(std::span<const SeenFrame> frames,
                                                    std::size_t frame,
                                                    std::span<const Eigen::Vector3d> rays,
                                                    const Nuisance& nuisance) const;

 private:
  [[nodiscard]] Eigen::VectorXd residuals(std::span<const SeenFrame> frames,
                                          const Quarters& quarters, const Nuisance& nuisance) const;
  [[nodiscard]] std::vector<double> by_pair(const Eigen::VectorXd& residuals) const;

  std::vector<PairRays> pairs_;
  double noise_m_, cap_m_;
};

[[nodiscard]] double median_of(std::vector<double> values);

}  // namespace watersky::detail
