// SPDX-License-Identifier: MIT
#pragma once
/// Simulated flights whose images are made once. Rendering a frame takes longer than whatever is
/// done with it, and an alignment looks at each several times, every contender anew.
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

/// A flight as it was recorded, and the truth. Images are made when first asked for and kept,
/// whoever asks for them; they go with the last copy of the flight.
[[nodiscard]] Result<sim::Simulation> record(const sim::Scenario& scenario);

/// Makes the images of these frames on two threads.
Status render(const std::vector<const ImageFrame*>& frames);
/// Of all frames.
Status render(const Flight& flight);

/// Each `step`th frame: the same for all contenders.
[[nodiscard]] std::vector<const ImageFrame*> every(const Flight& flight, int step);

}  // namespace watersky::study
