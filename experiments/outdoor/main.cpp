// SPDX-License-Identifier: MIT
/// An X8 at 100 m over ice whose delay, mount and navigation error nobody knows: how far points of
/// the sea are put from where they are.
///
/// One point of the sea has a place known to 0.1 m and is marked in five frames: only the contender
/// "ours, one anchor" uses it.
///
///   outdoor [--seeds N] [--out FOLDER] [--frame-rate HZ]
///
/// Each of N seeds (10) is a sea, a flight of two minutes in overlapping legs, a mount and the
/// navigation's errors. FOLDER (outdoor_study) gets table.txt, seeds.csv and errors.png, the errors
/// of the first seed. Figures are printed one JSON object a line, the table on standard error as
/// well.
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/core/utility.hpp>

#include "options.hpp"
#include "recording.hpp"
#include "statistics.hpp"
#include "study.hpp"
#include "support/print_figure.hpp"
#include "support/tell.hpp"
#include "watersky/io/files.hpp"

namespace fs = std::filesystem;

namespace watersky::study {

namespace {

struct Options {
  fs::path out = "outdoor_study";
  int seeds = 10;
  double frame_rate_hz = 5.0;
};

struct Trial {
  Accuracy level, with_turns;
  double floor_m = 0.0;
  /// The best that can be asked of the absolute error: the mean of the navigation's error is in no
  /// image, and neither is what the floor leaves.
  double unavoidable_m = 0.0;
  double left_out_share = 0.0;
};

void print_figures(const std::vector<Contender>& all,
                   const std::map<std::string, std::vector<Trial>>& trials) {
  tell("\nover all seeds, m: median, worst\n%-24s %-15s %-15s %-15s %-15s %s\n", "", "absolute",
       "less its mean", "sharpness", "true at a point", "sharpness with turns");
  for (const Contender& contender : all) {
    const std::vector<Trial>& t = trials.at(contender.name);
    const struct {
      const char* name;
      std::vector<double> values;
    } figures[] = {
        {"absolute", each(t, [](const Trial& x) { return x.level.absolute_m; })},
        {"shape", each(t, [](const Trial& x) { return x.level.shape_m; })},
        {"sharpness", each(t, [](const Trial& x) { return x.level.sharpness_m; })},
        {"anchored", each(t, [](const Trial& x) { return x.level.anchored_m; })},
        {"sharpness_with_turns", each(t, [](const Trial& x) { return x.with_turns.sharpness_m; })}};
    tell("%-24s", contender.title.c_str());
    for (const auto& figure : figures) {
      const double worst = largest(figure.values);
      tell(" %6.2f %6.2f  ", median(figure.values), worst);
      const std::string name = "outdoor." + contender.name + "." + figure.name;
      print_figure(name + "_median_m", median(figure.values), "m");
      print_figure(name + "_worst_m", worst, "m");
    }
    tell("\n");
    const std::vector<double> ratios =
        each(t, [](const Trial& x) { return x.level.absolute_m / x.unavoidable_m; });
    print_figure("outdoor." + contender.name + ".absolute_ratio_unavoidable_worst",
                 largest(ratios));
    const std::vector<double> lost = each(t, [](const Trial& x) { return x.left_out_share; });
    print_figure("outdoor." + contender.name + ".left_out_share_worst", largest(lost));
  }
  const std::vector<Trial>& any = trials.begin()->second;
  const std::vector<double> floors = each(any, [](const Trial& x) { return x.floor_m; });
  const std::vector<double> best = each(any, [](const Trial& x) { return x.unavoidable_m; });
  tell(
      "floor, less its mean: median %.2f, worst %.2f; unavoidable absolute: median %.2f, worst "
      "%.2f\n",
      median(floors), largest(floors), median(best), largest(best));
  print_figure("outdoor.floor.shape_median_m", median(floors), "m");
  print_figure("outdoor.floor.shape_worst_m", largest(floors), "m");
  print_figure("outdoor.floor.absolute_median_m", median(best), "m");
}

Status run(const Options& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error)
    return Error{ErrorCode::Io, options.out.string() + ": cannot be made: " + error.message()};
  std::map<std::string, std::vector<Trial>> trials;
  std::vector<Contender> all;
  std::vector<ErrorCloud> clouds;
  std::string csv =
      "seed,contender,absolute_m,shape_m,sharpness_m,anchored_m,sharpness_with_turns_m,floor_m,"
      "unavoidable_m\n";
  for (int seed = 1; seed <= options.seeds; ++seed) {
    WATERSKY_TRY(sim::Scenario scenario, sim::scenario_preset("outdoor"));
    scenario.seed = scenario.sea.sea_seed = seed;
    scenario.camera.frame_rate_hz = options.frame_rate_hz;
    scenario.known_points.anchor = true;
    scenario.known_points.anchor_north_m = 100.0;  // towards a corner of the survey
    scenario.known_points.anchor_east_m = 30.0;
    WATERSKY_TRY(const sim::Simulation simulation, record(scenario));
    WATERSKY_CHECK(render(simulation.flight));
    const double mean_error_m = simulation.truth.mean_navigation_error_m().head<2>().norm();
    all = contenders(simulation.truth);
    tell("seed %d: %zu frames, mean navigation error %.2f m\n", seed,
         simulation.flight.frames.size(), mean_error_m);
    for (const Contender& contender : all) {
      WATERSKY_TRY(const Flight prepared, contender.prepare(simulation.flight));
      const Looks level = look_at_points(prepared, simulation, false);
      Trial trial{judge(level), judge(look_at_points(prepared, simulation, true))};
      trial.floor_m = floor_m(level, simulation.truth);
      trial.unavoidable_m = std::hypot(mean_error_m, trial.floor_m);
      trial.left_out_share =
          static_cast<double>(level.frames_left_out) / static_cast<double>(level.frames);
      tell(
          "  %-24s absolute %6.2f, less its mean %6.2f (floor %.2f), sharpness %6.2f, true at a "
          "point %6.2f m, %zu looks\n",
          contender.title.c_str(), trial.level.absolute_m, trial.level.shape_m, trial.floor_m,
          trial.level.sharpness_m, trial.level.anchored_m, level.looks.size());
      char line[256];
      std::snprintf(line, sizeof line, "%d,%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n", seed,
                    contender.name.c_str(), trial.level.absolute_m, trial.level.shape_m,
                    trial.level.sharpness_m, trial.level.anchored_m, trial.with_turns.sharpness_m,
                    trial.floor_m, trial.unavoidable_m);
      csv += line;
      trials[contender.name].push_back(trial);
      if (seed == 1) clouds.push_back({contender.title, level});
    }
  }
  print_figures(all, trials);
  WATERSKY_CHECK(write_error_clouds(options.out / "errors.png", clouds));
  WATERSKY_CHECK(write_file(options.out / "seeds.csv", csv));
  return write_file(options.out / "table.txt", told());
}

}  // namespace

}  // namespace watersky::study

int main(int argc, char** argv) {
  using namespace watersky;
  study::Options options;
  if (const auto status =
          study::read_options(argc, argv, "outdoor",
                              {{"--seeds", "N", &options.seeds},
                               {"--out", "FOLDER", &options.out},
                               {"--frame-rate", "HZ", &options.frame_rate_hz, 0.001}}))
    return *status;
  cv::setNumThreads(1);
  return study::exit_status("outdoor", study::run(options));
}
