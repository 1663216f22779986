// SPDX-License-Identifier: MIT
/// What the live aligner costs: a simulated flight of half a minute at 30 Hz, 640x512, keyframes at
/// 5 Hz, poses and images given in order of arrival. Shares are CPU time of one core over the
/// flight's duration; decoding is not counted.
///
///   live_align [SECONDS [SEED]]     30 and 1 by default
#include <cstdlib>
#include <opencv2/core/utility.hpp>

#include "bench.hpp"
#include "watersky/align/live_alignment.hpp"
#include "watersky/sim/simulate.hpp"

using namespace watersky;

int main(int argc, char** argv) {
  const double seconds_long = argc > 1 ? std::atof(argv[1]) : 30.0;
  if (!(seconds_long >= 5)) {
    std::fprintf(stderr, "live_align: SECONDS must be a number from 5, is %s\n", argv[1]);
    return 2;
  }
  cv::setNumThreads(1);
  auto scenario = sim::scenario_preset("outdoor");
  if (!scenario) return std::fprintf(stderr, "%s\n", scenario.error().message.c_str()), 1;
  scenario->seed = argc > 2 ? std::atoi(argv[2]) : 1;
  scenario->camera.frame_rate_hz = 30.0;
  scenario->camera.images_in_turns = true;
  auto simulation = sim::simulate(*scenario);
  if (!simulation) return std::fprintf(stderr, "%s\n", simulation.error().message.c_str()), 1;
  Flight& flight = simulation->flight;
  const Time first = *flight.frames.front().received_at;
  std::erase_if(flight.frames, [&](const ImageFrame& f) {
    return to_seconds(*f.received_at - first) > seconds_long;
  });
  const double duration_s =
      to_seconds(*flight.frames.back().received_at - *flight.frames.front().received_at);

  const auto alignment = align_flight_causally(flight, {});
  if (!alignment) return std::fprintf(stderr, "%s\n", alignment.error().message.c_str()), 1;
  bench::print_figure("live_align.frames", static_cast<double>(flight.frames.size()), "1");
  bench::print_figure("live_align.keyframes", static_cast<double>(alignment->keyframes), "1");
  bench::print_figure("live_align.solver_share", alignment->solving_s / duration_s, "1");
  bench::print_figure("live_align.tracking_share", alignment->tracking_s / duration_s, "1");
  bench::print_figure("live_align.longest_solve_ms", 1e3 * alignment->longest_solve_s, "ms");
  bench::print_figure("live_align.held_out_median_m", alignment->after.median_m, "m");
  bench::print_figure("live_align.held_out_constant_delay_m", alignment->constant_delay.median_m,
                      "m");
  return alignment->method == AlignMethod::Full ? 0 : 1;
}
