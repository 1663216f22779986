// SPDX-License-Identifier: MIT
#pragma once
/// GDAL, silent: its complaints become our errors. Files are made in memory and written by
/// write_file, which sees every refusal of the system (GDAL 3.6 hides those of closing).
#include <filesystem>
#include <memory>
#include <string>

#include "watersky/base/result.hpp"

class GDALDataset;

namespace watersky {

/// While it lives, GDAL's complaints in this thread are kept here instead of printed. Also
/// registers GDAL's drivers once.
class GdalSession {
 public:
  GdalSession();
  ~GdalSession();
  GdalSession(const GdalSession&) = delete;
  GdalSession& operator=(const GdalSession&) = delete;

  [[nodiscard]] bool failed() const { return !failure_.empty(); }
  /// Io: "OUT/looks.tif: cannot be made: <GDAL's first complaint>".
  [[nodiscard]] Error error(const std::filesystem::path& file) const;

 private:
  friend struct GdalHandler;
  std::string failure_;
};

/// Whether GDAL, as it is installed here, has the driver ("COG"), and whether that can make what
/// `able` names in its creation options ("JPEG"), if given.
[[nodiscard]] bool has_gdal_driver(const std::string& name, std::string_view able = {});

struct DatasetCloser {
  void operator()(GDALDataset* dataset) const;
};
using DatasetPtr = std::unique_ptr<GDALDataset, DatasetCloser>;

/// A name in GDAL's memory file system; what was written there is gone with it.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& extension);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// What was written; valid while this lives. Empty when nothing was.
  [[nodiscard]] std::string_view bytes() const;

 private:
  std::string name_;
};

/// The text itself, or without what is not UTF-8: GeoPackage and JSON allow nothing else.
[[nodiscard]] std::string utf8(const std::string& text);

}  // namespace watersky
