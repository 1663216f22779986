// SPDX-License-Identifier: MIT
/// What the smoothing posterior wins over the raw map, and what it costs.
///
///   smoothing [--seeds N]     3 by default
///
/// Flights over the sea that is not easy, and over one whose noise is 1.5 times the contrast
/// (figures `noisy`), with frames dropped until a cell was seen about 1, 2 or 4 times; segmented by
/// the default method, which smooths by itself, and by Otsu's (figures `otsu`). Each seed is
/// another sea. Then the parts: belief propagation and mean field against enumeration, the cut
/// against Boost's.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "contenders.hpp"
#include "support/print_figure.hpp"
#include "support/small_fields.hpp"
#include "watersky/evaluation/evaluation.hpp"
#include "watersky/evaluation/segmentation_score.hpp"
#include "watersky/field/marginals.hpp"
#include "watersky/field/most_likely.hpp"
#include "watersky/field/smoothing.hpp"

namespace watersky::study {

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// Names of figures in the order of their making, and their mean over the seeds.
class Means {
 public:
  void add(const std::string& name, double value) {
    if (!values_.contains(name)) order_.push_back(name);
    values_[name].push_back(value);
  }
  void print(const std::string& prefix) const {
    for (const std::string& name : order_) {
      const std::vector<double>& v = values_.at(name);
      const double mean = std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
      print_figure(prefix + "." + name, mean, name.ends_with("seconds") ? "s" : "1");
    }
  }

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::vector<double>> values_;
};

double seconds_of(const auto& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double calibration_error(const cv::Mat& p_ice, const cv::Mat& truth_share) {
  Reliability reliability;
  for (int r = 0; r < p_ice.rows; ++r)
    for (int c = 0; c < p_ice.cols; ++c) {
      const float p = p_ice.at<float>(r, c), share = truth_share.at<float>(r, c);
      if (!std::isnan(p) && !std::isnan(share))
        reliability.add(static_cast<double>(p), share >= 0.5F);
    }
  return reliability.calibration_error();
}

/// As a probability raster, which is what accuracy is asked of.
cv::Mat certain(const cv::Mat& labels) {
  cv::Mat out;
  labels.convertTo(out, CV_32F);
  out.setTo(kUnknown, labels == field::kUnseen);
  return out;
}

/// An even share of the frames.
Flight thinned(const Flight& flight, double share) {
  Flight out = flight;
  out.frames.clear();
  for (std::size_t i = 0; i < flight.frames.size(); ++i)
    if (std::floor(share * static_cast<double>(i + 1)) > std::floor(share * static_cast<double>(i)))
      out.frames.push_back(flight.frames[i]);
  return out;
}

Result<cv::Mat> truth_share(const MapRun& run, const sim::Truth& truth, const CellBox& box) {
  Status projected;
  const Eigen::Vector2d corner(box.first_column, box.first_row);
  cv::Mat share = sim::ice_fraction(truth.sea, cv::Size(box.columns, box.rows),
                                    [&](const Eigen::Vector2d& north_east_m) -> Eigen::Vector2d {
                                      const Geodetic place = truth.sea.geodetic(north_east_m);
                                      const auto en = run.reference.projection.forward(
                                          place.latitude, place.longitude);
                                      if (!en) {
                                        projected = en.error();
                                        return Eigen::Vector2d::Zero();
                                      }
                                      return (run.reference.grid(*en) - corner).array() + 0.5;
                                    });
  WATERSKY_CHECK(projected);
  return share;
}

Status judge(const MapRun& run, const sim::Truth& truth, int looks, Means& means) {
  const CellBox box = run.map.seen();
  WATERSKY_TRY(const cv::Mat share, truth_share(run, truth, box));
  const cv::Mat raw = run.map.probability(box), count = run.map.looks(box);
  cv::Mat log_odds = run.map.log_odds(box);
  log_odds.setTo(kUnknown, count == 0);
  field::Smoothed smoothed;
  Status done;
  const double seconds = seconds_of([&] {
    auto result = field::smooth(log_odds);
    if (result)
      smoothed = std::move(*result);
    else
      done = result.error();
  });
  WATERSKY_CHECK(done);
  const double best = smoothed.best_foretelling.value_or(0.0);
  WATERSKY_TRY(const field::Smoothed strong, field::smooth(log_odds, {.coupling = best}));
  const cv::Mat weak_mean = mean_field(log_odds, smoothed.coupling),
                strong_mean = mean_field(log_odds, best);

  const auto iou = [&](const cv::Mat& p) { return ice::compare(p, share).iou; };
  const double raw_iou = iou(raw), likely_iou = iou(certain(smoothed.most_likely)),
               marginal_iou = iou(smoothed.probability);
  const double seen = cv::countNonZero(count);
  means.add("looks_mean", cv::sum(count)[0] / seen);
  means.add("looks_as_named_share", cv::countNonZero(count == looks) / seen);
  means.add("iou_raw", raw_iou);
  means.add("iou_most_likely", likely_iou);
  means.add("iou_marginal", marginal_iou);
  means.add("gain", likely_iou - raw_iou);
  means.add("gain_marginal", marginal_iou - raw_iou);
  means.add("ece_raw", calibration_error(raw, share));
  means.add("ece_smoothed", calibration_error(smoothed.probability, share));
  means.add("gain_mean_field", iou(weak_mean) - raw_iou);
  means.add("ece_mean_field", calibration_error(weak_mean, share));
  means.add("coupling", smoothed.coupling);
  means.add("best_foretelling", best);
  means.add("best_foretelling_gain", iou(certain(strong.most_likely)) - raw_iou);
  means.add("best_foretelling_gain_marginal", iou(strong.probability) - raw_iou);
  means.add("best_foretelling_ece", calibration_error(strong.probability, share));
  means.add("best_foretelling_gain_mean_field", iou(strong_mean) - raw_iou);
  means.add("best_foretelling_ece_mean_field", calibration_error(strong_mean, share));
  means.add("seconds", seconds);
  return {};
}

Status flights(bool noisy, int seeds) {
  struct Thinning {
    int looks;
    double frames_share;  // of a flight whose cells are seen some five times
  };
  constexpr Thinning kThinnings[] = {{1, 0.125}, {2, 0.36}, {4, 0.78}};
  std::map<std::string, Means> all;
  for (int seed = 1; seed <= seeds; ++seed) {
    WATERSKY_TRY(sim::Scenario scenario, sim::scenario_preset("not_easy"));
    scenario.seed = scenario.sea.sea_seed = seed;
    if (noisy) scenario.sensor.noise_counts = 1.5 * scenario.sensor.contrast_counts;
    WATERSKY_TRY(const sim::Simulation simulation, sim::simulate(scenario));
    for (const SegmentationMethod method : {kDefaultSegmentationMethod, SegmentationMethod::Otsu})
      for (const Thinning& thinning : kThinnings) {
        MappingOptions options;
        options.parameters.map.cell_m = 0.5;
        options.parameters.mosaic = false;
        options.method = method;
        options.threads = 2;
        WATERSKY_TRY(const MapRun run,
                     map_flight(thinned(simulation.flight, thinning.frames_share), options));
        const std::string name = std::string("smoothing.") + (noisy ? "noisy." : "") +
                                 (method == SegmentationMethod::Otsu ? "otsu." : "") + "looks_" +
                                 std::to_string(thinning.looks);
        WATERSKY_CHECK(judge(run, simulation.truth, thinning.looks, all[name]));
        std::fprintf(stderr, "%s seed %d\n", name.c_str(), seed);
      }
  }
  for (const auto& [name, means] : all) means.print(name);
  return {};
}

/// Mean error of P(ice) against all 2^16 maps of 4 x 4 cells, evidence normal with sigma 1.
Status small_grids() {
  constexpr int kTrials = 40;
  for (const double coupling : {0.1, 0.2, 0.4, 0.8}) {
    std::mt19937 random(1);
    double beliefs = 0.0, mean = 0.0, raw = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const cv::Mat l = test::random_field(4, 4, 1.0, 0.0, random);
      const std::vector<double> exact = test::enumerate(l, coupling).p_ice;
      WATERSKY_TRY(const field::Marginals found, field::marginals(l, coupling, 1000, 1e-6));
      WATERSKY_TRY(const field::Marginals alone, field::marginals(l, 0.0));
      const cv::Mat other = mean_field(l, coupling);
      for (int i = 0; i < 16; ++i) {
        const auto error = [&](const cv::Mat& p) {
          return std::abs(static_cast<double>(p.at<float>(i / 4, i % 4)) -
                          exact[static_cast<std::size_t>(i)]) /
                 (16.0 * kTrials);
        };
        beliefs += error(found.probability);
        mean += error(other);
        raw += error(alone.probability);
      }
    }
    char name[64];
    std::snprintf(name, sizeof name, "smoothing.small.coupling_%g", coupling);
    print_figure(std::string(name) + ".belief_error", beliefs);
    print_figure(std::string(name) + ".mean_field_error", mean);
    print_figure(std::string(name) + ".raw_error", raw);
  }
  return {};
}

/// A wavy sea of floes with evidence that is `scale` strong and wrong in a fifth of the cells.
cv::Mat wavy_field(int side, float scale) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  cv::Mat l(side, side, CV_32F);
  for (int r = 0; r < side; ++r)
    for (int c = 0; c < side; ++c) {
      const bool ice =
          std::sin(0.05 * r) + std::cos(0.07 * c) + 0.5 * std::sin(0.3 * r + 0.2 * c) > 0.0;
      l.at<float>(r, c) = scale * ((ice ? 1.0F : -1.0F) + 1.2F * normal(random));
    }
  return l;
}

