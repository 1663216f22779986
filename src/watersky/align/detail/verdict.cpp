// SPDX-License-Identifier: MIT
#include "watersky/align/detail/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "watersky/align/detail/finding_text.hpp"

namespace watersky::detail {

namespace {

/// Fewer pairs say nothing of a fault of the whole flight.
constexpr std::size_t kFewestForFlight = 6;
constexpr std::size_t kFewestForTurned = 2;
/// Below so many times what noise does, a flight's poses are not asked for faults.
constexpr double kSuspicious = 1.5;

/// What a reading must do to the pairs that it concerns.
struct Standard {
  double most_left;       ///< of the disagreement, median over pairs
  double least_improved;  ///< share of the pairs that disagreed
  double most_worsened;
  double least_gain;  ///< of the cost
};
constexpr Standard kCertain{0.45, 0.8, 0.1, 10.0}, kSuspected{0.65, 0.7, 0.15, 6.0};
/// Turned images have few pairs, and are off by far.
constexpr Standard kCertainTurned{0.3, 0.8, 0.1, 4.0}, kSuspectedTurned{0.5, 0.7, 0.15, 2.5};
constexpr double kCertainAlone = 1.0, kCertainTogether = 4.0, kCertainInRun = 0.4;
/// A rival that scores so near leaves it open which of the two is right.
constexpr double kNearRival = 3.0, kSimplerFirst = 1.0;
/// Of the height above the sea: what terrain, a tide or a lens off by some percent may do.
constexpr double kLeastLogHeight = 0.18, kSigmasOfHeight = 5.0, kLeastGainOfHeight = 3.0;

/// A certain fault leaves a mount off by no more than 4°, a height by no more than 13 %.
constexpr double kMostTurnLeft = 0.075, kMostLogHeightLeft = 0.13;

struct Judgement {
  double before_m = 0.0, after_m = 0.0, gain = 0.0;
  double improved = 0.0, worsened = 0.0;
  std::size_t pairs = 0;

