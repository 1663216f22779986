// SPDX-License-Identifier: MIT
/// The thesis's laboratory (4.1.1) with truth: eight paper patches under a hovering drone whose
/// images arrive late and whose mount is not what it is said to be.
///
///   occupancy_grid [--seeds N] [--out FOLDER] [--step K] [--sweep-seeds N]
///
/// Each of N seeds (10) is a flight of a minute at 30 Hz, of which every Kth frame (3) is mapped,
/// by every contender the same. FOLDER (occupancy_grid_study) gets table.txt, patches.csv with the
/// error that the thesis did not quantify, Figures 4.2 to 4.5, and the sweep of delay, jitter and
/// mount error (over 2 seeds; 0: none). Figures are printed one JSON object a line, tables on
/// standard error as well.
#include <algorithm>
#include <cstdio>
#include <map>
#include <opencv2/core/utility.hpp>

#include "ground_error.hpp"
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
  fs::path out = "occupancy_grid_study";
  int seeds = 10;
  int step = 3;
  int sweep_seeds = 2;
};

struct Trial {
  Score score;
  double ground_rms_m = 0.0;
};
/// By contender, one trial a seed.
using Trials = std::map<std::string, std::vector<Trial>>;

void print_figures(const std::vector<Contender>& all, const Trials& trials) {
  const auto rms_mm = [](const Trial& t) { return 1e3 * t.score.patch_rms_m(); };
  const auto iou = [](const Trial& t) { return t.score.iou; };
  const auto found = [](const Trial& t) { return static_cast<double>(t.score.found()); };
  const auto spurious = [](const Trial& t) { return static_cast<double>(t.score.spurious); };
  const auto ground_mm = [](const Trial& t) { return 1e3 * t.ground_rms_m; };
  const std::vector<Trial>& oracle = trials.at("oracle");
  tell("\n%-36s %-13s %-19s %-15s %-9s %s\n", "over all seeds", "found of 8", "patch RMS, mm",
       "IoU", "spurious", "ground RMS, mm");
  tell("%-36s %-13s %-19s %-15s %-9s %s\n", "", "median worst", "median    worst", "median  worst",
       "worst", "median");
  for (const Contender& contender : all) {
    const std::vector<Trial>& t = trials.at(contender.name);
    tell("%-36s %6.1f %6.0f %9.2f %9.2f %7.3f %7.3f %9.0f %9.2f\n", contender.title.c_str(),
         median(each(t, found)), smallest(each(t, found)), median(each(t, rms_mm)),
         largest(each(t, rms_mm)), median(each(t, iou)), smallest(each(t, iou)),
         largest(each(t, spurious)), median(each(t, ground_mm)));
    const std::string name = "lab." + contender.name + ".";
    print_figure(name + "patches_found", smallest(each(t, found)));
    print_figure(name + "patches_found_median", median(each(t, found)));
    print_figure(name + "patch_rms_mm", largest(each(t, rms_mm)), "mm");
    print_figure(name + "patch_rms_median_mm", median(each(t, rms_mm)), "mm");
    print_figure(name + "iou", smallest(each(t, iou)));
    print_figure(name + "iou_median", median(each(t, iou)));
    print_figure(name + "spurious", largest(each(t, spurious)));
    print_figure(name + "ground_rms_median_mm", median(each(t, ground_mm)), "mm");
    double ratio = 0.0, below = -1.0;
    for (std::size_t i = 0; i < t.size(); ++i) {
      // A NaN stays: no patch found is no ratio.
      const double r = rms_mm(t[i]) / rms_mm(oracle[i]);
      ratio = std::isnan(r) || r > ratio ? r : ratio;
      below = std::max(below, oracle[i].score.iou - t[i].score.iou);
    }
    print_figure(name + "patch_rms_ratio_oracle", ratio);
    print_figure(name + "iou_below_oracle", below);
  }
}

