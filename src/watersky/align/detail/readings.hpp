// SPDX-License-Identifier: MIT
#pragma once
/// Ways in which a flight's metadata may be wrong, each compared with the flight as recorded.
#include "watersky/align/detail/evidence.hpp"

namespace watersky::detail {

/// A way to read the metadata, and how the pairs agree under it.
struct Reading {
  MetadataFinding finding;
  bool as_recorded = false;
  std::vector<SeenFrame> frames;
  Quarters quarters;
  Fit fit;
  double complexity = 0.0;  ///< what it must gain, in cost
  /// Of turned images, see TurnedImages.
  std::vector<double> alone, together;
};

[[nodiscard]] std::vector<SeenFrame> see_frames(const Evidence& evidence, const Flight& flight);

[[nodiscard]] Reading read_as_recorded(const Evidence& evidence);
/// The same with some images turned back; without any turned, nullopt.
[[nodiscard]] std::optional<Reading> read_turned(const Evidence& evidence,
                                                 const Reading& as_recorded);
/// All the others, simpler ones first.
[[nodiscard]] std::vector<Reading> other_readings(const Evidence& evidence,
                                                  const Reading& as_recorded);

/// Whether two readings put what the frames see in the same places, so that it does not matter
/// which is right.
[[nodiscard]] bool equivalent(const Evidence& evidence, const Reading& a, const Reading& b);

}  // namespace watersky::detail
