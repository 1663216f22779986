// SPDX-License-Identifier: MIT
#pragma once
/// Which images are stored turned, from how pairs of them agree under each turn.
#include "watersky/align/detail/disagreement.hpp"

namespace watersky::detail {

struct TurnedImages {
  Quarters quarters;  ///< of each seen frame
  /// What the cost of all pairs would rise by, were a frame not turned, and were all of the frames
  /// joined with it to be turned back; 0 for frames that are not turned.
  std::vector<double> alone, together;
  /// Pairs in which a frame has a say.
  std::vector<std::size_t> pairs;
};

/// Two frames tell their turn against each other by how the picture turns from one to the other,
/// and both against the metadata by which way the picture moves. So: the surest pairs first, as a
/// spanning forest, give turns within each tree; each tree then as a whole, and after that every
/// frame by itself, is turned as the pairs agree best. Each frame turned costs `penalty`.
[[nodiscard]] TurnedImages find_turned_images(const Disagreement& disagreement,
                                              std::span<const SeenFrame> frames, bool quarters,
                                              double penalty);

}  // namespace watersky::detail
