// SPDX-License-Identifier: MIT
#pragma once
/// The lanes of simd_scalar.hpp, which says what each does, in SSE4.1.
#include <immintrin.h>

#include <cstdint>
#include <cstring>

namespace watersky::detail {
namespace {

constexpr const char* kInstructionSet = "SSE4.1";

struct I32 {
  __m128i a, b;
};
struct I16 {
  __m128i a, b;
};
using U8 = __m128i;

inline __m128i load_vector(const void* p) {
  return _mm_loadu_si128(static_cast<const __m128i*>(p));
}
inline void store_vector(void* p, __m128i v) { _mm_storeu_si128(static_cast<__m128i*>(p), v); }

inline I32 set32(std::int32_t a) { return {_mm_set1_epi32(a), _mm_set1_epi32(a)}; }
inline I32 load32(const std::int32_t* p) { return {load_vector(p), load_vector(p + 4)}; }
inline void store32(std::int32_t* p, I32 v) {
  store_vector(p, v.a);
  store_vector(p + 4, v.b);
}
inline I32 add32(I32 p, I32 q) { return {_mm_add_epi32(p.a, q.a), _mm_add_epi32(p.b, q.b)}; }
inline I32 sub32(I32 p, I32 q) { return {_mm_sub_epi32(p.a, q.a), _mm_sub_epi32(p.b, q.b)}; }
inline I32 mul32(I32 p, I32 q) { return {_mm_mullo_epi32(p.a, q.a), _mm_mullo_epi32(p.b, q.b)}; }
inline I32 and32(I32 p, I32 q) { return {_mm_and_si128(p.a, q.a), _mm_and_si128(p.b, q.b)}; }
inline I32 or32(I32 p, I32 q) { return {_mm_or_si128(p.a, q.a), _mm_or_si128(p.b, q.b)}; }
template <int N>
inline I32 shl32(I32 v) {
  return {_mm_slli_epi32(v.a, N), _mm_slli_epi32(v.b, N)};
}
template <int N>
inline I32 shr32(I32 v) {
  return {_mm_srli_epi32(v.a, N), _mm_srli_epi32(v.b, N)};
}
inline I32 shl32_by(I32 v, int n) {
  const __m128i by = _mm_cvtsi32_si128(n);
  return {_mm_sll_epi32(v.a, by), _mm_sll_epi32(v.b, by)};
}
inline I32 sra32_by(I32 v, int n) {
  const __m128i by = _mm_cvtsi32_si128(n);
  return {_mm_sra_epi32(v.a, by), _mm_sra_epi32(v.b, by)};
}
inline I32 min32(I32 p, I32 q) { return {_mm_min_epi32(p.a, q.a), _mm_min_epi32(p.b, q.b)}; }
inline I32 max32(I32 p, I32 q) { return {_mm_max_epi32(p.a, q.a), _mm_max_epi32(p.b, q.b)}; }
inline I32 greater32(I32 p, I32 q) {
  return {_mm_cmpgt_epi32(p.a, q.a), _mm_cmpgt_epi32(p.b, q.b)};
}
inline I32 low_high(I32 p, I32 q) {
  return {_mm_blend_epi16(p.a, q.a, 0xAA), _mm_blend_epi16(p.b, q.b, 0xAA)};
}
inline I32 dot16(I32 p, I32 q) { return {_mm_madd_epi16(p.a, q.a), _mm_madd_epi16(p.b, q.b)}; }
inline I32 mul_halves(I32 p, I32 q) {
  return {_mm_mullo_epi16(p.a, q.a), _mm_mullo_epi16(p.b, q.b)};
}
inline I32 shl7_halves(I32 v) { return {_mm_slli_epi16(v.a, 7), _mm_slli_epi16(v.b, 7)}; }
inline I32 sub_halves(I32 p, I32 q) { return {_mm_sub_epi16(p.a, q.a), _mm_sub_epi16(p.b, q.b)}; }
inline I32 equal_halves(I32 p, I32 q) {
  return {_mm_cmpeq_epi16(p.a, q.a), _mm_cmpeq_epi16(p.b, q.b)};
}
inline I32 equal32(I32 p, I32 q) { return {_mm_cmpeq_epi32(p.a, q.a), _mm_cmpeq_epi32(p.b, q.b)}; }
inline int pair_at(const std::int16_t* p) {
  int pair = 0;
  std::memcpy(&pair, p, sizeof pair);
  return pair;
}
inline __m128i four_pairs(const std::int16_t* base, __m128i index) {
  const auto low = static_cast<std::uint64_t>(_mm_cvtsi128_si64(index));
  const auto high = static_cast<std::uint64_t>(_mm_extract_epi64(index, 1));
  __m128i v = _mm_cvtsi32_si128(pair_at(base + static_cast<std::uint32_t>(low)));
  v = _mm_insert_epi32(v, pair_at(base + (low >> 32)), 1);
  v = _mm_insert_epi32(v, pair_at(base + static_cast<std::uint32_t>(high)), 2);
  return _mm_insert_epi32(v, pair_at(base + (high >> 32)), 3);
}
inline I32 pairs_at(const std::int16_t* base, I32 index) {
  return {four_pairs(base, index.a), four_pairs(base, index.b)};
}

inline I16 pack16(I32 p, I32 q) { return {_mm_packs_epi32(p.a, p.b), _mm_packs_epi32(q.a, q.b)}; }
inline I16 set16(std::int16_t a) { return {_mm_set1_epi16(a), _mm_set1_epi16(a)}; }
inline I16 load16(const std::int16_t* p) { return {load_vector(p), load_vector(p + 8)}; }
inline void store16(std::int16_t* p, I16 v) {
  store_vector(p, v.a);
  store_vector(p + 8, v.b);
}
inline I16 adds16(I16 p, I16 q) { return {_mm_adds_epi16(p.a, q.a), _mm_adds_epi16(p.b, q.b)}; }
inline I16 min16(I16 p, I16 q) { return {_mm_min_epi16(p.a, q.a), _mm_min_epi16(p.b, q.b)}; }
inline I16 max16(I16 p, I16 q) { return {_mm_max_epi16(p.a, q.a), _mm_max_epi16(p.b, q.b)}; }
inline I16 choose16(I16 mask, I16 p, I16 q) {
  return {_mm_blendv_epi8(p.a, q.a, mask.a), _mm_blendv_epi8(p.b, q.b, mask.b)};
}

inline U8 set8(std::uint8_t a) { return _mm_set1_epi8(static_cast<char>(a)); }
inline U8 load8(const std::uint8_t* p) { return load_vector(p); }
inline void store8(std::uint8_t* p, U8 v) { store_vector(p, v); }
inline U8 adds8(U8 p, U8 q) { return _mm_adds_epu8(p, q); }
inline U8 sub8(U8 p, U8 q) { return _mm_sub_epi8(p, q); }
inline U8 add8(U8 p, U8 q) { return _mm_add_epi8(p, q); }
inline U8 max8(U8 p, U8 q) { return _mm_max_epu8(p, q); }
inline U8 and8(U8 p, U8 q) { return _mm_and_si128(p, q); }
inline U8 xor8(U8 p, U8 q) { return _mm_xor_si128(p, q); }
inline U8 equal8(U8 p, U8 q) { return _mm_cmpeq_epi8(p, q); }
inline U8 look_up(U8 table, U8 index) { return _mm_shuffle_epi8(table, index); }
inline I32 widen_low(U8 v) {
  return {_mm_cvtepu8_epi32(v), _mm_cvtepu8_epi32(_mm_srli_si128(v, 4))};
}
inline I32 widen_high(U8 v) { return widen_low(_mm_srli_si128(v, 8)); }
inline I16 widen_signed(U8 v) {
  return {_mm_cvtepi8_epi16(v), _mm_cvtepi8_epi16(_mm_srli_si128(v, 8))};
}
inline I16 add16(I16 p, I16 q) { return {_mm_add_epi16(p.a, q.a), _mm_add_epi16(p.b, q.b)}; }
inline I16 mul16(I16 p, I16 q) { return {_mm_mullo_epi16(p.a, q.a), _mm_mullo_epi16(p.b, q.b)}; }
inline I16 quarter16(I16 v) { return {_mm_srai_epi16(v.a, 2), _mm_srai_epi16(v.b, 2)}; }
inline U8 narrow_mask(I32 p, I32 q) {
  const I16 packed = pack16(p, q);
  return _mm_packs_epi16(packed.a, packed.b);
}

}  // namespace
}  // namespace watersky::detail
