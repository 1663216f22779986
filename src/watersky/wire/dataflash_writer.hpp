// SPDX-License-Identifier: MIT
#pragma once
/// Writes logs that dataflash::Reader, and ArduPilot's own tools, read.
///
///   dataflash::Writer log;
///   const auto att = log.add_format("ATT", "Qfff", "TimeUS,Roll,Pitch,Yaw");
///   log.append(att, {1e6, 0.5, -2.0, 87.0});
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/bytes.hpp"

namespace watersky::dataflash {

class Writer {
 public:
  /// Begins with FMT's own description.
  Writer();

  /// Describes a record and returns its number. `letters` are FMT's, of numbers only (at most 16),
  /// one to each of `columns` (separated by commas, at most 64 characters); `name` has at most four
  /// characters. A contract violation otherwise, and for more than 100 formats.
  std::size_t add_format(std::string_view name, std::string_view letters, std::string_view columns);
  /// A record of a format, in the units that Record::number() gives back: whole-number fields take
  /// the nearest whole number; beyond their range the nearest end, NaN zero.
  void append(std::size_t format, std::initializer_list<double> values);

  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
  std::vector<std::string> letters_;
};

}  // namespace watersky::dataflash
