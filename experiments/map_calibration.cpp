// SPDX-License-Identifier: MIT
/// Do a map's probabilities mean what they say, and how well does it lie, on simulated flights with
/// realistic navigation: GNSS 1 m over 60 s, attitude 0.7° over 10 s, delay and mount unknown; ours
/// beside the thesis's Algorithm 1.
///
///   map_calibration [--seeds N] [--frame-rate HZ] [--legs N]
///
/// Each of N seeds (10) is a sea and a flight over it, in 4 legs with images at 5 Hz. Figures are
/// printed one JSON object a line, a table on standard error.
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "algorithm1_map.hpp"
#include "options.hpp"
#include "preparations.hpp"
#include "recording.hpp"
#include "statistics.hpp"
#include "support/print_figure.hpp"
#include "support/tell.hpp"
#include "watersky/evaluation/evaluation.hpp"

namespace watersky::study {

namespace {

constexpr double kCell_m = 0.5;

struct Options {
  int seeds = 10;
  double frame_rate_hz = 5.0;
  int legs = 4;
};

/// Of one flight. Algorithm 1 knows no softening: both are the same.
struct Trial {
  Calibration located, evidence;
  double iou = 0.0;
};

struct Contender {
  std::string name, title;
  std::vector<Trial> trials;
};

Result<Trial> map_and_judge(const Flight& flight, const sim::Truth& truth) {
  MappingOptions options;
  options.parameters.map.cell_m = kCell_m;
  options.parameters.mosaic = false;
  options.threads = 2;
  WATERSKY_TRY(const MapRun run, map_flight(flight, options));
  WATERSKY_TRY(const Evaluation result, evaluate(run, truth));
  return Trial{result.located, result.evidence, result.raster.iou};
}

/// Algorithm 1's map of one recording, under poses that differ.
class ThesisMapper {
 public:
  [[nodiscard]] static Result<ThesisMapper> make(const sim::Simulation& recording) {
    ThesisMapper mapper;
    mapper.frames_ = every(recording.flight, 1);
    WATERSKY_TRY(mapper.masks_, segmented(mapper.frames_));
    WATERSKY_TRY(mapper.canvas_, canvas_over(recording, kCell_m));
    mapper.ice_share_ = true_share(recording.truth, mapper.canvas_);
    return mapper;
  }

  [[nodiscard]] Result<Trial> map_and_judge(const Flight& flight) const {
    WATERSKY_TRY(const cv::Mat probability, algorithm1_map(flight, frames_, masks_, canvas_));
    const Calibration found = calibration(probability, ice_share_, kCell_m);
    return Trial{found, found, ice::compare(probability, ice_share_).iou};
  }

 private:
  std::vector<const ImageFrame*> frames_;
  std::vector<cv::Mat> masks_;
  Canvas canvas_;
  cv::Mat ice_share_;
};

void print_figures(const std::vector<Contender>& all) {
  const auto located = [](const Trial& t) { return t.located.all.calibration_error(); };
  const auto located_near = [](const Trial& t) { return t.located.near_edges.calibration_error(); };
  const auto evidence = [](const Trial& t) { return t.evidence.all.calibration_error(); };
  const auto evidence_near = [](const Trial& t) {
    return t.evidence.near_edges.calibration_error();
  };
  const auto iou = [](const Trial& t) { return t.iou; };
  tell("\n%-36s %-22s %-18s %s\n", "expected calibration error", "of all cells",
       "within 3 m of edges", "IoU");
  tell("%-36s %-22s %-18s %s\n", "", "median   worst", "median   worst", "median   worst");
  for (const Contender& contender : all) {
    const std::vector<Trial>& t = contender.trials;
    if (t.empty()) continue;
    tell("%-36s %6.3f  %6.3f         %6.3f  %6.3f     %6.3f  %6.3f\n", contender.title.c_str(),
         median(each(t, located)), largest(each(t, located)), median(each(t, located_near)),
         largest(each(t, located_near)), median(each(t, iou)), smallest(each(t, iou)));
    const std::string name = "map_calibration." + contender.name;
    print_figure(name + ".ece_worst", largest(each(t, located)));
    print_figure(name + ".ece_mean", mean(each(t, located)));
    print_figure(name + ".ece_near_edges_worst", largest(each(t, located_near)));
    print_figure(name + ".ece_near_edges_mean", mean(each(t, located_near)));
    print_figure(name + ".ece_unsoftened_worst", largest(each(t, evidence)));
    print_figure(name + ".ece_unsoftened_near_edges_worst", largest(each(t, evidence_near)));
    print_figure(name + ".iou_mean", mean(each(t, iou)));
  }
}

Status run(const Options& options) {
  std::vector<Contender> all = {
      {"algorithm1", "Algorithm 1, latest pose", {}},
      {"algorithm1_oracle", "Algorithm 1, true times and mount", {}},
      {"constant_250ms", "our map, 250 ms", {}},
      {"true_times_and_mount", "our map, true times and mount", {}},
      {"ours", "ours: our map, aligned by the images", {}},
  };
  for (int seed = 1; seed <= options.seeds; ++seed) {
    WATERSKY_TRY(sim::Scenario scenario, sim::scenario_preset("outdoor"));
    scenario.seed = scenario.sea.sea_seed = seed;
    scenario.camera.frame_rate_hz = options.frame_rate_hz;
    scenario.aircraft.legs = options.legs;
    WATERSKY_TRY(const sim::Simulation recording, record(scenario));
    WATERSKY_CHECK(render(recording.flight));
    const Flight& flight = recording.flight;
    const sim::Truth& truth = recording.truth;
    tell("seed %d: %zu frames\n", seed, flight.frames.size());
    WATERSKY_TRY(const ThesisMapper thesis, ThesisMapper::make(recording));
    WATERSKY_TRY(const Flight latest, with_latest_pose(flight));
    WATERSKY_TRY(const Flight constant, with_constant_delay(flight, 0.25));
    WATERSKY_TRY(const Flight exact, with_true_times_and_mount(flight, truth));
    WATERSKY_TRY(const Flight ours, with_alignment(flight));
    const Result<Trial> trials[] = {thesis.map_and_judge(latest), thesis.map_and_judge(exact),
                                    map_and_judge(constant, truth), map_and_judge(exact, truth),
                                    map_and_judge(ours, truth)};
    for (std::size_t i = 0; i < all.size(); ++i) {
      WATERSKY_TRY(const Trial trial, trials[i]);
      tell("  %-36s IoU %.3f, ECE %.3f (near edges %.3f); unsoftened %.3f (near edges %.3f)\n",
           all[i].title.c_str(), trial.iou, trial.located.all.calibration_error(),
           trial.located.near_edges.calibration_error(), trial.evidence.all.calibration_error(),
           trial.evidence.near_edges.calibration_error());
      all[i].trials.push_back(trial);
    }
  }
  print_figures(all);
  return {};
}

}  // namespace

}  // namespace watersky::study

int main(int argc, char** argv) {
  using namespace watersky;
  study::Options options;
  if (const auto status =
          study::read_options(argc, argv, "map_calibration",
                              {{"--seeds", "N", &options.seeds},
                               {"--frame-rate", "HZ", &options.frame_rate_hz, 0.001},
                               {"--legs", "N", &options.legs}}))
    return *status;
  cv::setNumThreads(1);
  return study::exit_status("map_calibration", study::run(options));
}
