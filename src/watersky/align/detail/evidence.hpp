// SPDX-License-Identifier: MIT
#pragma once
/// What the registered pairs of a flight speak of.
#include <span>
#include <vector>

#include "watersky/align/detail/disagreement.hpp"
#include "watersky/align/metadata_check.hpp"

namespace watersky::detail {

/// The part of a flight that its registered pairs speak of.
struct Evidence {
  Flight flight;                    ///< the frames of the pairs alone, and the poses around them
  std::vector<std::size_t> frames;  ///< their indices in the whole flight
  Disagreement disagreement;
  Duration max_gap;
  double footprint_side_m = 0.0;
  double focal_sigma = 0.02;     ///< one sigma of the focal length, of itself
  bool poses_of_frames = false;  ///< each recorded with its frame (EXIF), not in a log
};

/// Of at least one pair.
[[nodiscard]] Evidence make_evidence(const Flight& flight, std::span<const PlacedFrame> posed,
                                     const std::vector<RegisteredPair>& pairs, Duration max_gap);

/// Takes a fault out of the evidence, as mended() takes it out of a flight.
[[nodiscard]] Status take_out(const MetadataFinding& finding, Evidence& evidence);

}  // namespace watersky::detail
