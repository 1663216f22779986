// SPDX-License-Identifier: MIT
#include "watersky/wire/tlog.hpp"

namespace watersky::mavlink {

namespace {

constexpr std::size_t kStamp = 8;
/// The radio link may be silent for long, but not for this.
constexpr std::uint64_t kDays_us = 3ull * 24 * 3600 * 1'000'000;
/// 1990 to 2100: what a stamp must lie in before one has been seen.
constexpr std::uint64_t kEarliest_us = 631'152'000ull * 1'000'000;
constexpr std::uint64_t kLatest_us = 4'102'444'800ull * 1'000'000;

std::uint64_t stamp_us(std::span<const std::uint8_t> bytes) {
  std::uint64_t us = 0;
  for (std::size_t i = 0; i < kStamp; ++i) us = us << 8 | bytes[i];
  return us;
}

bool plausible(std::uint64_t us) { return us >= kEarliest_us && us <= kLatest_us; }
bool near(std::uint64_t us, std::uint64_t other_us) {
  return us + kDays_us >= other_us && us <= other_us + kDays_us;
}

}  // namespace

bool TlogReader::record_may_begin(std::size_t at, std::uint64_t near_us) const {
  const auto rest = bytes_.subspan(at);
  if (rest.size() < kStamp) return true;  // the log's end, whole or cut
  const std::uint64_t us = stamp_us(rest);
  return plausible(us) && near(us, near_us) &&
         (rest.size() == kStamp || rest[kStamp] == 0xFD || rest[kStamp] == 0xFE);
}

TlogReader::Check TlogReader::check(std::size_t at, TlogRecord& record) const {
  const auto rest = bytes_.subspan(at);
  if (rest.size() <= kStamp) return Check::CutShort;
  const std::uint64_t us = stamp_us(rest);
  if (!plausible(us)) return Check::No;
  const ParseStep step = parse_frame(rest.subspan(kStamp));
  if (step.outcome == ParseOutcome::NeedMore) return Check::CutShort;
  if (step.outcome == ParseOutcome::NotAFrame) return Check::No;
  const bool sure = step.frame.info && (!last_us_ || near(us, *last_us_));
  if (!sure && !record_may_begin(at + kStamp + step.frame.bytes.size(), us)) return Check::No;
  record = {Time(std::chrono::microseconds(us)), step.frame};
  return Check::Record;
}

std::optional<TlogRecord> TlogReader::next() {
  std::optional<std::size_t> cut_at;
  for (std::size_t at = at_; at < bytes_.size(); ++at) {
    TlogRecord record;
    const Check found = check(at, record);
    if (found == Check::CutShort && !cut_at) cut_at = at;
    if (found != Check::Record) continue;
    if (at > at_) ++gaps_;
    skipped_ += at - at_;
    at_ = at + kStamp + record.frame.bytes.size();
    last_us_ = stamp_us(bytes_.subspan(at));
    return record;
  }
  // Nothing more: what looked like a cut record was one if it stands where one should begin.
  if (cut_at == at_) {
    truncated_ = bytes_.size() - at_;
  } else if (at_ < bytes_.size()) {
    ++gaps_;
    skipped_ += bytes_.size() - at_;
  }
  at_ = bytes_.size();
  return std::nullopt;
}

void append_tlog_record(std::vector<std::uint8_t>& log, Time received_at,
                        std::span<const std::uint8_t> frame) {
  const auto us = static_cast<std::uint64_t>(
      std::chrono::floor<std::chrono::microseconds>(received_at.time_since_epoch()).count());
  for (int shift = 56; shift >= 0; shift -= 8)
    log.push_back(static_cast<std::uint8_t>(us >> shift));
  log.insert(log.end(), frame.begin(), frame.end());
}

}  // namespace watersky::mavlink
