// SPDX-License-Identifier: MIT
#pragma once
/// Files and folders, whole or not at all.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// The whole file; NotFound, or Io, or InvalidInput when it is larger than `max_bytes`.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& file,
                                            std::size_t max_bytes = std::size_t{1} << 30);
[[nodiscard]] Result<std::vector<std::uint8_t>> read_bytes(const std::filesystem::path& file,
                                                           std::size_t max_bytes = std::size_t{1}
                                                                                   << 32);

/// Written beside `file` under another name and renamed, so that nobody sees half of it.
[[nodiscard]] Status write_file(const std::filesystem::path& file, std::string_view bytes);

/// Absolute, without dots and without a slash at its end: its filename() is the last name in it.
[[nodiscard]] std::filesystem::path resolved(const std::filesystem::path& path);

/// ".JPG" → ".jpg".
[[nodiscard]] std::string lower_extension(const std::filesystem::path& file);
[[nodiscard]] std::string lower(std::string_view text);

/// Regular files in `folder` whose lower-case extension is one of `extensions`, by name. Files
/// that begin with a dot are left out (macOS leaves "._DJI_0001.JPG" on memory cards).
[[nodiscard]] Result<std::vector<std::filesystem::path>> files_with_extension(
    const std::filesystem::path& folder, std::initializer_list<std::string_view> extensions);

/// A file in the making beside its later place, for what is too large to be held in memory: under
/// a temporary name until publish(), gone when that is never called.
class PartialFile {
 public:
  /// Io when the system refuses.
  [[nodiscard]] static Result<PartialFile> beside(const std::filesystem::path& target);
  ~PartialFile();
  PartialFile(PartialFile&& other) noexcept;
  PartialFile& operator=(PartialFile&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Status append(std::span<const std::uint8_t> bytes);
  /// Writes over what stands at the beginning.
  [[nodiscard]] Status overwrite_beginning(std::span<const std::uint8_t> bytes);
  /// Puts it in its place, over what stands there.
  [[nodiscard]] Status publish();

 private:
  PartialFile(std::filesystem::path target, std::filesystem::path path, std::FILE* file);
  [[nodiscard]] Error refused(int error) const;
  std::filesystem::path target_;
  std::filesystem::path path_;
  std::FILE* file_;  ///< nullptr: closed
};

/// A folder in the making beside its later place: under a temporary name until publish(), gone
/// with all that is in it when that is never called.
class PartialFolder {
 public:
  /// Makes it, and the folders above `target` that are missing (taken back if it is not
  /// published). Io when the system refuses.
  [[nodiscard]] static Result<PartialFolder> beside(const std::filesystem::path& target);
  ~PartialFolder();
  PartialFolder(PartialFolder&& other) noexcept;
  PartialFolder& operator=(PartialFolder&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Puts it in its place. What stands there is moved aside until it does, then removed: the
  /// caller has asked whether it may.
  [[nodiscard]] Status publish();

 private:
  PartialFolder(std::filesystem::path asked, std::filesystem::path target);
  std::filesystem::path asked_;  ///< as the user wrote it, for messages
  std::filesystem::path target_;
  std::filesystem::path path_;
  std::filesystem::path first_made_;  ///< topmost folder made above the target; may be empty
  void take_back();
};

}  // namespace watersky
