// SPDX-License-Identifier: MIT
#pragma once
/// What a simulated flight knows from outside its pictures.
#include <utility>
#include <vector>

#include "watersky/sim/detail/motion.hpp"

namespace watersky::sim {

/// One anchor as it is recorded, sighted in the frames whose names and true times are given.
[[nodiscard]] Anchor recorded_anchor(const Scenario& scenario, const Motion& motion,
                                     const Geodetic& scene,
                                     const std::vector<std::pair<std::string, double>>& frames,
                                     Time start);

/// The range finder's measurements from `from_s` to `to_s` after `start`.
[[nodiscard]] std::vector<RangeSample> recorded_ranges(const Scenario& scenario,
                                                       const Motion& motion, const Geodetic& scene,
                                                       Time start, double from_s, double to_s);

}  // namespace watersky::sim
