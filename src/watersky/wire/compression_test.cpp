// SPDX-License-Identifier: MIT
#include "watersky/wire/compression.hpp"

#include <gmock/gmock.h>

#include <random>

namespace watersky {
namespace {

using ::testing::HasSubstr;

std::vector<std::uint8_t> some_bytes(std::size_t n, unsigned variety) {
  std::mt19937 random(static_cast<unsigned>(n) + variety);
  std::vector<std::uint8_t> out(n);
  for (auto& b : out) b = static_cast<std::uint8_t>(random() % variety);
  return out;
}

constexpr Compression kAll[] = {Compression::None, Compression::Lz4, Compression::Zstd,
                                Compression::Bz2};

TEST(Compression, DecompressUndoesCompress) {
  for (const Compression c : kAll)
    for (const std::size_t n : {0u, 1u, 1000u, 70'000u, 3'000'000u})
      for (const unsigned variety : {1u, 4u, 256u}) {
        const auto bytes = some_bytes(n, variety);
        const auto packed = compress(c, bytes);
        ASSERT_TRUE(packed);
        const auto back = decompress(c, *packed, n);
        ASSERT_TRUE(back) << to_string(c) << n << ": " << back.error().message;
        EXPECT_EQ(*back, bytes) << to_string(c);
      }
}

TEST(Compression, AnotherSizeThanClaimedIsAnError) {
  for (const Compression c : kAll) {
    const auto packed = compress(c, some_bytes(100'000, 4));
    EXPECT_FALSE(decompress(c, *packed, 99'999)) << to_string(c);
    EXPECT_FALSE(decompress(c, *packed, 100'001)) << to_string(c);
    EXPECT_FALSE(decompress(c, *packed, 0)) << to_string(c);
  }
}

TEST(Compression, WhatIsCutShortOrIsNothingIsAnError) {
  for (const Compression c : {Compression::Lz4, Compression::Zstd, Compression::Bz2}) {
    auto packed = *compress(c, some_bytes(100'000, 4));
    EXPECT_FALSE(decompress(c, some_bytes(5000, 200), 100'000)) << to_string(c);
    EXPECT_FALSE(decompress(c, {}, 100'000)) << to_string(c);
    packed.resize(packed.size() / 2);
    const auto cut = decompress(c, packed, 100'000);
    ASSERT_FALSE(cut);
    EXPECT_THAT(cut.error().message, HasSubstr("cut short")) << to_string(c);
  }
}

TEST(Compression, AClaimOfAnExabyteAllocatesNothingLikeIt) {
  for (const Compression c : kAll) {
    const auto packed = *compress(c, some_bytes(1000, 4));
    EXPECT_FALSE(decompress(c, packed, std::uint64_t{1} << 60)) << to_string(c);
  }
}

TEST(Crc32, IsThatOfTheStandardsCheckValueAndGoesOn) {
  const std::string digits = "123456789";
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size());
  EXPECT_EQ(crc32_of(bytes), 0xCBF43926u);
  EXPECT_EQ(crc32_of(bytes.subspan(4), crc32_of(bytes.first(4))), 0xCBF43926u);
  EXPECT_EQ(crc32_of({}, 7), 7u);
}

}  // namespace
}  // namespace watersky