  [[nodiscard]] bool meets(const Standard& standard) const {
    return after_m <= standard.most_left * before_m && improved >= standard.least_improved &&
           worsened <= standard.most_worsened && gain >= standard.least_gain;
  }
};

Judgement judge(const Evidence& evidence, const Reading& recorded, const Reading& reading,
                const std::vector<bool>& concerned) {
  Judgement out;
  std::vector<double> before, after;
  std::size_t disagreed = 0, improved = 0, worsened = 0;
  const double noise_m = evidence.disagreement.noise_m();
  for (std::size_t p = 0; p < concerned.size(); ++p) {
    if (!concerned[p]) continue;
    const double was_m = recorded.fit.pair_m[p], is_m = reading.fit.pair_m[p];
    before.push_back(was_m);
    after.push_back(is_m);
    if (was_m > noise_m) {
      ++disagreed;
      if (is_m < 0.75 * was_m) ++improved;
    }
    if (is_m > noise_m && is_m > 1.33 * was_m) ++worsened;
  }
  out.pairs = before.size();
  if (out.pairs == 0) return out;
  out.improved =
      disagreed == 0 ? 0.0 : static_cast<double>(improved) / static_cast<double>(disagreed);
  out.worsened = static_cast<double>(worsened) / static_cast<double>(out.pairs);
  out.before_m = median_of(std::move(before));
  out.after_m = median_of(std::move(after));
  out.gain = recorded.fit.cost - reading.fit.cost - reading.complexity;
  return out;
}

/// Pairs in which one of `frames` (of the evidence) is; all of them for none.
std::vector<bool> pairs_with(const Evidence& evidence, const std::vector<bool>& frames) {
  std::vector<bool> out;
  for (const PairRays& pair : evidence.disagreement.pairs())
    out.push_back(frames.empty() || frames[pair.a] || frames[pair.b]);
  return out;
}

void set_figures(const Evidence& evidence, const Judgement& judgement, MetadataFinding& finding) {
  finding.before_m = judgement.before_m;
  finding.after_m = judgement.after_m;
  finding.before_share = judgement.before_m / evidence.footprint_side_m;
  finding.after_share = judgement.after_m / evidence.footprint_side_m;
  finding.pairs = judgement.pairs;
}

/// Turned images by their turn, the certain ones apart from the others.
std::vector<MetadataFinding> turned_findings(const Evidence& evidence, const Reading& recorded,
                                             const Reading& turned) {
  std::map<std::pair<bool, int>, std::vector<bool>> groups;
  const std::size_t count = turned.quarters.size();
  const auto by_itself = [&](std::size_t i) {
    return turned.quarters[i] != 0 && turned.alone[i] >= kCertainAlone &&
           turned.together[i] >= kCertainTogether;
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (turned.quarters[i] == 0) continue;
    // Whatever turns images turns a run of them: what one pair says is enough beside one.
    const auto same_run = [&](std::size_t k) {
      return k < count && turned.quarters[k] == turned.quarters[i] && by_itself(k);
    };
    const bool sure = by_itself(i) || (turned.alone[i] >= kCertainInRun &&
                                       (same_run(i + 1) || (i > 0 && same_run(i - 1))));
    auto& group = groups[{!sure, turned.quarters[i]}];
    group.resize(count, false);
    group[i] = true;
  }
  std::vector<MetadataFinding> out;
  for (const auto& [kind, frames] : groups) {
    const auto& [unsure, quarter_turns] = kind;
    MetadataFinding finding;
    finding.fault = MetadataFault::TurnedImages;
    finding.quarter_turns = quarter_turns;
    for (std::size_t i = 0; i < count; ++i)
      if (frames[i]) finding.frames.push_back(evidence.frames[i]);
    const Judgement judgement = judge(evidence, recorded, turned, pairs_with(evidence, frames));
    if (!judgement.meets(kSuspectedTurned)) continue;
    finding.certain = !unsure && judgement.meets(kCertainTurned) &&
                      judgement.pairs >= kFewestForTurned &&
                      judgement.after_m <= 3.0 * evidence.disagreement.noise_m();
    set_figures(evidence, judgement, finding);
    out.push_back(std::move(finding));
  }
  return out;
}

bool is_quarter(Angle turn) { return std::abs(std::remainder(turn.degrees(), 90.0)) < 1e-6; }

bool about_height(MetadataFault fault) {
  return fault == MetadataFault::HeightReference || fault == MetadataFault::HeightScale;
}

/// The height above the sea that the pictures show, and its sigma.
struct ShownHeight {
  double recorded_m = 0.0, shown_m = 0.0, sigma_m = 0.0;
};
ShownHeight shown_height(const Evidence& evidence, const Reading& free) {
  std::vector<double> heights_m;
  heights_m.reserve(free.frames.size());
  for (const SeenFrame& frame : free.frames) heights_m.push_back(frame.height_m());
  ShownHeight out;
  out.recorded_m = median_of(std::move(heights_m));
  out.shown_m = out.recorded_m * std::exp(free.fit.nuisance.log_height);
  out.sigma_m = out.shown_m * std::hypot(free.fit.sigma_log_height, evidence.focal_sigma);
  return out;
}

/// A height off by a factor makes all pairs disagree by a little: together they show it.
bool shows_height(const Evidence& evidence, const Reading& free, const Judgement& judgement) {
  const double off = std::abs(free.fit.nuisance.log_height);
  const double sigma = std::hypot(free.fit.sigma_log_height, evidence.focal_sigma);
  return off >= kLeastLogHeight && off >= kSigmasOfHeight * sigma &&
         judgement.gain >= kLeastGainOfHeight && judgement.worsened <= kSuspected.most_worsened;
}

/// Whether a shift of all heights is the one that the pictures show.
bool fits_height(const Evidence& evidence, const Reading& shifted, const Reading* free,
                 double sigmas) {
  if (!free) return false;
  const ShownHeight h = shown_height(evidence, *free);
  return std::abs(h.shown_m - h.recorded_m - shifted.finding.height_shift_m) <= sigmas * h.sigma_m;
}

bool may_be_certain(const Evidence& evidence, const Reading& winner, const Reading* free) {
  // What is left for a mount or a height to explain must not be a fault itself.
  const Nuisance& left = winner.fit.nuisance;
  if (left.turn.norm() > kMostTurnLeft || std::abs(left.log_height) > kMostLogHeightLeft)
    return winner.finding.fault == MetadataFault::TurnedImages;
  switch (winner.finding.fault) {
    case MetadataFault::HeightScale: return false;
    case MetadataFault::YawOffset:
    case MetadataFault::CameraTurned: return is_quarter(winner.finding.turn);
    case MetadataFault::PositionsInFeet: return !evidence.poses_of_frames;
    case MetadataFault::HeightReference:
      // A sea level given wrong or a wrong lens would look the same, but for the figure.
      return fits_height(evidence, winner, free, 2.0) &&
             std::abs(winner.finding.height_shift_m) >=
                 kSigmasOfHeight * shown_height(evidence, *free).sigma_m;
    default: return true;
  }
}

}  // namespace

std::vector<MetadataFinding> find_fault(const Flight& flight, const Evidence& evidence,
                                        const Reading& recorded) {
  std::vector<Reading> readings;
  if (auto turned = read_turned(evidence, recorded)) readings.push_back(*std::move(turned));
  const std::vector<bool> all = pairs_with(evidence, {});
  const bool disagrees =
      median_of(recorded.fit.pair_m) > kSuspicious * evidence.disagreement.noise_m() ||
      std::abs(recorded.fit.nuisance.log_height) > 0.9 * kMostLogHeight;
  if (all.size() >= kFewestForFlight && disagrees)
    for (Reading& reading : other_readings(evidence, recorded))
      readings.push_back(std::move(reading));

  const Reading* free = nullptr;
  for (const Reading& reading : readings)
    if (reading.finding.fault == MetadataFault::HeightScale) free = &reading;

  struct Candidate {
    const Reading* reading;
    double score;
  };
  std::vector<Candidate> candidates;
  for (const Reading& reading : readings) {
    const bool turned = reading.finding.fault == MetadataFault::TurnedImages;
    const Judgement judgement = judge(evidence, recorded, reading, all);
    const bool accepted = turned ? !turned_findings(evidence, recorded, reading).empty()
                          : reading.finding.fault == MetadataFault::HeightScale
                              ? shows_height(evidence, reading, judgement)
                              : judgement.meets(kSuspected);
    if (!accepted) continue;
    if (reading.finding.fault == MetadataFault::HeightReference &&
        !fits_height(evidence, reading, free, 3.0))
      continue;
    candidates.push_back({&reading, reading.fit.cost + reading.complexity});
  }
  if (candidates.empty()) return {};
  double least = candidates.front().score;
  for (const Candidate& c : candidates) least = std::min(least, c.score);
  const auto winner = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return c.score <= least + kSimplerFirst;
  });

  Alternatives alternatives;
  for (auto c = candidates.begin(); c != candidates.end(); ++c) {
    if (c == winner || c->score > winner->score + kNearRival) continue;
    // A free height can imitate each of the others that is one.
    if (about_height(c->reading->finding.fault)) continue;
    const bool same = equivalent(evidence, *winner->reading, *c->reading);
    if (same && c->reading->finding.fault == winner->reading->finding.fault) continue;
    (same ? alternatives.same_poses : alternatives.other_poses).push_back(c->reading->finding);
  }

  std::vector<MetadataFinding> out;
  if (winner->reading->finding.fault == MetadataFault::TurnedImages) {
    out = turned_findings(evidence, recorded, *winner->reading);
  } else {
    MetadataFinding finding = winner->reading->finding;
    const Judgement judgement = judge(evidence, recorded, *winner->reading, all);
    finding.certain = judgement.meets(kCertain) &&
                      judgement.after_m <= 2.0 * evidence.disagreement.noise_m() &&
                      may_be_certain(evidence, *winner->reading, free);
    set_figures(evidence, judgement, finding);
    out.push_back(std::move(finding));
  }
  for (MetadataFinding& finding : out) {
    finding.certain = finding.certain && alternatives.other_poses.empty();
    finding.sentence = sentence_of(flight, finding, alternatives);
    if (free && about_height(finding.fault)) {
      const ShownHeight h = shown_height(evidence, *free);
      finding.sentence += height_evidence(h.recorded_m, h.shown_m, h.sigma_m);
    }
  }
  return out;
}

}  // namespace watersky::detail
