// SPDX-License-Identifier: MIT
#pragma once
/// What an alignment found, for programs (align.json) and for people (report.html): the delay over
/// time, mount and focal length with their sigmas, how well places agree, and pictures of one place
/// before and after.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "watersky/products/alignment_run.hpp"

namespace watersky {

/// Method, delay, estimates, mount and agreement: what run.json holds of an alignment too.
[[nodiscard]] nlohmann::json alignment_summary_json(const AlignmentRun& run);

/// All of align.json: the summary, the delay's course, parameters, and each frame with its time,
/// delay, correction and sigma. `not_written` are frames that the folder beside it lacks. What is
/// not known is null.
[[nodiscard]] nlohmann::json alignment_json(const AlignmentRun& run,
                                            const std::vector<LeftOut>& not_written = {});

/// One page that needs nothing else. It decodes some frames for its pictures; where that fails it
/// has none. Fails only when a picture cannot be encoded.
[[nodiscard]] Result<std::string> alignment_report_html(
    const AlignmentRun& run, const std::vector<LeftOut>& not_written = {});

}  // namespace watersky
