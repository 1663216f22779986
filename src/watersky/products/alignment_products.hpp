// SPDX-License-Identifier: MIT
#pragma once
/// What comes out of an alignment, as files: a corrected flight folder with align.json and
/// report.html in it. Names and contents are a contract.
#include <filesystem>

#include "watersky/base/progress.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/products/alignment_run.hpp"

namespace watersky {

struct WriteAlignmentOptions {
  bool overwrite = false;  ///< replace an earlier alignment of ours
  StoredImages images = StoredImages::Keep;
};

/// Whether write_alignment could start: Exists when OUT is there and is not an earlier alignment
/// (it holds an align.json of ours) that may be replaced, or when it is `flight` itself. For asking
/// before the work.
[[nodiscard]] Status check_alignment_output(const std::filesystem::path& out,
                                            const std::filesystem::path& flight,
                                            const WriteAlignmentOptions& options = {});

/// Writes the corrected flight, whole or not at all. Returns the frames whose image could not be
/// written; they are not in frames.csv, and align.json names them among those left out. NotFound
/// when the corrected flight has no frame.
[[nodiscard]] Result<std::vector<LeftOut>> write_alignment(
    const AlignmentRun& run, const std::filesystem::path& out,
    const WriteAlignmentOptions& options = {}, const Progress& progress = {});

}  // namespace watersky
