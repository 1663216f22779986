// SPDX-License-Identifier: MIT
#pragma once
/// The lanes that update_kernel_impl.hpp is written in, as plain arrays: what every instruction
/// set must equal bit for bit. Included by one source file only; everything has internal linkage,
/// so that no code compiled for a newer processor is shared with the rest of the program.
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace watersky::detail {
namespace {

constexpr const char* kInstructionSet = "scalar";

struct I32 {  ///< 8 cells
  std::int32_t x[8];
};
struct I16 {  ///< 16 cells
  std::int16_t x[16];
};
struct U8 {  ///< 16 cells
  std::uint8_t x[16];
};

template <class V, class F>
inline V each(const F& f) {
  V out;
  int i = 0;
  for (auto& x : out.x) x = static_cast<std::remove_reference_t<decltype(x)>>(f(i++));
  return out;
}
inline std::int32_t wrap(std::uint32_t a) { return static_cast<std::int32_t>(a); }
inline std::uint32_t bits(std::int32_t a) { return static_cast<std::uint32_t>(a); }
inline std::int32_t low(std::int32_t a) { return static_cast<std::int16_t>(bits(a) & 0xFFFFU); }
inline std::int32_t high(std::int32_t a) { return a >> 16; }
inline std::int32_t halves(std::int32_t lo, std::int32_t hi) {
  return wrap((bits(lo) & 0xFFFFU) | bits(hi) << 16);
}

inline I32 set32(std::int32_t a) {
  return each<I32>([&](int) { return a; });
}
inline I32 load32(const std::int32_t* p) {
  I32 v;
  std::memcpy(v.x, p, sizeof v.x);
  return v;
}
inline void store32(std::int32_t* p, const I32& a) { std::memcpy(p, a.x, sizeof a.x); }
inline I32 add32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return wrap(bits(a.x[i]) + bits(b.x[i])); });
}
inline I32 sub32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return wrap(bits(a.x[i]) - bits(b.x[i])); });
}
inline I32 mul32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return wrap(bits(a.x[i]) * bits(b.x[i])); });
}
inline I32 and32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return a.x[i] & b.x[i]; });
}
inline I32 or32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return a.x[i] | b.x[i]; });
}
template <int N>
inline I32 shl32(const I32& a) {
  return each<I32>([&](int i) { return wrap(bits(a.x[i]) << N); });
}
template <int N>
inline I32 shr32(const I32& a) {  // logical
  return each<I32>([&](int i) { return wrap(bits(a.x[i]) >> N); });
}
inline I32 shl32_by(const I32& a, int n) {
  return each<I32>([&](int i) { return wrap(bits(a.x[i]) << n); });
}
inline I32 sra32_by(const I32& a, int n) {
  return each<I32>([&](int i) { return a.x[i] >> n; });
}
inline I32 min32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return a.x[i] < b.x[i] ? a.x[i] : b.x[i]; });
}
inline I32 max32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return a.x[i] > b.x[i] ? a.x[i] : b.x[i]; });
}
/// All ones where a > b.
inline I32 greater32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return a.x[i] > b.x[i] ? -1 : 0; });
}
/// The low 16 bits of a, the high 16 bits of b.
inline I32 low_high(const I32& a, const I32& b) {
  return each<I32>(
      [&](int i) { return wrap((bits(a.x[i]) & 0xFFFFU) | (bits(b.x[i]) & ~0xFFFFU)); });
}
/// Of both halves: products, summed.
inline I32 dot16(const I32& a, const I32& b) {
  return each<I32>([&](int i) {
    return wrap(bits(low(a.x[i]) * low(b.x[i])) + bits(high(a.x[i]) * high(b.x[i])));
  });
}
/// Of each half by itself: low 16 bits of the product, of the left shift by 7, of the difference.
inline I32 mul_halves(const I32& a, const I32& b) {
  return each<I32>(
      [&](int i) { return halves(low(a.x[i]) * low(b.x[i]), high(a.x[i]) * high(b.x[i])); });
}
inline I32 shl7_halves(const I32& a) {
  return each<I32>([&](int i) { return halves(low(a.x[i]) * 128, high(a.x[i]) * 128); });
}
inline I32 sub_halves(const I32& a, const I32& b) {
  return each<I32>(
      [&](int i) { return halves(low(a.x[i]) - low(b.x[i]), high(a.x[i]) - high(b.x[i])); });
}
/// In each half all ones where equal.
inline I32 equal_halves(const I32& a, const I32& b) {
  return each<I32>([&](int i) {
    return halves(low(a.x[i]) == low(b.x[i]) ? -1 : 0, high(a.x[i]) == high(b.x[i]) ? -1 : 0);
  });
}
inline I32 equal32(const I32& a, const I32& b) {
  return each<I32>([&](int i) { return a.x[i] == b.x[i] ? -1 : 0; });
}
/// Two neighbouring pixels at each index.
inline I32 pairs_at(const std::int16_t* base, const I32& index) {
  return each<I32>([&](int i) {
    std::int32_t pair = 0;
    std::memcpy(&pair, base + index.x[i], sizeof pair);
    return pair;
  });
}

