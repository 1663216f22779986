// SPDX-License-Identifier: MIT
#pragma once
/// Signed MAVLink 2: who holds the key can say that a frame is his, and that it is new.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"
#include "watersky/wire/mavlink.hpp"

namespace watersky::mavlink {

using SigningKey = std::array<std::uint8_t, 32>;

/// SHA-256 of a passphrase: how ground stations make a key of what a person types.
[[nodiscard]] SigningKey signing_key(std::string_view passphrase);

/// 10 µs since 2015-01-01 00:00 UTC, 48 bits of it; 0 before.
[[nodiscard]] std::uint64_t signing_timestamp(Time time);

/// Signs what one sender sends on one link. Timestamps rise with every frame, also where the
/// clock does not.
class Signer {
 public:
  Signer(const SigningKey& key, std::uint8_t link_id) : key_(key), link_id_(link_id) {}

  /// An unsigned frame of MAVLink 2 and of a known message, as encode() makes it, signed. Its CRC
  /// is made anew, as signing changes the header. InvalidInput for any other.
  [[nodiscard]] Result<std::vector<std::uint8_t>> sign(std::span<const std::uint8_t> frame,
                                                       Time now);
  /// Keep it beside the key: a sender that begins again below it is not believed.
  [[nodiscard]] std::uint64_t last_timestamp() const { return last_; }
  /// The next timestamp is greater than this one, which was stored or came from a peer.
  void advance_to(std::uint64_t timestamp) { last_ = std::max(last_, timestamp); }

 private:
  SigningKey key_;
  std::uint8_t link_id_;
  std::uint64_t last_ = 0;
};

enum class SignatureVerdict {
  Good,
  Unsigned,  ///< whether to take it is the caller's to say: ArduPilot takes RADIO_STATUS
  Wrong,     ///< another key, or changed on its way
  Replayed,  ///< good, but not newer than what its sender sent last on this link
  TooOld,    ///< good, of a sender not heard before, more than a minute behind the newest
};

/// Checks what is received under one key, and that nothing comes twice.
class SignatureChecker {
 public:
  /// Nothing older than a minute before `now` is taken from a sender not heard before.
  SignatureChecker(const SigningKey& key, Time now) : key_(key), newest_(signing_timestamp(now)) {}

  /// Only a Good frame changes what is remembered, so that who has no key cannot shut out others
  /// or fill the memory.
  [[nodiscard]] SignatureVerdict check(const Frame& frame);
  /// The newest timestamp seen, or that of the start.
  [[nodiscard]] std::uint64_t newest_timestamp() const { return newest_; }

 private:
  SigningKey key_;
  std::uint64_t newest_;
  std::map<std::tuple<std::uint8_t, std::uint8_t, std::uint8_t>, std::uint64_t> last_;
};

}  // namespace watersky::mavlink
