// SPDX-License-Identifier: MIT
#pragma once
/// MAVLink telemetry logs (.tlog): a big-endian UTC stamp in microseconds before each frame.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "watersky/base/time.hpp"
#include "watersky/wire/mavlink.hpp"

namespace watersky::mavlink {

/// One frame and when it reached the ground; the spans point into the log's bytes.
struct TlogRecord {
  Time received_at;
  Frame frame;
};

/// Walks over a log. Garbage between records is skipped byte by byte until a stamp within days
/// of the last one stands before a frame with a good CRC. A frame of an unknown message cannot
/// be checked, and a stamp days away from the last may be garbage or a clock that was set: they
/// count only where another stamp and frame, or the end, follow.
class TlogReader {
 public:
  explicit TlogReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// The next record; nullopt at the end.
  [[nodiscard]] std::optional<TlogRecord> next();

  /// Bytes that belonged to no record, up to where the reader is.
  [[nodiscard]] std::size_t skipped_bytes() const { return skipped_; }
  /// How often the reader had to look for the next record.
  [[nodiscard]] std::size_t gaps() const { return gaps_; }
  /// After the end: bytes of a last record that the log cuts short.
  [[nodiscard]] std::size_t truncated_bytes() const { return truncated_; }

 private:
  enum class Check { Record, CutShort, No };
  Check check(std::size_t at, TlogRecord& record) const;
  [[nodiscard]] bool record_may_begin(std::size_t at, std::uint64_t near_us) const;

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::size_t skipped_ = 0;
  std::size_t gaps_ = 0;
  std::size_t truncated_ = 0;
  std::optional<std::uint64_t> last_us_;
};

/// A record as a log holds it: the stamp, then the frame's bytes.
void append_tlog_record(std::vector<std::uint8_t>& log, Time received_at,
                        std::span<const std::uint8_t> frame);

}  // namespace watersky::mavlink
