// SPDX-License-Identifier: MIT
/// Does aligning by the images ever do harm? Where they tell little, the ground must not come out
/// worse than without a correction or with a constant delay.
///
///   never_worse [--seeds N] [--case NAME] [--duration S] [--pixels SHARE] [--out FOLDER]
///
/// N seeds (10) of each case (all; never_worse/cases.cpp), flights of S seconds (20) at a SHARE
/// (0.5) of the presets' pixels along each side. Each frame's pixels are put on the sea as given
/// (the latest pose at arrival), with a constant delay, and aligned by the images, untold and told
/// that delay; the root mean square of how far off they are is taken whole, and less the flight's
/// mean error, in which what no image can see is. A ratio is ours over the better of the two. The
/// constant delay is 250 ms, what somebody would have guessed; a harder judge knows the true mean
/// (figures `known`). FOLDER (never_worse_study) gets table.txt and seeds.csv. Figures are printed
/// one JSON object a line, the table on standard error as well.
#include <algorithm>
#include <cstdio>
#include <opencv2/core/utility.hpp>

#include "cases.hpp"
#include "ground_error.hpp"
#include "options.hpp"
#include "preparations.hpp"
#include "recording.hpp"
#include "statistics.hpp"
#include "support/print_figure.hpp"
#include "support/tell.hpp"
#include "watersky/io/files.hpp"

namespace fs = std::filesystem;

