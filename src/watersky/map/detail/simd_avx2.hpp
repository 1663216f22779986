// SPDX-License-Identifier: MIT
#pragma once
/// The lanes of simd_scalar.hpp, which says what each does, in AVX2.
#include <immintrin.h>

#include <cstdint>

namespace watersky::detail {
namespace {

constexpr const char* kInstructionSet = "AVX2";

using I32 = __m256i;
using U8 = __m128i;
struct I16 {
  __m256i x;
};

inline I32 set32(std::int32_t a) { return _mm256_set1_epi32(a); }
inline I32 load32(const std::int32_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
inline void store32(std::int32_t* p, I32 a) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a);
}
inline I32 add32(I32 a, I32 b) { return _mm256_add_epi32(a, b); }
inline I32 sub32(I32 a, I32 b) { return _mm256_sub_epi32(a, b); }
inline I32 mul32(I32 a, I32 b) { return _mm256_mullo_epi32(a, b); }
inline I32 and32(I32 a, I32 b) { return _mm256_and_si256(a, b); }
inline I32 or32(I32 a, I32 b) { return _mm256_or_si256(a, b); }
template <int N>
inline I32 shl32(I32 a) {
  return _mm256_slli_epi32(a, N);
}
template <int N>
inline I32 shr32(I32 a) {
  return _mm256_srli_epi32(a, N);
}
inline I32 shl32_by(I32 a, int n) { return _mm256_sll_epi32(a, _mm_cvtsi32_si128(n)); }
inline I32 sra32_by(I32 a, int n) { return _mm256_sra_epi32(a, _mm_cvtsi32_si128(n)); }
inline I32 min32(I32 a, I32 b) { return _mm256_min_epi32(a, b); }
inline I32 max32(I32 a, I32 b) { return _mm256_max_epi32(a, b); }
inline I32 greater32(I32 a, I32 b) { return _mm256_cmpgt_epi32(a, b); }
inline I32 low_high(I32 a, I32 b) { return _mm256_blend_epi16(a, b, 0xAA); }
inline I32 dot16(I32 a, I32 b) { return _mm256_madd_epi16(a, b); }
inline I32 mul_halves(I32 a, I32 b) { return _mm256_mullo_epi16(a, b); }
inline I32 shl7_halves(I32 a) { return _mm256_slli_epi16(a, 7); }
inline I32 sub_halves(I32 a, I32 b) { return _mm256_sub_epi16(a, b); }
inline I32 equal_halves(I32 a, I32 b) { return _mm256_cmpeq_epi16(a, b); }
inline I32 equal32(I32 a, I32 b) { return _mm256_cmpeq_epi32(a, b); }
inline I32 pairs_at(const std::int16_t* base, I32 index) {
  return _mm256_i32gather_epi32(reinterpret_cast<const int*>(base), index, 2);
}

inline I16 pack16(I32 a, I32 b) {
  return {_mm256_permute4x64_epi64(_mm256_packs_epi32(a, b), 0xD8)};
}
inline I16 set16(std::int16_t a) { return {_mm256_set1_epi16(a)}; }
inline I16 load16(const std::int16_t* p) {
  return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))};
}
inline void store16(std::int16_t* p, I16 a) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.x);
}
inline I16 adds16(I16 a, I16 b) { return {_mm256_adds_epi16(a.x, b.x)}; }
inline I16 min16(I16 a, I16 b) { return {_mm256_min_epi16(a.x, b.x)}; }
inline I16 max16(I16 a, I16 b) { return {_mm256_max_epi16(a.x, b.x)}; }
inline I16 choose16(I16 mask, I16 a, I16 b) { return {_mm256_blendv_epi8(a.x, b.x, mask.x)}; }

inline U8 set8(std::uint8_t a) { return _mm_set1_epi8(static_cast<char>(a)); }
inline U8 load8(const std::uint8_t* p) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
}
inline void store8(std::uint8_t* p, U8 a) { _mm_storeu_si128(reinterpret_cast<__m128i*>(p), a); }
inline U8 adds8(U8 a, U8 b) { return _mm_adds_epu8(a, b); }
inline U8 sub8(U8 a, U8 b) { return _mm_sub_epi8(a, b); }
inline U8 add8(U8 a, U8 b) { return _mm_add_epi8(a, b); }
inline U8 max8(U8 a, U8 b) { return _mm_max_epu8(a, b); }
inline U8 and8(U8 a, U8 b) { return _mm_and_si128(a, b); }
inline U8 xor8(U8 a, U8 b) { return _mm_xor_si128(a, b); }
inline U8 equal8(U8 a, U8 b) { return _mm_cmpeq_epi8(a, b); }
inline U8 look_up(U8 table, U8 index) { return _mm_shuffle_epi8(table, index); }
inline I32 widen_low(U8 a) { return _mm256_cvtepu8_epi32(a); }
inline I32 widen_high(U8 a) { return _mm256_cvtepu8_epi32(_mm_srli_si128(a, 8)); }
inline I16 widen_signed(U8 a) { return {_mm256_cvtepi8_epi16(a)}; }
inline I16 add16(I16 a, I16 b) { return {_mm256_add_epi16(a.x, b.x)}; }
inline I16 mul16(I16 a, I16 b) { return {_mm256_mullo_epi16(a.x, b.x)}; }
inline I16 quarter16(I16 a) { return {_mm256_srai_epi16(a.x, 2)}; }
inline U8 narrow_mask(I32 a, I32 b) {
  const __m256i packed = pack16(a, b).x;
  return _mm_packs_epi16(_mm256_castsi256_si128(packed), _mm256_extracti128_si256(packed, 1));
}

}  // namespace
}  // namespace watersky::detail
