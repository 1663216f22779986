// SPDX-License-Identifier: MIT
#include "watersky/products/alignment_products.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "watersky/io/files.hpp"
#include "watersky/products/alignment_report.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

bool is_earlier_alignment(const fs::path& folder) {
  std::ifstream file(folder / "align.json");
  const nlohmann::json found = nlohmann::json::parse(file, nullptr, false);
  return found.is_object() && found.contains("watersky");
}

}  // namespace

Status check_alignment_output(const fs::path& out, const fs::path& flight,
                              const WriteAlignmentOptions& options) {
  std::error_code error;
  const fs::path folder = resolved(out);
  if (!fs::exists(fs::symlink_status(folder, error))) return {};
  if (fs::equivalent(folder, flight, error))
    return Error{ErrorCode::Exists,
                 out.string() + ": is the flight itself; choose another output folder"};
  if (!options.overwrite)
    return Error{ErrorCode::Exists, out.string() +
                                        ": is already there; choose another output folder, or "
                                        "replace an earlier alignment with --overwrite"};
  if (!fs::is_directory(folder, error) || !is_earlier_alignment(folder))
    return Error{ErrorCode::Exists,
                 out.string() +
                     ": is already there and no alignment of watersky (it holds no align.json of "
                     "ours), so it is not replaced; choose another output folder"};
  return {};
}

Result<std::vector<LeftOut>> write_alignment(const AlignmentRun& run, const fs::path& out,
                                             const WriteAlignmentOptions& options,
                                             const Progress& progress) {
  WATERSKY_CHECK(check_alignment_output(out, {}, options));
  if (run.corrected.frames.empty()) {
    const auto& left_out = run.corrected.left_out;
    return Error{ErrorCode::NotFound,
                 "no frame is left to write: " + summary(run) +
                     (left_out.empty() ? "" : " Last of all: " + left_out.back().reason)};
  }
  WriteFlightOptions write;
  write.images = options.images;
  write.replace = options.overwrite;
  write.companions = {
      {"align.json",
       [&run](const std::vector<LeftOut>& not_written) -> Result<std::string> {
         // An error here leaves no folder: one without images is of no use.
         if (not_written.size() >= run.corrected.frames.size())
           return Error{ErrorCode::NotFound,
                        "none of " + std::to_string(not_written.size()) +
                            " frames could be written; the first: " + not_written.front().file +
                            ": " + not_written.front().reason};
         return alignment_json(run, not_written)
                    .dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
                "\n";
       }},
      {"report.html", [&run](const std::vector<LeftOut>& not_written) {
         return alignment_report_html(run, not_written);
       }}};
  return write_flight_folder(run.corrected, out, write, progress);
}

}  // namespace watersky
