// SPDX-License-Identifier: MIT
/// MAVLink frames, signed or not: what is accepted encodes and signs again, and nothing is accepted
/// twice.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "watersky/wire/mavlink_signing.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  using namespace watersky::mavlink;
  const Time now{std::chrono::sys_days{std::chrono::year{2026} / 6 / 1}};
  const SigningKey key = signing_key("fuzz");
  SignatureChecker checker(key, now);
  Signer signer(key, 1);
  std::span rest(data, size);
  while (!rest.empty()) {
    const ParseStep step = parse_frame(rest);
    if (step.outcome != ParseOutcome::Frame) {
      rest = rest.subspan(1);
      continue;
    }
    rest = rest.subspan(step.frame.bytes.size());
    if (checker.check(step.frame) == SignatureVerdict::Good &&
        checker.check(step.frame) != SignatureVerdict::Replayed)
      std::abort();
    if (!step.frame.info) continue;
    const Message message(step.frame);
    const auto frame = encode(message, {step.frame.system, step.frame.component, 0});
    if (!frame) std::abort();
    const ParseStep again = parse_frame(*frame);
    if (again.outcome != ParseOutcome::Frame ||
        !std::ranges::equal(Message(again.frame).payload(), message.payload()))
      std::abort();
    const auto signed_frame = signer.sign(*frame, now);
    if (!signed_frame || checker.check(parse_frame(*signed_frame).frame) != SignatureVerdict::Good)
      std::abort();
  }
  return 0;
}
