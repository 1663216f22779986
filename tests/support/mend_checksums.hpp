// SPDX-License-Identifier: MIT
#pragma once
/// Gives the preamble, each record and the footer of a map file or journal, as far as they can be
/// told, the checksum of what is there: for fuzzers, which seldom find one, and for tests of what
/// stands behind a checksum.
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "watersky/store/detail/records.hpp"

namespace watersky::test {

inline void mend_checksums(std::vector<std::uint8_t>& file) {
  const auto mend = [&](std::size_t at, std::uint64_t sum) {
    std::memcpy(file.data() + at, &sum, sizeof sum);
  };
  if (file.size() < detail::kPreambleBytes) return;
  mend(16, detail::checksum(std::span(file).first(16)));
  for (std::size_t at = detail::kPreambleBytes; at + detail::kRecordHeadBytes <= file.size();) {
    const auto size = number_at<std::uint32_t>(file, at + 8);
    if (size > file.size() - at - detail::kRecordHeadBytes) break;
    std::vector<std::uint8_t> summed(file.begin() + static_cast<std::ptrdiff_t>(at),
                                     file.begin() + static_cast<std::ptrdiff_t>(at) + 16);
    const auto payload = std::span(file).subspan(at + detail::kRecordHeadBytes, size);
    summed.insert(summed.end(), payload.begin(), payload.end());
    mend(at + 16, detail::checksum(summed));
    at += static_cast<std::size_t>(detail::record_bytes(size));
  }
  mend(file.size() - 8, detail::checksum(std::span(file).last(24).first(16)));
}

}  // namespace watersky::test
