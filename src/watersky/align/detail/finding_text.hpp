// SPDX-License-Identifier: MIT
#pragma once
/// What a report says of metadata.
#include "watersky/align/metadata_check.hpp"

namespace watersky::detail {

/// What else would explain what was found: with the same poses in the end, or with others.
struct Alternatives {
  std::vector<MetadataFinding> same_poses, other_poses;
};

[[nodiscard]] std::string sentence_of(const Flight& flight, const MetadataFinding& finding,
                                      const Alternatives& alternatives);
/// "; the pictures show …".
[[nodiscard]] std::string height_evidence(double recorded_m, double shown_m, double sigma_m);
[[nodiscard]] std::string unchecked_text(std::size_t registered, std::size_t tried,
                                         const std::string& reason);
[[nodiscard]] std::string too_few_frames_text(std::size_t posed,
                                              const std::vector<LeftOut>& left_out);
[[nodiscard]] std::string summary_of(const MetadataCheck& check);

}  // namespace watersky::detail