Status speed() {
  for (const int side : {1000, 2000})
    for (const double coupling : {0.15, 0.6}) {
      const cv::Mat l = wavy_field(side, 0.5F);
      char name[64];
      std::snprintf(name, sizeof name, "smoothing.speed.side_%d.coupling_%g", side, coupling);
      cv::Mat labels;
      print_figure(std::string(name) + ".cut_seconds",
                   seconds_of([&] { labels = field::most_likely(l, coupling).value_or({}); }), "s");
      int iterations = 0;
      print_figure(std::string(name) + ".beliefs_seconds", seconds_of([&] {
                     const auto found = field::marginals(l, coupling);
                     iterations = found ? found->iterations : 0;
                   }),
                   "s");
      print_figure(std::string(name) + ".iterations", iterations);
      if (side > 1000) continue;
      BoostCut boost;
      print_figure(std::string(name) + ".boost_seconds",
                   seconds_of([&] { boost = boost_cut(l, coupling); }), "s");
      print_figure(std::string(name) + ".boost_bytes_a_cell",
                   static_cast<double>(boost.bytes) / static_cast<double>(l.total()), "B");
      print_figure(std::string(name) + ".energy_over_boost",
                   field::energy(l, labels, coupling) - field::energy(l, boost.labels, coupling));
    }
  return {};
}

Status run(int seeds) {
  WATERSKY_CHECK(flights(false, seeds));
  WATERSKY_CHECK(flights(true, seeds));
  WATERSKY_CHECK(small_grids());
  return speed();
}

}  // namespace

}  // namespace watersky::study

int main(int argc, char** argv) {
  int seeds = 3;
  if (argc == 3 && std::string_view(argv[1]) == "--seeds") seeds = std::atoi(argv[2]);
  if (seeds < 1 || (argc != 1 && argc != 3)) {
    std::fprintf(stderr, "smoothing: call it as smoothing [--seeds N], N from 1\n");
    return 2;
  }
  if (const watersky::Status done = watersky::study::run(seeds); !done) {
    std::fprintf(stderr, "%s\n", done.error().message.c_str());
    return 1;
  }
  return 0;
}
