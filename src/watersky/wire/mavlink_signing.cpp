// SPDX-License-Identifier: MIT
#include "watersky/wire/mavlink_signing.hpp"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>

#include "watersky/wire/detail/mavlink_frame.hpp"

namespace watersky::mavlink {

using namespace detail;

namespace {

constexpr std::size_t kTimestamp = 6;       // bytes, behind the link's id
constexpr std::size_t kSignatureBytes = 6;  // behind the timestamp
constexpr std::uint64_t kTimestampMask = (std::uint64_t{1} << 48) - 1;
constexpr std::uint64_t kMinute = 6'000'000;

std::uint64_t read_timestamp(std::span<const std::uint8_t> bytes) {
  std::uint64_t t = 0;
  for (std::size_t i = 0; i < kTimestamp; ++i) t |= std::uint64_t{bytes[i]} << (8 * i);
  return t;
}

/// Over the key and all of the signed frame before the signature itself.
std::array<std::uint8_t, kSignatureBytes> signature(const SigningKey& key,
                                                    std::span<const std::uint8_t> frame) {
  std::array<std::uint8_t, 32 + kHeader2 + 255 + kCrc + kSignature> text;
  auto end = std::copy(key.begin(), key.end(), text.begin());
  end = std::copy(frame.begin(), frame.end(), end);
  std::array<std::uint8_t, SHA256_DIGEST_LENGTH> hash;
  SHA256(text.data(), static_cast<std::size_t>(end - text.begin()), hash.data());
  std::array<std::uint8_t, kSignatureBytes> out;
  std::copy_n(hash.begin(), out.size(), out.begin());
  return out;
}

}  // namespace

SigningKey signing_key(std::string_view passphrase) {
  SigningKey key;
  SHA256(reinterpret_cast<const unsigned char*>(passphrase.data()), passphrase.size(), key.data());
  return key;
}

std::uint64_t signing_timestamp(Time time) {
  constexpr Time k2015{std::chrono::sys_days{std::chrono::year{2015} / 1 / 1}};
  if (time < k2015) return 0;
  return static_cast<std::uint64_t>((time - k2015) / std::chrono::microseconds(10)) &
         kTimestampMask;
}

Result<std::vector<std::uint8_t>> Signer::sign(std::span<const std::uint8_t> frame, Time now) {
  const ParseStep step = parse_frame(frame);
  if (step.outcome != ParseOutcome::Frame || step.frame.bytes.size() != frame.size() ||
      step.frame.version != 2 || step.frame.is_signed || !step.frame.info)
    return Error{ErrorCode::InvalidInput,
                 "only an unsigned frame of MAVLink 2, of a message that is known, can be signed"};
  std::vector<std::uint8_t> out(frame.begin(), frame.end());
  out.reserve(out.size() + kSignature);
  out[2] |= kIncompatSigned;
  const std::size_t covered = out.size() - kCrc;
  std::uint16_t c = crc(std::span(out).subspan(1, covered - 1));
  c = crc({&step.frame.info->crc_extra, 1}, c);
  out[covered] = static_cast<std::uint8_t>(c & 0xFF);
  out[covered + 1] = static_cast<std::uint8_t>(c >> 8);

  last_ = std::max(last_ + 1, signing_timestamp(now)) & kTimestampMask;
  out.push_back(link_id_);
  for (std::size_t i = 0; i < kTimestamp; ++i)
    out.push_back(static_cast<std::uint8_t>(last_ >> (8 * i)));
  const auto sign = signature(key_, out);
  out.insert(out.end(), sign.begin(), sign.end());
  return out;
}

SignatureVerdict SignatureChecker::check(const Frame& frame) {
  if (!frame.is_signed) return SignatureVerdict::Unsigned;
  const auto covered = frame.bytes.first(frame.bytes.size() - kSignatureBytes);
  const auto expected = signature(key_, covered);
  // In constant time: how long it takes does not tell how many bytes were right.
  if (CRYPTO_memcmp(expected.data(), frame.bytes.data() + covered.size(), expected.size()) != 0)
    return SignatureVerdict::Wrong;

  const auto tail = frame.bytes.last(kSignature);
  const std::uint64_t timestamp = read_timestamp(tail.subspan(1));
  const auto stream = std::tuple(frame.system, frame.component, tail[0]);
  const auto known = last_.find(stream);
  if (known == last_.end()) {
    if (timestamp + kMinute < newest_) return SignatureVerdict::TooOld;
  } else if (timestamp <= known->second) {
    return SignatureVerdict::Replayed;
  }
  last_[stream] = timestamp;
  newest_ = std::max(newest_, timestamp);
  return SignatureVerdict::Good;
}

}  // namespace watersky::mavlink
