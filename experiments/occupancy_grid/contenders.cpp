// SPDX-License-Identifier: MIT
#include <algorithm>
#include <map>

#include "study.hpp"

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

Flight with_mount(const Flight& flight, const Mount& mount) {
  Flight out = flight;
  out.mount = mount;
  return out;
}

std::vector<Contender> contenders(const sim::Truth& truth) {
  const auto constant = [](const Flight& f) { return with_constant_delay(f, 0.25); };
  const auto times = [truth](const Flight& f) { return with_true_times(f, truth); };
  const auto all = [truth](const Flight& f) -> Result<Flight> {
    WATERSKY_TRY(const Flight timed, with_true_times(f, truth));
    return with_mount(timed, truth.mount);
  };
  return {
      {"algorithm1", "Algorithm 1, latest pose", Mapper::Algorithm1, with_latest_pose},
      {"algorithm1_250ms", "Algorithm 1, 250 ms", Mapper::Algorithm1, constant},
      {"algorithm1_oracle", "Algorithm 1, true times and mount", Mapper::Algorithm1, all},
      {"tagged", "our map, latest pose", Mapper::IceMap, with_latest_pose},
      {"constant_250ms", "our map, 250 ms", Mapper::IceMap, constant},
      {"true_times", "our map, true times", Mapper::IceMap, times},
      {"oracle", "our map, true times and mount", Mapper::IceMap, all},
  };
}

const Contender& drawn(const std::vector<Contender>& contenders) {
  for (const std::string_view name : {"ours", "oracle"})
    for (const Contender& contender : contenders)
      if (contender.name == name) return contender;
  return contenders.back();
}

}  // namespace watersky::study
