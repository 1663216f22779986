// SPDX-License-Identifier: MIT
#pragma once
/// Which reading of the metadata is right, and how sure that is.
#include "watersky/align/detail/readings.hpp"

namespace watersky::detail {

/// The fault that explains most of how the pairs disagree; none where nothing does. Turned images
/// may be two findings: those that are certain, and others.
[[nodiscard]] std::vector<MetadataFinding> find_fault(const Flight& flight,
                                                      const Evidence& evidence,
                                                      const Reading& recorded);

}  // namespace watersky::detail
