// SPDX-License-Identifier: MIT
/// Do a map's probabilities mean what they say, and how well does it lie, on simulated flights with
/// realistic navigation: GNSS 1 m over 60 s, attitude 0.7° over 10 s, delay and mount unknown.
///
///   map_calibration [SEEDS]     10 by default
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "preparations.hpp"
#include "support/print_figure.hpp"
#include "watersky/evaluation/evaluation.hpp"

using namespace watersky;
using study::print_figure;

namespace {

struct Worst {
  double ece = 0, ece_near = 0, ece_evidence = 0, ece_evidence_near = 0, mean_ece = 0, iou = 0;
  int flights = 0;
};

void judge(const char* name, const Flight& flight, const sim::Truth& truth, Worst& worst) {
  MappingOptions options;
  options.parameters.map.cell_m = 0.5;
  options.parameters.mosaic = false;
  options.threads = 2;
  const auto run = map_flight(flight, options);
  const auto result = run ? evaluate(*run, truth) : Result<Evaluation>(run.error());
  if (!result) {
    std::fprintf(stderr, "%s: %s\n", name, result.error().message.c_str());
    return;
  }
  const double located = result->located.calibration_error(),
               near = result->located_near_edges.calibration_error(),
               evidence = result->evidence.calibration_error(),
               evidence_near = result->evidence_near_edges.calibration_error();
  std::fprintf(stderr,
               "  %-22s IoU %.3f, ECE %.3f (near edges %.3f); unsoftened %.3f (near edges %.3f)\n",
               name, result->raster.iou, located, near, evidence, evidence_near);
  worst.ece = std::max(worst.ece, located);
  worst.ece_near = std::max(worst.ece_near, near);
  worst.ece_evidence = std::max(worst.ece_evidence, evidence);
  worst.ece_evidence_near = std::max(worst.ece_evidence_near, evidence_near);
  worst.mean_ece += located;
  worst.iou += result->raster.iou;
  ++worst.flights;
}

void print(const std::string& name, const Worst& w) {
  if (w.flights == 0) return;
  print_figure(name + ".ece_worst", w.ece, "1");
  print_figure(name + ".ece_mean", w.mean_ece / w.flights, "1");
  print_figure(name + ".ece_near_edges_worst", w.ece_near, "1");
  print_figure(name + ".ece_unsoftened_worst", w.ece_evidence, "1");
  print_figure(name + ".ece_unsoftened_near_edges_worst", w.ece_evidence_near, "1");
  print_figure(name + ".iou_mean", w.iou / w.flights, "1");
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 10;
  if (seeds < 1) {
    std::fprintf(stderr, "map_calibration: SEEDS must be a number from 1, is %s\n", argv[1]);
    return 2;
  }
  Worst ours, constant, oracle;
  for (int seed = 1; seed <= seeds; ++seed) {
    auto scenario = sim::scenario_preset("outdoor");
    if (!scenario) return std::fprintf(stderr, "%s\n", scenario.error().message.c_str()), 1;
    scenario->seed = seed;
    const auto simulation = sim::simulate(*scenario);
    if (!simulation) return std::fprintf(stderr, "%s\n", simulation.error().message.c_str()), 1;
    std::fprintf(stderr, "seed %d\n", seed);
    const auto each = [&](const char* name, const Result<Flight>& flight, Worst& worst) {
      if (flight)
        judge(name, *flight, simulation->truth, worst);
      else
        std::fprintf(stderr, "  %s: %s\n", name, flight.error().message.c_str());
    };
    each("250 ms", study::with_constant_delay(simulation->flight, 0.25), constant);
    each("true times and mount",
         study::with_true_times_and_mount(simulation->flight, simulation->truth), oracle);
    each("ours", study::with_alignment(simulation->flight), ours);
  }
  print("map_calibration.constant_250ms", constant);
  print("map_calibration.true_times_and_mount", oracle);
  print("map_calibration.ours", ours);
  return 0;
}
