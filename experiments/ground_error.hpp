// SPDX-License-Identifier: MIT
#pragma once
/// How far from where they are a prepared flight's frames put what their pixels show.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "watersky/base/time.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

/// Longest gap between poses, for every contender.
inline constexpr Duration kPoseGap = std::chrono::milliseconds(500);

/// Whether a camera looks down to 15°; others are in a turn.
[[nodiscard]] bool is_level(const Rigid3<World, Camera>& world_from_camera);

/// Of each frame that is judged, the errors of a grid of its pixels, north and east; empty where
/// the prepared flight left the frame out.
struct GroundErrors {
  std::vector<std::vector<Eigen::Vector2d>> of_frame_m;
  [[nodiscard]] std::size_t frames_left_out() const;
};

/// Judges each `step`th frame of the recording whose camera truly was level.
[[nodiscard]] GroundErrors ground_errors(const Flight& prepared, const sim::Simulation& recording,
                                         int step = 1);

/// Leaves the frames that nobody left out: nobody may win by leaving out the hard ones.
void keep_common(const std::vector<GroundErrors*>& all);

/// Root mean squares of the errors' lengths, both axes together; NaN without any.
struct GroundAccuracy {
  double absolute_m = 0.0;
  double shape_m = 0.0;  ///< after taking out the flight's mean error
};
[[nodiscard]] GroundAccuracy judge(const GroundErrors& errors);

}  // namespace watersky::study
