// SPDX-License-Identifier: MIT
/// Maps simulated flights with exact poses and compares with the truth: the repository's fixed sea
/// that is not easy, nadir and 30° oblique, and the same 40 km from the datum; 0.5 m cells from
/// 100 m.
///
///   simulated_accuracy [SEEDS]     10 by default
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "watersky/evaluation/evaluation.hpp"

using namespace watersky;

namespace {

void print_figure(const std::string& name, double value, const char* unit) {
  std::printf("{\"name\":\"%s\", \"value\":%.6g, \"unit\":\"%s\"}\n", name.c_str(), value, unit);
  std::fflush(stdout);
}

bool run(const char* preset, int seeds) {
  double worst_iou = 1.0, mean_iou = 0.0;
  std::size_t objects = 0, matched = 0, false_objects = 0;
  std::vector<double> errors_m;
  for (int seed = 1; seed <= seeds; ++seed) {
    auto scenario = sim::scenario_preset(preset);
    if (!scenario) return std::fprintf(stderr, "%s\n", scenario.error().message.c_str()), false;
    scenario->seed = seed;
    const auto simulation = sim::simulate(*scenario);
    if (!simulation) return std::fprintf(stderr, "%s\n", simulation.error().message.c_str()), false;
    MappingOptions options;
    options.parameters.map.cell_m = 0.5;
    options.parameters.mosaic = false;
    options.threads = 2;
    const auto map = map_flight(simulation->flight, options);
    if (!map) return std::fprintf(stderr, "%s\n", map.error().message.c_str()), false;
    const auto result = evaluate(*map, simulation->truth);
    if (!result) return std::fprintf(stderr, "%s\n", result.error().message.c_str()), false;
    std::fprintf(
        stderr,
        "%s seed %d: IoU %.4f, %zu of %zu objects, %zu false, centroid p95 %.3f m, %zu frames\n",
        preset, seed, result->raster.iou, result->matched_objects, result->true_objects,
        result->false_objects, result->centroid_error_m(0.95), map->used.size());
    worst_iou = std::min(worst_iou, result->raster.iou);
    mean_iou += result->raster.iou / seeds;
    objects += result->true_objects;
    matched += result->matched_objects;
    false_objects += result->false_objects;
    errors_m.insert(errors_m.end(), result->centroid_errors_m.begin(),
                    result->centroid_errors_m.end());
  }
  std::sort(errors_m.begin(), errors_m.end());
  Evaluation all;
  all.centroid_errors_m = std::move(errors_m);
  const std::string name = std::string("simulated.") + preset;
  print_figure(name + ".worst_iou", worst_iou, "1");
  print_figure(name + ".mean_iou", mean_iou, "1");
  print_figure(name + ".isolated_objects", static_cast<double>(objects), "1");
  print_figure(name + ".matched_share",
               objects == 0 ? 0.0 : static_cast<double>(matched) / static_cast<double>(objects),
               "1");
  print_figure(name + ".false_objects", static_cast<double>(false_objects), "1");
  print_figure(name + ".centroid_p95_m", all.centroid_error_m(0.95), "m");
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 10;
  if (seeds < 1) {
    std::fprintf(stderr, "simulated_accuracy: SEEDS must be a number from 1, is %s\n", argv[1]);
    return 2;
  }
  for (const char* preset : {"not_easy", "not_easy_oblique", "far"})
    if (!run(preset, seeds)) return 1;
  return 0;
}