namespace watersky::study {

namespace {

constexpr double kGuessedDelay_s = 0.25;

struct Options {
  fs::path out = "never_worse_study";
  std::string only;  ///< a case; empty: all
  int seeds = 10;
  double duration_s = 20.0;
  double share = 0.5;
};

/// One way to know where the frames look, on one flight.
struct Outcome {
  GroundErrors errors;
  GroundAccuracy accuracy;
  Alignment alignment{};  ///< of ours
};

/// Ours beside the better of two, of one flight.
struct Ratios {
  double absolute = 0.0, shape = 0.0;
  double known_absolute = 0.0, known_shape = 0.0;  ///< where the true mean delay is known
  double left_out_share = 0.0;
  AlignMethod method = AlignMethod::AsGiven;
};

double true_mean_delay_s(const sim::Simulation& recording) {
  double sum = 0.0;
  for (std::size_t i = 0; i < recording.truth.frames.size(); ++i)
    sum +=
        to_seconds(*recording.flight.frames[i].received_at - recording.truth.frames[i].captured_at);
  return sum / static_cast<double>(recording.truth.frames.size());
}

Result<Outcome> look(const Result<Flight>& prepared, const sim::Simulation& recording) {
  WATERSKY_TRY(const Flight flight, prepared);
  return Outcome{ground_errors(flight, recording), {}};
}

Result<Outcome> look_aligned(const Flight& flight, const sim::Simulation& recording) {
  WATERSKY_TRY(AlignedFlight ours, align_by_images(flight));
  WATERSKY_TRY(Outcome outcome, look(ours.flight, recording));
  outcome.alignment = std::move(ours.alignment);
  return outcome;
}

/// Why an alignment chose its method.
std::string remark(const Alignment& alignment) {
  std::string out = alignment.method_reason;
  for (const std::string& note : alignment.notes) out += (out.empty() ? "" : "; ") + note;
  std::replace(out.begin(), out.end(), '"', '\'');
  return out;
}

/// How the figures spell ours, and what a table calls it.
struct Ours {
  const char *name, *title;
};
constexpr Ours kOurs[] = {{"ours", "untold"}, {"ours_told", "told 250 ms"}};

/// One flight: a line in the table for each of ours, all in the CSV.
Status fly(const Case& one, int seed, std::vector<std::vector<Ratios>>& ratios, std::string& csv) {
  sim::Scenario scenario = one.scenario;
  scenario.seed = scenario.sea.sea_seed = seed;
  WATERSKY_TRY(const sim::Simulation recording, record(scenario));
  WATERSKY_CHECK(render(recording.flight));
  const Flight& flight = recording.flight;
  const double delay_s = true_mean_delay_s(recording);
  WATERSKY_TRY(const Flight told, with_constant_delay(flight, kGuessedDelay_s));
  WATERSKY_TRY(Outcome as_given, look(with_latest_pose(flight), recording));
  WATERSKY_TRY(Outcome constant, look(told, recording));
  WATERSKY_TRY(Outcome known, look(with_constant_delay(flight, delay_s), recording));
  WATERSKY_TRY(Outcome oracle, look(with_true_times_and_mount(flight, recording.truth), recording));
  WATERSKY_TRY(Outcome untold_ours, look_aligned(flight, recording));
  WATERSKY_TRY(Outcome told_ours, look_aligned(told, recording));

  Outcome* const ours[] = {&untold_ours, &told_ours};
  std::vector<double> left_out;
  for (const Outcome* o : ours)
    left_out.push_back(static_cast<double>(o->errors.frames_left_out()) /
                       static_cast<double>(o->errors.of_frame_m.size()));
  const std::vector<Outcome*> all = {&as_given, &constant, &known, &oracle, ours[0], ours[1]};
  std::vector<GroundErrors*> errors;
  for (Outcome* o : all) errors.push_back(&o->errors);
  keep_common(errors);
  for (Outcome* o : all) o->accuracy = judge(o->errors);

  const auto over_better = [&](const Outcome& o, const Outcome& delayed,
                               double GroundAccuracy::*of) {
    return o.accuracy.*of / std::min(as_given.accuracy.*of, delayed.accuracy.*of);
  };
  tell(
      "  seed %2d, %4zu frames: as given %.4g, 250 ms %.4g, %.0f ms %.4g, true times and mount "
      "%.4g m; less the mean %.4g, %.4g, %.4g, %.4g\n",
      seed, flight.frames.size(), as_given.accuracy.absolute_m, constant.accuracy.absolute_m,
      1e3 * delay_s, known.accuracy.absolute_m, oracle.accuracy.absolute_m,
      as_given.accuracy.shape_m, constant.accuracy.shape_m, known.accuracy.shape_m,
      oracle.accuracy.shape_m);
  for (std::size_t k = 0; k < std::size(kOurs); ++k) {
    const Outcome& o = *ours[k];
    const Ratios r{over_better(o, constant, &GroundAccuracy::absolute_m),
                   over_better(o, constant, &GroundAccuracy::shape_m),
                   over_better(o, known, &GroundAccuracy::absolute_m),
                   over_better(o, known, &GroundAccuracy::shape_m),
                   left_out[k],
                   o.alignment.method};
    tell("    %-12s %-15s %.4g m, ratio %.3f (%.3f); less the mean %.4g m, %.3f (%.3f)\n",
         kOurs[k].title, std::string(name_of(o.alignment.method)).c_str(), o.accuracy.absolute_m,
         r.absolute, r.known_absolute, o.accuracy.shape_m, r.shape, r.known_shape);
    char line[400];
    std::snprintf(line, sizeof line, "%s,%d,%s,%s,%.5g,%.5g,%.4f,%.4f,%.4f,%.4f,%.4f,",
                  one.name.c_str(), seed, kOurs[k].name,
                  std::string(name_of(o.alignment.method)).c_str(), o.accuracy.absolute_m,
                  o.accuracy.shape_m, r.absolute, r.shape, r.known_absolute, r.known_shape,
                  r.left_out_share);
    csv += line;
    for (const Outcome* other : {&as_given, &constant, &known, &oracle}) {
      std::snprintf(line, sizeof line, "%.5g,%.5g,", other->accuracy.absolute_m,
                    other->accuracy.shape_m);
      csv += line;
    }
    // What the choice of the method went by.
    std::snprintf(line, sizeof line, "%.5g,%.5g,%.5g,", o.alignment.as_given.median_m,
                  o.alignment.constant_delay.median_m, o.alignment.after.median_m);
    csv += line;
    csv += '"' + remark(o.alignment) + "\"\n";
    ratios[k].push_back(r);
  }
  return {};
}

/// "full 9, constant delay 1"
std::string methods(const std::vector<Ratios>& ratios) {
  std::string out;
  for (const AlignMethod method :
       {AlignMethod::Full, AlignMethod::ConstantDelay, AlignMethod::AsGiven}) {
    const auto count = std::count_if(ratios.begin(), ratios.end(),
                                     [&](const Ratios& r) { return r.method == method; });
    if (count == 0) continue;
    out += (out.empty() ? "" : ", ") + std::string(name_of(method)) + " " + std::to_string(count);
  }
  return out;
}

Status run(const Options& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error)
    return Error{ErrorCode::Io, options.out.string() + ": cannot be made: " + error.message()};
  WATERSKY_TRY(std::vector<Case> all, cases(options.duration_s, options.share));
  if (!options.only.empty())
    std::erase_if(all, [&](const Case& c) { return options.only != c.name; });
  if (all.empty()) return Error{ErrorCode::NotFound, "no case is called '" + options.only + "'"};

