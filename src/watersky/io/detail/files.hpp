// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::detail {

/// The whole file; NotFound, or Io, or InvalidInput when it is larger than `max_bytes`.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& file,
                                            std::size_t max_bytes = std::size_t{1} << 30);
[[nodiscard]] Result<std::vector<std::uint8_t>> read_bytes(
    const std::filesystem::path& file, std::size_t max_bytes = std::size_t{1} << 32);

/// Written beside `file` under another name and renamed, so that nobody sees half of it.
[[nodiscard]] Status write_file(const std::filesystem::path& file, std::string_view bytes);

/// ".JPG" → ".jpg".
[[nodiscard]] std::string lower_extension(const std::filesystem::path& file);
[[nodiscard]] std::string lower(std::string_view text);

/// Regular files in `folder` whose lower-case extension is one of `extensions`, by name. Files
/// that begin with a dot are left out (macOS leaves "._DJI_0001.JPG" on memory cards).
[[nodiscard]] Result<std::vector<std::filesystem::path>> files_with_extension(
    const std::filesystem::path& folder, std::initializer_list<std::string_view> extensions);

}  // namespace watersky::detail
