// SPDX-License-Identifier: MIT
#include "preparations.hpp"

#include <algorithm>

#include "watersky/align/live_alignment.hpp"

namespace watersky::study {

Result<Flight> with_latest_pose(const Flight& flight) {
  Flight out = flight;
  const std::vector<StampedPose>& poses = flight.trajectory.poses();
  for (ImageFrame& frame : out.frames) {
    if (!frame.received_at)
      return Error{ErrorCode::InvalidInput, frame.name + ": its time of arrival is not known"};
    const auto after = std::upper_bound(poses.begin(), poses.end(), *frame.received_at,
                                        [](Time t, const StampedPose& p) { return t < p.time; });
    if (after == poses.begin()) continue;  // left out by the mapping: no pose had come in yet
    frame.own_pose = *(after - 1);
    frame.captured_at = frame.received_at;
  }
  return out;
}

Result<Flight> with_constant_delay(const Flight& flight, double delay_s) {
  Flight out = flight;
  for (ImageFrame& frame : out.frames) frame.captured_at.reset();
  out.delay_s = delay_s;
  return out;
}

Result<Flight> with_true_times(const Flight& flight, const sim::Truth& truth) {
  Flight out = flight;
  if (out.frames.size() != truth.frames.size())
    return Error{ErrorCode::InvalidInput, "the truth is of another flight"};
  for (std::size_t i = 0; i < out.frames.size(); ++i)
    out.frames[i].captured_at = truth.frames[i].captured_at;
  return out;
}

Result<Flight> with_true_times_and_mount(const Flight& flight, const sim::Truth& truth) {
  WATERSKY_TRY(Flight out, with_true_times(flight, truth));
  out.mount = truth.mount;
  return out;
}

Result<AlignedFlight> align_by_images(const Flight& flight) {
  WATERSKY_TRY(Alignment alignment, align_flight(flight, {.parameters = {}, .threads = 2}));
  WATERSKY_TRY(Flight corrected, aligned(flight, alignment));
  return AlignedFlight{std::move(corrected), std::move(alignment)};
}

Result<Flight> with_alignment(const Flight& flight) {
  WATERSKY_TRY(AlignedFlight ours, align_by_images(flight));
  return std::move(ours.flight);
}

Result<Flight> with_live_alignment(const Flight& flight) {
  WATERSKY_TRY(const Alignment alignment, align_flight_causally(flight, {}));
  return aligned(flight, alignment);
}

}  // namespace watersky::study
