// SPDX-License-Identifier: MIT
#pragma once
/// The lanes of simd_scalar.hpp, which says what each does, in NEON (AArch64).
#include <arm_neon.h>

#include <cstdint>
#include <cstring>

namespace watersky::detail {
namespace {

constexpr const char* kInstructionSet = "NEON";

struct I32 {
  int32x4_t a, b;
};
struct I16 {
  int16x8_t a, b;
};
using U8 = uint8x16_t;

inline int16x8_t as16(int32x4_t v) { return vreinterpretq_s16_s32(v); }
inline int32x4_t as32(int16x8_t v) { return vreinterpretq_s32_s16(v); }
inline uint32x4_t unsigned32(int32x4_t v) { return vreinterpretq_u32_s32(v); }
inline int32x4_t signed32(uint32x4_t v) { return vreinterpretq_s32_u32(v); }

inline I32 set32(std::int32_t a) { return {vdupq_n_s32(a), vdupq_n_s32(a)}; }
inline I32 load32(const std::int32_t* p) { return {vld1q_s32(p), vld1q_s32(p + 4)}; }
inline void store32(std::int32_t* p, I32 v) {
  vst1q_s32(p, v.a);
  vst1q_s32(p + 4, v.b);
}
inline I32 add32(I32 p, I32 q) { return {vaddq_s32(p.a, q.a), vaddq_s32(p.b, q.b)}; }
inline I32 sub32(I32 p, I32 q) { return {vsubq_s32(p.a, q.a), vsubq_s32(p.b, q.b)}; }
inline I32 mul32(I32 p, I32 q) { return {vmulq_s32(p.a, q.a), vmulq_s32(p.b, q.b)}; }
inline I32 and32(I32 p, I32 q) { return {vandq_s32(p.a, q.a), vandq_s32(p.b, q.b)}; }
inline I32 or32(I32 p, I32 q) { return {vorrq_s32(p.a, q.a), vorrq_s32(p.b, q.b)}; }
template <int N>
inline I32 shl32(I32 v) {
  return {vshlq_n_s32(v.a, N), vshlq_n_s32(v.b, N)};
}
template <int N>
inline I32 shr32(I32 v) {
  return {signed32(vshrq_n_u32(unsigned32(v.a), N)), signed32(vshrq_n_u32(unsigned32(v.b), N))};
}
inline I32 shl32_by(I32 v, int n) {
  const int32x4_t by = vdupq_n_s32(n);
  return {vshlq_s32(v.a, by), vshlq_s32(v.b, by)};
}
inline I32 sra32_by(I32 v, int n) { return shl32_by(v, -n); }
inline I32 min32(I32 p, I32 q) { return {vminq_s32(p.a, q.a), vminq_s32(p.b, q.b)}; }
inline I32 max32(I32 p, I32 q) { return {vmaxq_s32(p.a, q.a), vmaxq_s32(p.b, q.b)}; }
inline I32 greater32(I32 p, I32 q) {
  return {signed32(vcgtq_s32(p.a, q.a)), signed32(vcgtq_s32(p.b, q.b))};
}
inline I32 low_high(I32 p, I32 q) {
  const uint32x4_t low = vdupq_n_u32(0xFFFFU);
  return {vbslq_s32(low, p.a, q.a), vbslq_s32(low, p.b, q.b)};
}
inline int32x4_t dot16(int32x4_t p, int32x4_t q) {
  const int16x8_t a = as16(p), b = as16(q);
  return vpaddq_s32(vmull_s16(vget_low_s16(a), vget_low_s16(b)), vmull_high_s16(a, b));
}
inline I32 dot16(I32 p, I32 q) { return {dot16(p.a, q.a), dot16(p.b, q.b)}; }
inline I32 mul_halves(I32 p, I32 q) {
  return {as32(vmulq_s16(as16(p.a), as16(q.a))), as32(vmulq_s16(as16(p.b), as16(q.b)))};
}
inline I32 shl7_halves(I32 v) {
  return {as32(vshlq_n_s16(as16(v.a), 7)), as32(vshlq_n_s16(as16(v.b), 7))};
}
inline I32 sub_halves(I32 p, I32 q) {
  return {as32(vsubq_s16(as16(p.a), as16(q.a))), as32(vsubq_s16(as16(p.b), as16(q.b)))};
}
inline I32 equal_halves(I32 p, I32 q) {
  return {vreinterpretq_s32_u16(vceqq_s16(as16(p.a), as16(q.a))),
          vreinterpretq_s32_u16(vceqq_s16(as16(p.b), as16(q.b)))};
}
inline I32 equal32(I32 p, I32 q) {
  return {signed32(vceqq_s32(p.a, q.a)), signed32(vceqq_s32(p.b, q.b))};
}
inline std::int32_t pair_at(const std::int16_t* p) {
  std::int32_t pair = 0;
  std::memcpy(&pair, p, sizeof pair);
  return pair;
}
inline int32x4_t four_pairs(const std::int16_t* base, int32x4_t index) {
  int32x4_t v = vdupq_n_s32(pair_at(base + vgetq_lane_s32(index, 0)));
  v = vsetq_lane_s32(pair_at(base + vgetq_lane_s32(index, 1)), v, 1);
  v = vsetq_lane_s32(pair_at(base + vgetq_lane_s32(index, 2)), v, 2);
  return vsetq_lane_s32(pair_at(base + vgetq_lane_s32(index, 3)), v, 3);
}
inline I32 pairs_at(const std::int16_t* base, I32 index) {
  return {four_pairs(base, index.a), four_pairs(base, index.b)};
}

inline I16 pack16(I32 p, I32 q) {
  return {vcombine_s16(vqmovn_s32(p.a), vqmovn_s32(p.b)),
          vcombine_s16(vqmovn_s32(q.a), vqmovn_s32(q.b))};
}
inline I16 set16(std::int16_t a) { return {vdupq_n_s16(a), vdupq_n_s16(a)}; }
inline I16 load16(const std::int16_t* p) { return {vld1q_s16(p), vld1q_s16(p + 8)}; }
inline void store16(std::int16_t* p, I16 v) {
  vst1q_s16(p, v.a);
  vst1q_s16(p + 8, v.b);
}
inline I16 adds16(I16 p, I16 q) { return {vqaddq_s16(p.a, q.a), vqaddq_s16(p.b, q.b)}; }
inline I16 min16(I16 p, I16 q) { return {vminq_s16(p.a, q.a), vminq_s16(p.b, q.b)}; }
inline I16 max16(I16 p, I16 q) { return {vmaxq_s16(p.a, q.a), vmaxq_s16(p.b, q.b)}; }
inline I16 choose16(I16 mask, I16 p, I16 q) {
  return {vbslq_s16(vreinterpretq_u16_s16(mask.a), q.a, p.a),
          vbslq_s16(vreinterpretq_u16_s16(mask.b), q.b, p.b)};
}

inline U8 set8(std::uint8_t a) { return vdupq_n_u8(a); }
inline U8 load8(const std::uint8_t* p) { return vld1q_u8(p); }
inline void store8(std::uint8_t* p, U8 v) { vst1q_u8(p, v); }
inline U8 adds8(U8 p, U8 q) { return vqaddq_u8(p, q); }
inline U8 sub8(U8 p, U8 q) { return vsubq_u8(p, q); }
inline U8 add8(U8 p, U8 q) { return vaddq_u8(p, q); }
inline U8 max8(U8 p, U8 q) { return vmaxq_u8(p, q); }
inline U8 and8(U8 p, U8 q) { return vandq_u8(p, q); }
inline U8 xor8(U8 p, U8 q) { return veorq_u8(p, q); }
inline U8 equal8(U8 p, U8 q) { return vceqq_u8(p, q); }
inline U8 look_up(U8 table, U8 index) { return vqtbl1q_u8(table, index); }
inline I32 widen(uint8x8_t v) {
  const uint16x8_t w = vmovl_u8(v);
  return {signed32(vmovl_u16(vget_low_u16(w))), signed32(vmovl_high_u16(w))};
}
inline I32 widen_low(U8 v) { return widen(vget_low_u8(v)); }
inline I32 widen_high(U8 v) { return widen(vget_high_u8(v)); }
inline I16 widen_signed(U8 v) {
  const int8x16_t s = vreinterpretq_s8_u8(v);
  return {vmovl_s8(vget_low_s8(s)), vmovl_high_s8(s)};
}
inline I16 add16(I16 p, I16 q) { return {vaddq_s16(p.a, q.a), vaddq_s16(p.b, q.b)}; }
inline I16 mul16(I16 p, I16 q) { return {vmulq_s16(p.a, q.a), vmulq_s16(p.b, q.b)}; }
inline I16 quarter16(I16 v) { return {vshrq_n_s16(v.a, 2), vshrq_n_s16(v.b, 2)}; }
inline U8 narrow_mask(I32 p, I32 q) {
  const I16 packed = pack16(p, q);
  return vreinterpretq_u8_s8(vcombine_s8(vqmovn_s16(packed.a), vqmovn_s16(packed.b)));
}

}  // namespace
}  // namespace watersky::detail