  std::string csv =
      "case,seed,contender,method,absolute_m,shape_m,absolute_ratio,shape_ratio,"
      "known_absolute_ratio,known_shape_ratio,left_out_share,as_given_absolute_m,as_given_shape_m,"
      "constant_absolute_m,constant_shape_m,known_absolute_m,known_shape_m,oracle_absolute_m,"
      "oracle_shape_m,ties_as_given_m,ties_constant_m,ties_after_m,remark\n";
  std::vector<std::vector<std::vector<Ratios>>> ratios;  // by case, by ours, by seed
  for (const Case& one : all) {
    tell("%s\n", one.title.c_str());
    ratios.emplace_back(std::size(kOurs));
    for (int seed = 1; seed <= options.seeds; ++seed)
      WATERSKY_CHECK(fly(one, seed, ratios.back(), csv));
  }

  const struct {
    const char* name;
    double Ratios::*value;
  } figures[] = {{"absolute", &Ratios::absolute},
                 {"shape", &Ratios::shape},
                 {"absolute_known", &Ratios::known_absolute},
                 {"shape_known", &Ratios::known_shape}};
  tell(
      "\nground error over the better of as given and a constant delay, worst of %d seeds\n"
      "%-47s %-12s %-21s %-21s %s\n%-47s %-12s %-10s %-10s %-10s %-10s\n",
      options.seeds, "", "", "250 ms", "true mean delay", "method", "", "", "absolute", "less mean",
      "absolute", "less mean");
  for (std::size_t k = 0; k < std::size(kOurs); ++k) {
    std::vector<double> overall;
    for (std::size_t c = 0; c < all.size(); ++c) {
      const std::vector<Ratios>& r = ratios[c][k];
      const std::string name = "never_worse." + all[c].name + "." + kOurs[k].name;
      tell("%-47s %-12s", all[c].title.c_str(), kOurs[k].title);
      for (const auto& figure : figures) {
        const double worst = largest(each(r, [&](const Ratios& x) { return x.*figure.value; }));
        tell(" %-10.3f", worst);
        print_figure(name + "." + figure.name + "_ratio_worst", worst);
      }
      tell(" %s\n", methods(r).c_str());
      print_figure(name + ".left_out_share_worst",
                   largest(each(r, [](const Ratios& x) { return x.left_out_share; })));
      overall.push_back(
          largest(each(r, [](const Ratios& x) { return std::max(x.absolute, x.shape); })));
    }
    print_figure(std::string("never_worse.") + kOurs[k].name + ".ratio_worst", largest(overall));
  }
  WATERSKY_CHECK(write_file(options.out / "seeds.csv", csv));
  return write_file(options.out / "table.txt", told());
}

}  // namespace

}  // namespace watersky::study

int main(int argc, char** argv) {
  using namespace watersky;
  study::Options options;
  if (const auto status = study::read_options(argc, argv, "never_worse",
                                              {{"--seeds", "N", &options.seeds},
                                               {"--case", "NAME", &options.only},
                                               {"--duration", "S", &options.duration_s},
                                               {"--pixels", "SHARE", &options.share, 0.1},
                                               {"--out", "FOLDER", &options.out}}))
    return *status;
  cv::setNumThreads(1);
  return study::exit_status("never_worse", study::run(options));
}
