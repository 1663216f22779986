// SPDX-License-Identifier: MIT
#pragma once
/// Few pairs of a flight that tell much about its metadata.
#include "watersky/align/metadata_check.hpp"

namespace watersky::detail {

/// All frames that have a pose, in order of time; those without a sight of the sea (a pitch of the
/// wrong sign looks up) with an empty footprint.
[[nodiscard]] std::vector<PlacedFrame> posed_frames(const Flight& flight,
                                                    const FramePairParameters& parameters,
                                                    std::vector<LeftOut>& left_out);

struct PairSample {
  std::vector<RegisteredPair> pairs;  ///< registered ones
  std::size_t tried = 0;
  std::string commonest_reason;  ///< why the others were not; empty when all were
};

/// Two thirds of `budget` go to pairs of successive frames, as far apart as they still share half
/// of what they see (neighbours of a video have hardly moved), spread evenly over time within each
/// of eight headings; a third to revisits. Where a pair so far apart cannot be registered, since
/// the poses may be wrong about what it shares, one half as far is tried.
[[nodiscard]] Result<PairSample> sample_pairs(const Flight& flight,
                                              std::span<const PlacedFrame> posed,
                                              const FramePairParameters& parameters,
                                              std::size_t budget, const Progress& progress);

}  // namespace watersky::detail
