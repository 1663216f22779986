// SPDX-License-Identifier: MIT
#pragma once
/// Bytes that can be read from anywhere in them: a file of any size, or memory.
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Fills `into` from `offset` on. OutOfRange beyond the end, Io when the system refuses. May be
  /// called from several threads.
  [[nodiscard]] virtual Status read(std::uint64_t offset, std::span<std::uint8_t> into) const = 0;
};

/// Bytes in memory.
class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::vector<std::uint8_t> bytes) : bytes_(std::move(bytes)) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override;

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Where a writer's bytes go, in order. After an error nothing more is sent.
using ByteSink = std::function<Status(std::span<const std::uint8_t>)>;

/// A part of a recording that could not be read, and why.
struct Damage {
  std::uint64_t offset = 0;  ///< in the file
  std::string reason;
};

/// "byte 1234: reason", as notes show it.
[[nodiscard]] std::string to_string(const Damage& damage);

}  // namespace watersky
