// SPDX-License-Identifier: MIT
#pragma once
/// Flights on which aligning by the images could do harm.
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

struct Case {
  std::string name;   ///< as figures spell it: never_worse.<name>.…
  std::string title;  ///< as tables spell it
  sim::Scenario scenario;
};

/// The laboratory and the flight outdoors as they are, and what makes each hard. Flights of
/// `duration_s` at `share` of the presets' pixels along each side. NotFound: never, the presets
/// being the simulator's own.
[[nodiscard]] Result<std::vector<Case>> cases(double duration_s, double share);

}  // namespace watersky::study
