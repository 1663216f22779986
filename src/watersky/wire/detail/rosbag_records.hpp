// SPDX-License-Identifier: MIT
#pragma once
/// Records of a bag: a header of fields, and data.
#include <map>
#include <string>
#include <string_view>

#include "watersky/base/time.hpp"
#include "watersky/wire/detail/cursor.hpp"
#include "watersky/wire/rosbag.hpp"

namespace watersky::rosbag::detail {

inline constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
/// The record at the beginning, padded so that it can be written anew.
inline constexpr std::size_t kFileHeaderBytes = 4096;

enum class Op : std::uint8_t {
  Message = 2,
  FileHeader = 3,
  Index = 4,
  Chunk = 5,
  ChunkInfo = 6,
  Connection = 7
};

/// Fields by name; the values point into what was parsed.
class Fields {
 public:
  /// InvalidInput naming the byte.
  [[nodiscard]] static Result<Fields> parse(std::span<const std::uint8_t> header,
                                            std::uint64_t offset);

  [[nodiscard]] bool has(std::string_view name) const { return fields_.contains(name); }
  [[nodiscard]] std::string text(std::string_view name) const;
  /// nullopt unless the field is there with the number's size.
  template <class T>
  [[nodiscard]] std::optional<T> number(std::string_view name) const {
    const auto at = fields_.find(name);
    if (at == fields_.end() || at->second.size() != sizeof(T)) return std::nullopt;
    return number_at<T>(at->second, 0);
  }
  [[nodiscard]] std::optional<Time> time(std::string_view name) const;

 private:
  std::map<std::string, std::span<const std::uint8_t>, std::less<>> fields_;
};

/// ROS's u32 of seconds and u32 of nanoseconds.
[[nodiscard]] Time time_of(std::uint32_t s, std::uint32_t ns);
void put_time(Bytes& out, Time time);

void put_field(Bytes& out, std::string_view name, std::span<const std::uint8_t> value);
template <class T>
void put_field_number(Bytes& out, std::string_view name, T value) {
  Bytes b;
  put(b, value);
  put_field(out, name, b);
}
void put_record(Bytes& out, const Bytes& header, std::span<const std::uint8_t> data);
/// A connection's record, as it stands in a chunk and in the index.
void put_connection(Bytes& out, const Connection& connection);

}  // namespace watersky::rosbag::detail