inline std::int32_t saturated(std::int32_t a) {
  return a > 32767 ? 32767 : a < -32768 ? -32768 : a;
}
inline I16 pack16(const I32& a, const I32& b) {
  return each<I16>([&](int i) { return saturated(i < 8 ? a.x[i] : b.x[i - 8]); });
}
inline I16 set16(std::int16_t a) {
  return each<I16>([&](int) { return a; });
}
inline I16 load16(const std::int16_t* p) {
  I16 v;
  std::memcpy(v.x, p, sizeof v.x);
  return v;
}
inline void store16(std::int16_t* p, const I16& a) { std::memcpy(p, a.x, sizeof a.x); }
inline I16 adds16(const I16& a, const I16& b) {
  return each<I16>([&](int i) { return saturated(a.x[i] + b.x[i]); });
}
inline I16 min16(const I16& a, const I16& b) {
  return each<I16>([&](int i) { return a.x[i] < b.x[i] ? a.x[i] : b.x[i]; });
}
inline I16 max16(const I16& a, const I16& b) {
  return each<I16>([&](int i) { return a.x[i] > b.x[i] ? a.x[i] : b.x[i]; });
}
/// b where the mask is ones, a where it is 0.
inline I16 choose16(const I16& mask, const I16& a, const I16& b) {
  return each<I16>([&](int i) { return mask.x[i] != 0 ? b.x[i] : a.x[i]; });
}

inline U8 set8(std::uint8_t a) {
  return each<U8>([&](int) { return a; });
}
inline U8 load8(const std::uint8_t* p) {
  U8 v;
  std::memcpy(v.x, p, sizeof v.x);
  return v;
}
inline void store8(std::uint8_t* p, const U8& a) { std::memcpy(p, a.x, sizeof a.x); }
inline U8 adds8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] + b.x[i] > 255 ? 255 : a.x[i] + b.x[i]; });
}
inline U8 sub8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] - b.x[i]; });
}
inline U8 add8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] + b.x[i]; });
}
inline U8 max8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] > b.x[i] ? a.x[i] : b.x[i]; });
}
inline U8 and8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] & b.x[i]; });
}
inline U8 xor8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] ^ b.x[i]; });
}
inline U8 equal8(const U8& a, const U8& b) {
  return each<U8>([&](int i) { return a.x[i] == b.x[i] ? 255 : 0; });
}
/// table[index] for indices below 16.
inline U8 look_up(const U8& table, const U8& index) {
  return each<U8>([&](int i) { return table.x[index.x[i] & 15]; });
}
inline I32 widen_low(const U8& a) {
  return each<I32>([&](int i) { return a.x[i]; });
}
inline I32 widen_high(const U8& a) {
  return each<I32>([&](int i) { return a.x[i + 8]; });
}
/// Signed bytes as 16 bits.
inline I16 widen_signed(const U8& a) {
  return each<I16>([&](int i) { return static_cast<std::int8_t>(a.x[i]); });
}
/// Of 16 bits: low halves of sums, of products; a shift to the right by 2.
inline I16 add16(const I16& a, const I16& b) {
  return each<I16>([&](int i) { return low(a.x[i] + b.x[i]); });
}
inline I16 mul16(const I16& a, const I16& b) {
  return each<I16>([&](int i) { return low(a.x[i] * b.x[i]); });
}
inline I16 quarter16(const I16& a) {
  return each<I16>([&](int i) { return a.x[i] >> 2; });
}
/// A mask of 32 bits as one of bytes.
inline U8 narrow_mask(const I32& a, const I32& b) {
  return each<U8>([&](int i) { return (i < 8 ? a.x[i] : b.x[i - 8]) != 0 ? 255 : 0; });
}

}  // namespace
}  // namespace watersky::detail