Status print_patches(const std::vector<Contender>& all, const Trials& trials,
                     const fs::path& file) {
  std::string csv = "contender,seed,patch,found,error_x_mm,error_y_mm,error_mm,area_ratio\n";
  tell("\nerror of each patch, mm: root mean square over the seeds that found it (how many)\n%-36s",
       "");
  for (int patch = 1; patch <= 8; ++patch) tell("%12d", patch);
  for (const Contender& contender : all) {
    tell("\n%-36s", contender.title.c_str());
    for (std::size_t patch = 0; patch < 8; ++patch) {
      double sum = 0.0;
      int found = 0, seed = 0;
      for (const Trial& trial : trials.at(contender.name)) {
        const PatchFinding& p = trial.score.patches[patch];
        ++seed;
        char line[200];
        std::snprintf(line, sizeof line, "%s,%d,%d,%d", contender.name.c_str(), seed, p.number,
                      p.found ? 1 : 0);
        csv += line;
        if (p.found) {
          std::snprintf(line, sizeof line, ",%.3f,%.3f,%.3f,%.3f", 1e3 * p.error_m.x(),
                        1e3 * p.error_m.y(), 1e3 * p.error_m.norm(), p.area_ratio);
          csv += line;
          sum += p.error_m.squaredNorm();
          ++found;
        } else {
          csv += ",,,,";
        }
        csv += "\n";
      }
      if (found > 0) {
        tell(" %6.2f (%2d)", 1e3 * std::sqrt(sum / found), found);
      } else {
        tell(" %6s (%2d)", "-", 0);
      }
    }
  }
  tell("\n");
  return write_file(file, csv);
}

Status run(const Options& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error)
    return Error{ErrorCode::Io, options.out.string() + ": cannot be made: " + error.message()};
  constexpr std::size_t kDrawn = 3;  // as many datasets as the thesis has
  Trials trials;
  std::vector<Contender> all;
  std::vector<sim::Simulation> kept;
  kept.reserve(kDrawn);
  std::vector<DrawnFlight> flights;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    WATERSKY_TRY(sim::Simulation made, record(laboratory(seed)));
    const bool is_drawn = kept.size() < kDrawn;
    if (is_drawn) kept.push_back(std::move(made));
    const sim::Simulation& recording = is_drawn ? kept.back() : made;
    const std::vector<const ImageFrame*> frames = every(recording.flight, options.step);
    WATERSKY_CHECK(render(frames));
    all = contenders(recording.truth);
    DrawnFlight flight{&recording, frames, {}, {}};
    tell("seed %d: %zu frames, %zu of them mapped\n", seed, recording.flight.frames.size(),
         frames.size());
    for (const Contender& contender : all) {
      WATERSKY_TRY(const Flight prepared, contender.prepare(recording.flight));
      WATERSKY_TRY(const RoomMap map, make_map(prepared, contender.mapper, frames));
      const Trial trial{judge(map, recording.truth.sea, recording.flight.datum),
                        judge(ground_errors(prepared, recording, options.step)).absolute_m};
      tell("  %-36s found %d of 8, RMS %8.2f mm, IoU %.3f, %2d spurious, ground %7.2f mm\n",
           contender.title.c_str(), trial.score.found(), 1e3 * trial.score.patch_rms_m(),
           trial.score.iou, trial.score.spurious, 1e3 * trial.ground_rms_m);
      trials[contender.name].push_back(trial);
      if (contender.name == "algorithm1") flight.algorithm1 = map;
      if (contender.name == drawn(all).name) flight.ours = map;
    }
    if (is_drawn) flights.push_back(std::move(flight));
    // Of the others only path and maps are drawn: their pictures need not stay in memory.
    if (kept.size() > 1)
      for (ImageFrame& frame : kept.back().flight.frames) frame.load = {};
  }
  print_figures(all, trials);
  WATERSKY_CHECK(print_patches(all, trials, options.out / "patches.csv"));

  const std::vector<Contender> first = contenders(flights.front().recording->truth);
  const Contender &algorithm1 = first.front(), &ours = drawn(first);
  WATERSKY_CHECK(write_figure_4_2(options.out / "figure_4_2.png", flights.front()));
  WATERSKY_CHECK(
      write_figure_4_3(options.out / "figure_4_3.png", flights.front(), algorithm1, ours));
  WATERSKY_CHECK(
      write_figure_4_4(options.out / "figure_4_4.png", flights.front(), algorithm1, ours));
  WATERSKY_CHECK(write_figure_4_5(options.out / "figure_4_5.png", flights, ours.title));
  WATERSKY_CHECK(write_file(options.out / "table.txt", told()));
  if (options.sweep_seeds > 0)
    WATERSKY_CHECK(sweep(options.sweep_seeds, options.step, options.out));
  return {};
}

}  // namespace

}  // namespace watersky::study

int main(int argc, char** argv) {
  using namespace watersky;
  study::Options options;
  if (const auto status = study::read_options(argc, argv, "occupancy_grid",
                                              {{"--seeds", "N", &options.seeds},
                                               {"--out", "FOLDER", &options.out},
                                               {"--step", "K", &options.step},
                                               {"--sweep-seeds", "N", &options.sweep_seeds, 0.0}}))
    return *status;
  cv::setNumThreads(1);
  return study::exit_status("occupancy_grid", study::run(options));
}
