// SPDX-License-Identifier: MIT
#include "watersky/align/metadata_check.hpp"

#include <algorithm>

#include "watersky/align/detail/finding_text.hpp"
#include "watersky/align/detail/pair_sample.hpp"
#include "watersky/align/detail/verdict.hpp"

namespace watersky {

namespace {

/// One fault may hide another: found and taken out one after the other.
constexpr int kMostRounds = 3;
constexpr std::size_t kFewestPairs = 3;
/// What is left of a disagreement beyond so many times what noise does is a contradiction.
constexpr double kContradiction = 3.0;

struct Attempt {
  MetadataCheck check;
  bool some_turned = false;
  bool sampled = false;  ///< there are more pairs
};

Result<Attempt> attempt(const Flight& flight, std::span<const PlacedFrame> posed,
                        const MetadataCheckParameters& parameters, std::size_t budget,
                        const Progress& progress) {
  Attempt out;
  MetadataCheck& check = out.check;
  check.frames_total = flight.frames.size();
  const Duration max_gap = seconds(parameters.pairs.max_pose_gap_s);
  WATERSKY_TRY(const detail::PairSample sample,
               detail::sample_pairs(flight, posed, parameters.pairs, budget, progress));
  check.pairs_tried = sample.tried;
  check.pairs_registered = sample.pairs.size();
  out.sampled = sample.tried >= budget;
  if (sample.pairs.size() < kFewestPairs) {
    check.summary =
        detail::unchecked_text(sample.pairs.size(), sample.tried, sample.commonest_reason);
    return out;
  }
  detail::Evidence evidence = detail::make_evidence(flight, posed, sample.pairs, max_gap);
  check.checked = true;
  check.frames = evidence.frames.size();
  detail::Reading recorded = detail::read_as_recorded(evidence);
  check.disagreement_m = detail::median_of(recorded.fit.pair_m);
  check.disagreement_share = check.disagreement_m / evidence.footprint_side_m;
  for (int round = 0; round < kMostRounds; ++round) {
    bool more = false, all_certain = true;
    for (const MetadataFinding& finding : detail::find_fault(flight, evidence, recorded)) {
      check.findings.push_back(finding);
      out.some_turned |= finding.fault == MetadataFault::TurnedImages;
      all_certain &= finding.certain;
      if (!finding.certain) continue;
      WATERSKY_CHECK(detail::take_out(finding, evidence));
      more = true;
    }
    if (more) recorded = detail::read_as_recorded(evidence);
    // What is only suspected stays in, and would be found again.
    if (!more || !all_certain) break;
  }
  check.mended_disagreement_m = detail::median_of(recorded.fit.pair_m);
  check.contradiction =
      check.mended_disagreement_m > kContradiction * evidence.disagreement.noise_m();
  check.summary = detail::summary_of(check);
  return out;
}

}  // namespace

Result<MetadataCheck> check_metadata(const Flight& flight,
                                     const MetadataCheckParameters& parameters,
                                     const Progress& progress) {
  WATERSKY_CHECK(validate(parameters));
  const Progress told = [&](std::string_view, std::size_t done, std::size_t total) {
    report(progress, "check metadata", done, total);
  };
  std::vector<LeftOut> left_out;
  const std::vector<PlacedFrame> posed = detail::posed_frames(flight, parameters.pairs, left_out);
  if (posed.size() < 2) {
    MetadataCheck check;
    check.frames_total = flight.frames.size();
    check.summary = detail::too_few_frames_text(posed.size(), left_out);
    return check;
  }
  WATERSKY_TRY(Attempt first, attempt(flight, posed, parameters,
                                      static_cast<std::size_t>(parameters.most_pairs), told));
  if (!first.some_turned || !first.sampled ||
      parameters.most_pairs_if_suspicious <= parameters.most_pairs)
    return std::move(first.check);
  WATERSKY_TRY(Attempt second,
               attempt(flight, posed, parameters,
                       static_cast<std::size_t>(parameters.most_pairs_if_suspicious), told));
  return std::move(second.check);
}

}  // namespace watersky
