// SPDX-License-Identifier: MIT
#pragma once
/// What maps on disk ask of a file system. Production has POSIX; a test puts one in its place that
/// loses power, tears writes and fills up.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

/// An open file. Errors are Io and name the file.
class StorageFile {
 public:
  virtual ~StorageFile() = default;

  [[nodiscard]] virtual const std::filesystem::path& path() const = 0;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Fills `into` from `offset` on; OutOfRange beyond the end. May be called from several threads.
  [[nodiscard]] virtual Status read(std::uint64_t offset, std::span<std::uint8_t> into) const = 0;
  /// At the end. After an error a part of it may be there: truncate() to the size before.
  [[nodiscard]] virtual Status append(std::span<const std::uint8_t> bytes) = 0;
  [[nodiscard]] virtual Status truncate(std::uint64_t size) = 0;
  /// When it returns, what was appended survives a power cut; the file's name only after
  /// Storage::sync_folder. After an error nothing is known of what was appended since the last
  /// success, and calling again does not tell: write it anew elsewhere.
  [[nodiscard]] virtual Status sync() = 0;
};

/// Held until it goes; gone with the process as well, however that ends.
class StorageLock {
 public:
  virtual ~StorageLock() = default;
};

enum class FileAccess {
  Read,    ///< NotFound when there is none
  Append,  ///< as Read, and may be written
  Create   ///< empty, whatever was there
};

class Storage {
 public:
  virtual ~Storage() = default;

  [[nodiscard]] virtual Result<std::unique_ptr<StorageFile>> open(const std::filesystem::path& file,
                                                                  FileAccess access) = 0;
  /// Names of the files in a folder, in order; NotFound when there is no folder.
  [[nodiscard]] virtual Result<std::vector<std::string>> list(
      const std::filesystem::path& folder) = 0;
  /// And the folders above it.
  [[nodiscard]] virtual Status make_folder(const std::filesystem::path& folder) = 0;
  /// Replaces what is at `to`: either the old or the new is there, at any moment.
  [[nodiscard]] virtual Status rename(const std::filesystem::path& from,
                                      const std::filesystem::path& to) = 0;
  [[nodiscard]] virtual Status remove(const std::filesystem::path& file) = 0;
  /// When it returns, files made, renamed and removed in the folder stay so over a power cut.
  [[nodiscard]] virtual Status sync_folder(const std::filesystem::path& folder) = 0;
  /// Exists when another process holds it.
  [[nodiscard]] virtual Result<std::unique_ptr<StorageLock>> lock(
      const std::filesystem::path& folder) = 0;
};

/// The operating system's files.
[[nodiscard]] Storage& disk();

/// Bytes in memory as a file, under the name that errors shall tell.
[[nodiscard]] std::unique_ptr<StorageFile> memory_file(std::filesystem::path name,
                                                       std::vector<std::uint8_t> bytes);

}  // namespace watersky
