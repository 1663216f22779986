// SPDX-License-Identifier: MIT
#pragma once
/// What a flight is taken to be before it is mapped: ways to give each frame its time, and the
/// camera its mount, that an estimate is compared with.
#include "watersky/align/alignment.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

/// "Latest pose": each frame is taken to be captured when it arrives, and to have the last pose
/// that had come in by then, as the thesis's node did. InvalidInput without a time of arrival.
[[nodiscard]] Result<Flight> with_latest_pose(const Flight& flight);
[[nodiscard]] Result<Flight> with_constant_delay(const Flight& flight, double delay_s);
/// InvalidInput when the truth is of another flight.
[[nodiscard]] Result<Flight> with_true_times(const Flight& flight, const sim::Truth& truth);
[[nodiscard]] Result<Flight> with_true_times_and_mount(const Flight& flight,
                                                       const sim::Truth& truth);

/// What the images tell of time, mount and poses, and nothing else.
struct AlignedFlight {
  Flight flight;
  Alignment alignment;
};
[[nodiscard]] Result<AlignedFlight> align_by_images(const Flight& flight);
/// Ours: the flight alone.
[[nodiscard]] Result<Flight> with_alignment(const Flight& flight);
/// Each frame by what came before it alone, as in flight.
[[nodiscard]] Result<Flight> with_live_alignment(const Flight& flight);

}  // namespace watersky::study
