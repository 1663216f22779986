// SPDX-License-Identifier: MIT
/// A recorded flight through the live aligner.
#include <algorithm>

#include "watersky/align/live_alignment.hpp"

namespace watersky {

namespace {

/// Something that comes in, in order of time.
struct Event {
  enum Kind { Pose, Gimbal, Frame };  // of one moment, poses first
  Time time;
  Kind kind;
  std::size_t index;
};

std::vector<Event> events_of(const Flight& flight, std::vector<LeftOut>& left_out) {
  std::vector<Event> events;
  const auto& poses = flight.trajectory.poses();
  const auto& rotations = flight.gimbal.rotations();
  for (std::size_t i = 0; i < poses.size(); ++i) events.push_back({poses[i].time, Event::Pose, i});
  for (std::size_t i = 0; i < rotations.size(); ++i)
    events.push_back({rotations[i].time, Event::Gimbal, i});
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const ImageFrame& f = flight.frames[i];
    const std::optional<Time> time = f.received_at   ? f.received_at
                                     : f.captured_at ? f.captured_at
                                     : f.own_pose    ? std::optional<Time>(f.own_pose->time)
                                                     : std::nullopt;
    if (time)
      events.push_back({*time, Event::Frame, i});
    else
      left_out.push_back({f.name, "it has neither a capture time nor an arrival time"});
  }
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
    return a.time != b.time ? a.time < b.time : a.kind < b.kind;
  });
  return events;
}

}  // namespace

Result<Alignment> align_flight_causally(const Flight& flight, const AlignOptions& options,
                                        const Progress& progress) {
  WATERSKY_TRY(LiveAligner aligner, LiveAligner::make(flight, options));
  Alignment out;
  out.mount = flight.mount;  // what was found of it is in the poses
  const std::vector<Event> events = events_of(flight, out.left_out);
  AlignMethod method = AlignMethod::AsGiven;
  std::vector<AlignedFrame> before_start;  // their times would be guessed
  const auto gather = [&](std::vector<LiveFrame> frames) {
    for (LiveFrame& f : frames) {
      method = f.method;
      if (!f.aligned) {
        out.left_out.push_back({flight.frames[f.id].name, f.aligned.error().message});
        continue;
      }
      const ImageFrame& frame = flight.frames[f.id];
      const bool untimed = f.method == AlignMethod::AsGiven && !flight.delay_s &&
                           !frame.captured_at && !frame.own_pose;
      (untimed ? before_start : out.frames).push_back(*std::move(f.aligned));
    }
  };
  std::size_t done = 0;
  constexpr double kSampled_s = 1.0;
  for (const Event& event : events) {
    if (event.kind == Event::Pose) {
      WATERSKY_CHECK(aligner.add_pose(flight.trajectory.poses()[event.index]));
    } else if (event.kind == Event::Gimbal) {
      WATERSKY_CHECK(aligner.add_gimbal(flight.gimbal.rotations()[event.index]));
    } else {
      report(progress, "aligning", done++, flight.frames.size());
      const ImageFrame& f = flight.frames[event.index];
      const int reduction = reduction_for_tracking(flight.camera);
      auto image = f.load({.color = false, .reduction = reduction});
      if (!image) continue;  // mapping meets it again and says so
      const auto is = [&](int r) {
        const CameraModel model = flight.camera.reduced_by(r);
        return image->cols == model.width_px() && image->rows == model.height_px();
      };
      if (!is(reduction) && !is(1)) continue;
      aligner.add_frame(event.index,
                        {f.captured_at, f.received_at, f.counter, f.own_pose, f.own_gimbal}, *image,
                        is(reduction) ? reduction : 1);
    }
    gather(aligner.take());
    if (event.kind != Event::Frame) continue;
    const LiveStatus now = aligner.status();
    if (now.started && now.delay_sigma_s > 0.0 &&
        (out.delay.empty() || to_seconds(event.time - out.delay.back().received) >= kSampled_s))
      out.delay.push_back({event.time, now.delay_s, now.delay_sigma_s});
  }
  gather(aligner.finish());
  report(progress, "aligning", flight.frames.size(), flight.frames.size());
  const LiveStatus last = aligner.status();
  for (AlignedFrame& f : before_start) {
    if (last.started)
      out.left_out.push_back({flight.frames[f.index].name, "the delay was not known yet"});
    else
      out.frames.push_back(std::move(f));
  }
  out.method = method;
  if (!last.started)
    out.method_reason = out.frames.empty() ? "no frame has both a time and poses around it"
                                           : "the images' motion never told their delay";
  else if (method != AlignMethod::Full)
    out.method_reason =
        "at the end places that took no part agreed no better with all that was "
        "found than without";
  out.estimates = last.estimates;
  out.delay_estimated = !out.delay.empty();
  out.as_given = last.as_given;
  out.constant_delay = last.constant_delay;
  out.after = last.after;
  out.pixel_sigma = last.pixel_sigma;
  out.navigation_sigma = last.navigation_sigma;
  out.shared_covariance_m2 = last.shared_covariance_m2;
  out.keyframes = last.keyframes;
  out.sightings = last.sightings;
  out.tracking_s = last.tracking_s;
  out.solving_s = last.solving_s;
  out.longest_solve_s = last.longest_solve_s;
  out.notes = last.notes;
  out.notes.emplace_back("Each frame was aligned by what came before it alone, as in flight.");
  std::stable_sort(
      out.frames.begin(), out.frames.end(),
      [](const AlignedFrame& x, const AlignedFrame& y) { return x.captured < y.captured; });
  return out;
}

}  // namespace watersky
