// SPDX-License-Identifier: MIT
#pragma once
/// Reading a source from its beginning on, a piece at a time.
#include <algorithm>

#include "watersky/base/bytes.hpp"
#include "watersky/wire/byte_source.hpp"

namespace watersky::detail {

class Window {
 public:
  static constexpr std::uint64_t kBytes = std::uint64_t{1} << 20;

  explicit Window(const ByteSource& source) : source_(source) {}

  /// Bytes that are there, until the next call. What is longer than the window is held whole.
  Result<std::span<const std::uint8_t>> get(std::uint64_t offset, std::uint64_t size) {
    if (offset < at_ || offset + size > at_ + held_) {
      const auto want = std::max(size, std::min(kBytes, source_.size() - offset));
      if (bytes_.size() < want) bytes_.resize(static_cast<std::size_t>(want));
      held_ = 0;
      at_ = offset;
      WATERSKY_CHECK(source_.read(offset, std::span(bytes_).first(static_cast<std::size_t>(want))));
      held_ = want;
    }
    return std::span<const std::uint8_t>(bytes_).subspan(static_cast<std::size_t>(offset - at_),
                                                         static_cast<std::size_t>(size));
  }

 private:
  const ByteSource& source_;
  Bytes bytes_;
  std::uint64_t at_ = 0, held_ = 0;
};

}  // namespace watersky::detail
