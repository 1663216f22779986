// SPDX-License-Identifier: MIT
#pragma once
/// Reading little-endian bytes that may end anywhere.
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "watersky/base/bytes.hpp"
#include "watersky/base/result.hpp"

namespace watersky::detail {

/// Walks over bytes. What does not fit is not read: the cursor then stays failed, and numbers are
/// zero, so that a whole structure is read before asking once.
class Cursor {
 public:
  /// `offset` of the first byte in the file, for errors.
  explicit Cursor(std::span<const std::uint8_t> bytes, std::uint64_t offset = 0)
      : bytes_(bytes), offset_(offset) {}

  [[nodiscard]] bool failed() const { return failed_at_.has_value(); }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] bool done() const { return failed() || left() == 0; }

  template <class T>
  T number() {
    if (!take(sizeof(T))) return T{};
    return number_at<T>(bytes_, at_ - sizeof(T));
  }
  std::span<const std::uint8_t> bytes(std::uint64_t size) {
    if (!take(size)) return {};
    return bytes_.subspan(at_ - static_cast<std::size_t>(size), static_cast<std::size_t>(size));
  }
  std::span<const std::uint8_t> rest() { return bytes(left()); }
  /// A u32 of length, then as many bytes.
  std::span<const std::uint8_t> sized() { return bytes(number<std::uint32_t>()); }
  std::string text() {
    const auto b = sized();
    return {b.begin(), b.end()};
  }

  /// InvalidInput naming the byte at which `what` ends too early; success when it did not.
  [[nodiscard]] Status check(std::string_view what) const {
    if (!failed()) return {};
    return Error{ErrorCode::InvalidInput, "byte " + std::to_string(offset_ + *failed_at_) + ": " +
                                              std::string(what) +
                                              " says that more follows than there is"};
  }

 private:
  bool take(std::uint64_t size) {
    if (failed()) return false;
    if (size > left()) {
      failed_at_ = at_;
      at_ = bytes_.size();
      return false;
    }
    at_ += static_cast<std::size_t>(size);
    return true;
  }

  std::span<const std::uint8_t> bytes_;
  std::uint64_t offset_;
  std::size_t at_ = 0;
  std::optional<std::size_t> failed_at_;
};

inline void put_bytes(Bytes& out, std::span<const std::uint8_t> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}
inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}
/// A u32 of length, then the bytes.
inline void put_sized(Bytes& out, std::span<const std::uint8_t> bytes) {
  put(out, static_cast<std::uint32_t>(bytes.size()));
  put_bytes(out, bytes);
}
inline void put_text(Bytes& out, std::string_view text) { put_sized(out, bytes_of(text)); }

}  // namespace watersky::detail
