// SPDX-License-Identifier: MIT
#include "watersky/products/detail/run_folder.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "watersky/io/files.hpp"

namespace watersky::detail {

namespace fs = std::filesystem;

Status check_run_folder(const fs::path& out, const std::string& mark, const std::string& verb,
                        bool overwrite) {
  std::error_code error;
  const fs::path folder = resolved(out);
  if (!fs::exists(fs::symlink_status(folder, error))) return {};
  const bool is_folder = fs::is_directory(folder, error);
  if (is_folder && fs::is_empty(folder, error)) return {};
  if (!overwrite)
    return Error{ErrorCode::Exists, out.string() +
                                        ": is already there; choose another output folder, or "
                                        "replace an earlier run with --overwrite"};
  if (is_folder) {
    std::ifstream file(folder / mark);
    const nlohmann::json run = nlohmann::json::parse(file, nullptr, false);
    if (run.is_object() && run.contains("watersky")) return {};
  }
  return Error{ErrorCode::Exists, out.string() + ": is already there and no run of watersky " +
                                      verb + " (it holds no " + mark +
                                      " of ours), so it is not replaced; choose another output "
                                      "folder"};
}

Error named_as_asked(Error error, const fs::path& in_the_making, const fs::path& out) {
  const std::string part = in_the_making.string();
  if (const std::size_t at = error.message.find(part); at != std::string::npos)
    error.message.replace(at, part.size(), out.string());
  return error;
}

}  // namespace watersky::detail
