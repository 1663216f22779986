// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/target.hpp"

#include <array>
#include <charconv>
#include <utility>

namespace watersky {

namespace {

constexpr std::array<std::pair<TargetKind, std::string_view>, 4> kNames{
    {{TargetKind::Chessboard, "chessboard"},
     {TargetKind::Circles, "circles"},
     {TargetKind::AsymmetricCircles, "asymmetric-circles"},
     {TargetKind::Holes, "holes"}}};

}  // namespace

std::string_view name_of(TargetKind kind) {
  for (const auto& [known, name] : kNames)
    if (known == kind) return name;
  return {};
}

std::optional<TargetKind> target_kind(std::string_view name) {
  for (const auto& [kind, known] : kNames)
    if (known == name) return kind;
  return std::nullopt;
}

Result<TargetSize> parse_target_size(std::string_view text) {
  constexpr int kLeast = 3, kMost = 100;
  TargetSize size;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, size.columns);
  if (first.ec == std::errc() && first.ptr != end && (*first.ptr == 'x' || *first.ptr == 'X')) {
    const auto second = std::from_chars(first.ptr + 1, end, size.rows);
    if (second.ec == std::errc() && second.ptr == end && size.columns >= kLeast &&
        size.columns <= kMost && size.rows >= kLeast && size.rows <= kMost)
      return size;
  }
  return Error{ErrorCode::Usage,
               "size \"" + std::string(text) +
                   "\" is not COLUMNSxROWS of 3 to 100 each; a chessboard's are its inner "
                   "corners: 9x6 for one of 10 by 7 squares"};
}

std::string to_string(const TargetSize& size) {
  return std::to_string(size.columns) + "x" + std::to_string(size.rows);
}

}  // namespace watersky
