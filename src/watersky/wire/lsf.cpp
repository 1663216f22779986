// SPDX-License-Identifier: MIT
#include "watersky/wire/lsf.hpp"

namespace watersky::imc {

void LsfReader::skip_to(std::size_t at) {
  if (at > at_ && gaps_++ == 0) first_gap_at_ = at_;
  skipped_ += at - at_;
  at_ = at;
}

std::optional<LsfRecord> LsfReader::next() {
  bool cut = false;
  for (std::size_t at = at_; at < bytes_.size(); ++at) {
    const ParseStep step = parse_packet(bytes_.subspan(at), *schema_);
    if (step.outcome == ParseOutcome::NeedMore && at == at_) cut = true;
    if (step.outcome != ParseOutcome::Packet) continue;
    skip_to(at);
    at_ = at + step.packet.bytes.size();
    return LsfRecord{at, step.packet};
  }
  // Nothing more: what looked like a cut packet was one if it stands where one should begin.
  if (cut)
    truncated_ = bytes_.size() - at_;
  else
    skip_to(bytes_.size());
  at_ = bytes_.size();
  return std::nullopt;
}

}  // namespace watersky::imc
