// SPDX-License-Identifier: MIT
#pragma once
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace watersky::test {

/// A folder of the real data ($WATERSKY_DATA, or beside the source tree); nullopt where it is
/// absent: then a test skips and says so.
inline std::optional<std::filesystem::path> real_data(const std::string& name) {
  const char* env = std::getenv("WATERSKY_DATA");
  const std::filesystem::path folder =
      (env ? std::filesystem::path(env)
           : std::filesystem::path(WATERSKY_SOURCE_DIR) / ".." / "shared" / "data") /
      name;
  if (!std::filesystem::exists(folder)) return std::nullopt;
  return folder;
}

}  // namespace watersky::test
