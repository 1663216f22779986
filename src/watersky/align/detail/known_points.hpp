// SPDX-License-Identifier: MIT
#pragma once
/// What the estimator knows from outside the pictures: sightings of anchors and measured heights.
/// Ties say how frames lie to each other; only these say where all of them lie.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "watersky/align/detail/navigation.hpp"

namespace watersky::align {

class Adjustment;
struct AdjustedFrame;

/// One sighting of an anchor. The anchor's own error is the same in all its sightings. It is no
/// unknown: each sighting is given it in full, times their number, so that together they say as
/// much of the place as is known of it; what frames are to each other ties say better.
struct KnownPoint {
  std::size_t anchor = 0, sighting = 0;  ///< in Flight::anchors
  int frame = 0;
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< over z, without distortion, camera axes
  double row = 0.0;                                     ///< in the readout, -0.5 to 0.5
  /// In Local at `at_s`, and how it moves.
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero(), velocity_m_s = Eigen::Vector3d::Zero();
  double at_s = 0.0;
  double sigma_px = 1.0;
  double sigma_m = 0.0, sigma_height_m = 0.0;  ///< of the anchor
  Eigen::Matrix2d whiten =
      Eigen::Matrix2d::Identity();  ///< makes a residual in px one of unit covariance
};

/// How much higher than the navigation says the body is, by a range finder over some seconds.
struct KnownHeight {
  double t_s = 0.0;
  double error_m = 0.0, sigma_m = 0.0;
  double robust = 1.0;  ///< weight, from the last look at the residuals
  std::size_t samples = 0;
};

struct KnownPoints {
  std::vector<KnownPoint> points;
  std::vector<std::string> notes;  ///< of sightings that cannot be used
};

/// The sightings of a flight's anchors in `frames`, which are those of Flight::frames that `of`
/// lists.
[[nodiscard]] KnownPoints known_points_of(const Flight& flight, const LocalFrame& local,
                                          const Navigation& navigation,
                                          const std::vector<std::size_t>& of,
                                          const std::vector<AdjustedFrame>& frames);

struct KnownHeights {
  std::vector<KnownHeight> heights;
  std::vector<std::string> notes;
};

/// A flight's ranges, made upright by the recorded attitude, less the recorded heights: the median
/// of every five seconds. Their sigma does not fall with their number: swell, freeboard and what
/// the instrument is off by are alike over seconds. Ranges in more than 30° of tilt are left out,
/// and all when they contradict the recorded heights by more than `most_m`.
[[nodiscard]] KnownHeights known_heights_of(const Flight& flight, const LocalFrame& local,
                                            const Navigation& navigation, Duration max_gap,
                                            double range_sigma_m, double most_m);

/// Weights by how far each height lies from the others, given where the estimator has them.
void weigh_heights(std::vector<KnownHeight>& heights, const std::vector<double>& residuals_m);

/// Which sightings agree with each other and with the navigation.
struct AnchorChoice {
  std::vector<KnownPoint> used;
  /// Where the pictures put the anchors less where they are: north, east of Local.
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();
  struct Rejected {
    KnownPoint point;
    double off_m = 0.0, off_px = 0.0;  ///< from where the used ones, or the navigation, put it
  };
  std::vector<Rejected> rejected;
  bool against_navigation = false;  ///< it is the navigation that those left out contradict
  bool undecided = false;           ///< they contradict each other, and nothing tells who errs
};

/// Of sightings by a solved adjustment. `offset_sigma_m` is what the navigation as a whole may be
/// off by. One anchor is used within five sigmas of the navigation; several that agree are believed
/// against it.
[[nodiscard]] AnchorChoice choose_anchors(const Adjustment& adjustment,
                                          const std::vector<KnownPoint>& points,
                                          double offset_sigma_m);

/// Sets `whiten` of each by the present state.
void whiten(const Adjustment& adjustment, std::vector<KnownPoint>& points);

/// Where a frame puts an anchor less where it is, along north and east of Local and at the anchor's
/// height; nullopt where the frame cannot see it.
[[nodiscard]] std::optional<Eigen::Vector2d> anchor_error_m(const Adjustment& adjustment,
                                                            const KnownPoint& point);

}  // namespace watersky::align
