// SPDX-License-Identifier: MIT
#include "watersky/wire/mavlink_signing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/hex.hpp"

namespace watersky::mavlink {
namespace {

using test::from_hex;
using Bytes = std::vector<std::uint8_t>;

const Time kNow{std::chrono::sys_days{std::chrono::year{2026} / 6 / 1}};

// Signed by node-mavlink 2.3.0 with the key made of "watersky", link 7, at 2026-06-01 00:00 UTC.
const Bytes kHeartbeat = from_hex("fd0900000001010000000a0000000103510403fd23");
const Bytes kSigned =
    from_hex("fd0901000001010000000a00000001035104031adb070070d798c2200688bef8bff2");

Frame parsed(const Bytes& bytes) {
  const ParseStep step = parse_frame(bytes);
  EXPECT_EQ(step.outcome, ParseOutcome::Frame);
  return step.frame;
}
SigningKey key() { return signing_key("watersky"); }
Bytes signed_at(Time time, std::uint8_t link = 7) {
  return Signer(key(), link).sign(kHeartbeat, time).value();
}
SignatureVerdict verdict(SignatureChecker& checker, const Bytes& bytes) {
  return checker.check(parsed(bytes));
}

TEST(MavlinkSigning, KeyOfAPassphraseIsItsSha256) {
  EXPECT_THAT(signing_key("abc"),
              testing::ElementsAreArray(from_hex(  // FIPS 180-2, appendix B.1
                  "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad")));
}

TEST(MavlinkSigning, TimestampsCountTensOfMicrosecondsSince2015) {
  const Time start{std::chrono::sys_days{std::chrono::year{2015} / 1 / 1}};
  EXPECT_EQ(signing_timestamp(start), 0u);
  EXPECT_EQ(signing_timestamp(start - std::chrono::hours(1)), 0u);
  EXPECT_EQ(signing_timestamp(start + std::chrono::seconds(1)), 100'000u);
}

TEST(MavlinkSigning, SignsAsNodeMavlinkDoes) {
  EXPECT_EQ(signed_at(kNow), kSigned);
  SignatureChecker checker(key(), kNow);
  EXPECT_EQ(verdict(checker, kSigned), SignatureVerdict::Good);
}

TEST(MavlinkSigning, AnyBitTurnedIsWrongOrNoFrame) {
  for (std::size_t bit = 0; bit < kSigned.size() * 8; ++bit) {
    Bytes bytes = kSigned;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    const ParseStep step = parse_frame(bytes);
    if (step.outcome != ParseOutcome::Frame) continue;
    SignatureChecker checker(key(), kNow);
    EXPECT_NE(checker.check(step.frame), SignatureVerdict::Good) << bit;
  }
}

TEST(MavlinkSigning, WhatComesTwiceOrLateIsRefusedPerSenderAndLink) {
  SignatureChecker checker(key(), kNow);
  const Bytes first = signed_at(kNow), second = signed_at(kNow + std::chrono::microseconds(10));
  EXPECT_EQ(verdict(checker, first), SignatureVerdict::Good);
  EXPECT_EQ(verdict(checker, first), SignatureVerdict::Replayed);
  EXPECT_EQ(verdict(checker, second), SignatureVerdict::Good);
  EXPECT_EQ(verdict(checker, first), SignatureVerdict::Replayed);
  // Another link of the same sender has a clock of its own.
  EXPECT_EQ(verdict(checker, signed_at(kNow, 8)), SignatureVerdict::Good);
}

TEST(MavlinkSigning, AnUnheardSenderIsAtMostAMinuteBehind) {
  SignatureChecker checker(key(), kNow);
  EXPECT_EQ(verdict(checker, signed_at(kNow - std::chrono::seconds(61))), SignatureVerdict::TooOld);
  EXPECT_EQ(verdict(checker, signed_at(kNow - std::chrono::seconds(59))), SignatureVerdict::Good);
  EXPECT_EQ(verdict(checker, signed_at(kNow + std::chrono::hours(1), 1)), SignatureVerdict::Good);
  EXPECT_EQ(verdict(checker, signed_at(kNow, 2)), SignatureVerdict::TooOld);
  EXPECT_EQ(checker.newest_timestamp(), signing_timestamp(kNow + std::chrono::hours(1)));
}

TEST(MavlinkSigning, WhoHasNoKeyCannotShutOutThoseWhoDo) {
  SignatureChecker checker(key(), kNow);
  const Bytes forged =
      Signer(signing_key("guess"), 7).sign(kHeartbeat, kNow + std::chrono::hours(1)).value();
  EXPECT_EQ(verdict(checker, forged), SignatureVerdict::Wrong);
  EXPECT_EQ(verdict(checker, signed_at(kNow)), SignatureVerdict::Good);
  EXPECT_EQ(verdict(checker, kHeartbeat), SignatureVerdict::Unsigned);
}

TEST(MavlinkSigning, TimestampsRiseWhereTheClockDoesNot) {
  Signer signer(key(), 0);
  SignatureChecker checker(key(), kNow);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(verdict(checker, signer.sign(kHeartbeat, kNow - std::chrono::seconds(i)).value()),
              SignatureVerdict::Good);
  Signer again(key(), 0);
  again.advance_to(signer.last_timestamp());
  EXPECT_EQ(verdict(checker, again.sign(kHeartbeat, kNow).value()), SignatureVerdict::Good);
}

TEST(MavlinkSigning, SignsOnlyWhatCanBeSigned) {
  Signer signer(key(), 0);
  const Bytes version1 = from_hex("fe09050101000a0000000103510403346d");
  Bytes cut = kHeartbeat;
  cut.pop_back();
  for (const Bytes& frame : {version1, kSigned, cut, Bytes{}})
    EXPECT_EQ(signer.sign(frame, kNow).error().code, ErrorCode::InvalidInput);
}

}  // namespace
}  // namespace watersky::mavlink
