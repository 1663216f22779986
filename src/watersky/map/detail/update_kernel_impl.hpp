// SPDX-License-Identifier: MIT
#pragma once
/// The source of every set of kernels: include a simd_….hpp first, then this, in a file compiled
/// for that instruction set. Everything here is in an unnamed namespace, and nothing of the
/// standard library is used that has code of its own.
#include "watersky/map/detail/update_kernel.hpp"

namespace watersky::detail {
namespace {

/// Positions of 16 cells in a row, and how they change from row to row.
struct Positions {
  I32 u[2], du[2], v[2], dv[2];
  I32 ddu, ddv;

  Positions(const CellPatch& at, int first_column) {
    alignas(32) std::int32_t columns[16];
    for (int i = 0; i < 16; ++i) columns[i] = first_column + i;
    for (int h = 0; h < 2; ++h) {
      const I32 i = load32(columns + 8 * h), ii = mul32(i, i);
      const auto place = [&](std::int32_t p, std::int32_t pi, std::int32_t pii) {
        return add32(add32(set32(p), mul32(set32(pi), i)), mul32(set32(pii), ii));
      };
      const auto change = [&](std::int32_t pj, std::int32_t pij, std::int32_t pjj) {
        return add32(add32(set32(pj), set32(pjj)), mul32(set32(pij), i));
      };
      u[h] = place(at.u, at.ui, at.uii);
      v[h] = place(at.v, at.vi, at.vii);
      du[h] = change(at.uj, at.uij, at.ujj);
      dv[h] = change(at.vj, at.vij, at.vjj);
    }
    ddu = add32(set32(at.ujj), set32(at.ujj));
    ddv = add32(set32(at.vjj), set32(at.vjj));
  }
  void next_row() {
    for (int h = 0; h < 2; ++h) {
      u[h] = add32(u[h], du[h]);
      v[h] = add32(v[h], dv[h]);
      du[h] = add32(du[h], ddu);
      dv[h] = add32(dv[h], ddv);
    }
  }
};

struct Reading {
  I32 sum, top, bottom;
};

/// Four pixels around each position, by weights of 1/128 along each axis.
inline Reading read(const std::int16_t* image, int stride, I32 stride_and_one, I32 u, I32 v) {
  // Column and row as two halves of one number, which a product with (1, stride) sums.
  const I32 index =
      dot16(low_high(shr32<kPositionBits>(u), shr32<kPositionBits - 16>(v)), stride_and_one);
  const I32 top = pairs_at(image, index), bottom = pairs_at(image + stride, index);
  const I32 part = set32(127);
  const I32 fu = and32(shr32<kPositionBits - 7>(u), part);
  const I32 fv = and32(shr32<kPositionBits - 7>(v), part);
  const I32 along = add32(sub32(shl32<16>(fu), fu), set32(128));  // 128 - fu, fu
  const I32 lower = mul_halves(along, or32(fv, shl32<16>(fv)));
  const I32 upper = sub_halves(shl7_halves(along), lower);
  return {add32(dot16(top, upper), dot16(bottom, lower)), top, bottom};
}

inline I32 pack_stride(int stride) { return set32((stride << 16) | 1); }

/// One look at cells: evidence, looks and the place of the time. Everything that stays the same is
/// held here by value: what is written to the cells could else have changed it.
class Look {
 public:
  explicit Look(const CellState& s)
      : evidence_(s.evidence),
        looks_(s.looks),
        seen_(s.seen),
        lowest_(set16(s.lowest)),
        highest_(set16(s.highest)),
        place_(set8(s.place)),
        turn_(set8(s.turn)),
        shift_(s.shift) {}

  template <bool kMasked>
  void add(int cell, const I32& low, const I32& high, U8 mask) const {
    const U8 looks = load8(looks_ + cell);
    const U8 dither =
        xor8(look_up(bits_reversed_, and8(looks, set8(15))), and8(equal8(looks, set8(255)), turn_));
    const auto rounded = [&](I32 sum, I32 d) {
      const I32 middle = add32(add32(d, d), set32(1));  // the middle of a sixteenth
      return sra32_by(add32(sum, shl32_by(middle, shift_ - 5)), shift_);
    };
    const I16 look = pack16(rounded(low, widen_low(dither)), rounded(high, widen_high(dither)));
    const I16 before = load16(evidence_ + cell);
    I16 after = max16(min16(adds16(before, look), highest_), lowest_);
    U8 one = set8(1), place = place_;
    if constexpr (kMasked) {
      after = choose16(widen_signed(mask), before, after);
      one = and8(one, mask);
      place = and8(place, mask);
    }
    store16(evidence_ + cell, after);
    store8(looks_ + cell, adds8(looks, one));
    store8(seen_ + cell, max8(load8(seen_ + cell), place));
  }

 private:
  alignas(16) static constexpr std::uint8_t kBitsReversed[16] = {0, 8, 4, 12, 2, 10, 6, 14,
                                                                 1, 9, 5, 13, 3, 11, 7, 15};
  std::int16_t* evidence_;
  std::uint8_t *looks_, *seen_;
  I16 lowest_, highest_;
  U8 place_, turn_, bits_reversed_ = load8(kBitsReversed);
  int shift_;
};

inline I32 within(I32 x, I32 highest) { return min32(max32(x, set32(0)), highest); }

template <bool kMasked, bool kMany>
void add_cells(const CellJob& job, const CellState& state, const std::uint8_t* mask) {
  const Look look(state);
  const std::int16_t* const image = job.image;
  const int stride = job.stride, columns = job.columns, rows = job.rows, steps = job.steps;
  const I32 stride_and_one = pack_stride(stride);
  const I32 highest_u = set32(job.highest_u), highest_v = set32(job.highest_v);
  I32 step_u[CellJob::kMostSteps], step_v[CellJob::kMostSteps];
  for (int s = 0; kMany && s < steps; ++s) {
    step_u[s] = set32(job.step_u[s]);
    step_v[s] = set32(job.step_v[s]);
  }
  for (int column = 0; column < columns; column += 16) {
    Positions p(job.at, column);
    for (int row = 0; row < rows; ++row, p.next_row()) {
      const int cell = row * kCellStride + column;
      I32 sum[2];
      for (int h = 0; h < 2; ++h) {
        if constexpr (kMasked)
          sum[h] = read(image, stride, stride_and_one, within(p.u[h], highest_u),
                        within(p.v[h], highest_v))
                       .sum;
        else
          sum[h] = read(image, stride, stride_and_one, p.u[h], p.v[h]).sum;
        for (int s = 0; kMany && s < steps; ++s)
          sum[h] = add32(sum[h], read(image, stride, stride_and_one, add32(p.u[h], step_u[s]),
                                      add32(p.v[h], step_v[s]))
                                     .sum);
      }
      look.add<kMasked>(cell, sum[0], sum[1], kMasked ? load8(mask + cell) : set8(255));
    }
  }
}

void add(const CellJob& job, const CellState& state) {
  if (job.steps == 0) return add_cells<false, false>(job, state, nullptr);
  add_cells<false, true>(job, state, nullptr);
}
void add_masked(const CellJob& job, const CellState& state, const std::uint8_t* mask) {
  add_cells<true, false>(job, state, mask);
}

void sample(const CellJob& job, const std::uint8_t* mask, std::int32_t* sums,
            std::int32_t* counts) {
  const I32 stride = pack_stride(job.stride), none = set32(0);
  const I32 highest_u = set32(job.highest_u), highest_v = set32(job.highest_v);
  const I32 unknown = set32(static_cast<std::int32_t>(0x80008000U));
  for (int column = 0; column < job.columns; column += 16) {
    Positions p(job.at, column);
    for (int row = 0; row < job.rows; ++row, p.next_row()) {
      const int cell = row * kCellStride + column;
      const U8 wanted = load8(mask + cell);
      for (int h = 0; h < 2; ++h) {
        const Reading r = read(job.image, job.stride, stride, within(p.u[h], highest_u),
                               within(p.v[h], highest_v));
        const I32 bad = or32(equal_halves(r.top, unknown), equal_halves(r.bottom, unknown));
        const I32 known = and32(equal32(bad, none),
                                greater32(h == 0 ? widen_low(wanted) : widen_high(wanted), none));
        std::int32_t* s = sums + cell + 8 * h;
        std::int32_t* n = counts + cell + 8 * h;
        const I32 sum = sra32_by(add32(r.sum, set32(1 << (kSumBits - kSampleBits - 1))),
                                 kSumBits - kSampleBits);
        store32(s, add32(load32(s), and32(known, sum)));
        store32(n, sub32(load32(n), known));
      }
    }
  }
}

void add_sums(int columns, int rows, const std::int32_t* sums, const CellState& state,
              const std::uint8_t* mask) {
  const Look look(state);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; column += 16) {
      const int cell = row * kCellStride + column;
      look.add<true>(cell, load32(sums + cell), load32(sums + cell + 8), load8(mask + cell));
    }
}

void mark(const CellJob& job, const Window& surely, const Window& perhaps, std::uint8_t* sure,
          std::uint8_t* possible) {
  const I32 none = set32(0);
  const auto outside = [](I32 x, std::int32_t low, std::int32_t high) {
    return or32(greater32(set32(low), x), greater32(x, set32(high)));
  };
  for (int column = 0; column < job.columns; column += 16) {
    Positions p(job.at, column);
    for (int row = 0; row < job.rows; ++row, p.next_row()) {
      const auto in = [&](const Window& w, int h) {
        return equal32(or32(outside(p.u[h], w.low_u, w.high_u), outside(p.v[h], w.low_v, w.high_v)),
                       none);
      };
      const int cell = row * kCellStride + column;
      store8(sure + cell, narrow_mask(in(surely, 0), in(surely, 1)));
      store8(possible + cell, narrow_mask(in(perhaps, 0), in(perhaps, 1)));
    }
  }
}

// --- Pixels ---------------------------------------------------------------------------------

/// A level above the threshold is not below the next; 255 where it is.
struct Above {
  explicit Above(std::uint8_t threshold)
      : possible(set8(threshold == 255 ? 0 : 255)),
        next(set8(static_cast<std::uint8_t>(threshold + 1))) {}
  U8 operator()(const std::uint8_t* levels) const {
    const U8 l = load8(levels);
    return and8(equal8(max8(l, next), l), possible);
  }
  U8 possible, next;
};

void threshold(const std::uint8_t* levels, int count, std::uint8_t threshold, std::int16_t below,
               std::int16_t above, std::int16_t* out) {
  const Above is_above(threshold);
  const I16 no = set16(below), yes = set16(above);
  int i = 0;
  for (; i + 16 <= count; i += 16)
    store16(out + i, choose16(widen_signed(is_above(levels + i)), no, yes));
  for (; i < count; ++i) out[i] = levels[i] > threshold ? above : below;
}

void threshold_2x2(const std::uint8_t* levels, const std::uint8_t* next_row, int count,
                   std::uint8_t threshold, std::int16_t below, std::int16_t above,
                   std::int16_t* out) {
  // 4 below + n (above - below) fits into 16 bits, whatever its parts overflow by.
  const auto four = static_cast<std::int16_t>(4 * below + 2);
  const auto step = static_cast<std::int16_t>(above - below);
  const Above is_above(threshold);
  const I16 from = set16(four), down = set16(static_cast<std::int16_t>(-step));
  int i = 0;
  for (; i + 16 <= count; i += 16) {
    const U8 minus_n = add8(add8(is_above(levels + i), is_above(levels + i + 1)),
                            add8(is_above(next_row + i), is_above(next_row + i + 1)));
    store16(out + i, quarter16(add16(from, mul16(widen_signed(minus_n), down))));
  }
  for (; i < count; ++i) {
    const int n = (levels[i] > threshold) + (levels[i + 1] > threshold) +
                  (next_row[i] > threshold) + (next_row[i + 1] > threshold);
    out[i] = static_cast<std::int16_t>(static_cast<std::int16_t>(four + n * step) >> 2);
  }
}

void count_above(const std::uint8_t* levels, int stride, int rows, int count,
                 std::uint8_t threshold, std::uint8_t* counts) {
  const Above is_above(threshold);
  int i = 0;
  for (; i + 16 <= count; i += 16) {
    const std::uint8_t* row = levels + i;
    U8 n = set8(0);
    for (int r = 0; r < rows; ++r, row += stride) n = sub8(n, is_above(row));
    store8(counts + i, n);
  }
  for (; i < count; ++i) {
    const std::uint8_t* row = levels + i;
    int n = 0;
    for (int r = 0; r < rows; ++r, row += stride) n += *row > threshold;
    counts[i] = static_cast<std::uint8_t>(n);
  }
}

template <int K>
void sum_groups(const std::uint8_t* counts, int count, const std::int16_t* table,
                std::int16_t* out) {
  for (int i = 0; i < count; ++i) {
    int sum = 0;
    for (int k = 0; k < K; ++k) sum += counts[i * K + k];
    out[i] = table[sum];
  }
}

void sum_counts(const std::uint8_t* counts, int k, int count, const std::int16_t* table,
                std::int16_t* out) {
  if (k == 2) return sum_groups<2>(counts, count, table, out);
  if (k == 3) return sum_groups<3>(counts, count, table, out);
  if (k == 4) return sum_groups<4>(counts, count, table, out);
  for (int i = 0; i < count; ++i) {
    int sum = 0;
    for (int j = 0; j < k; ++j) sum += counts[i * k + j];
    out[i] = table[sum];
  }
}

template <int K>
void sum_table_groups(const std::uint8_t* levels, int stride, int k, int count,
                      const std::int16_t* table, std::int32_t* sums) {
  const int n = K > 0 ? K : k;
  for (int i = 0; i < count; ++i) {
    const std::uint8_t* row = levels + i * n;
    std::int32_t sum = 0;
    for (int r = 0; r < n; ++r, row += stride)
      for (int c = 0; c < n; ++c) sum += table[row[c]];
    sums[i] = sum;
  }
}

void sum_table(const std::uint8_t* levels, int stride, int k, int count, const std::int16_t* table,
               std::int32_t* sums) {
  if (k == 2) return sum_table_groups<2>(levels, stride, k, count, table, sums);
  if (k == 3) return sum_table_groups<3>(levels, stride, k, count, table, sums);
  if (k == 4) return sum_table_groups<4>(levels, stride, k, count, table, sums);
  sum_table_groups<0>(levels, stride, k, count, table, sums);
}

void mean_2x2(const std::int16_t* values, const std::int16_t* next_row, int count,
              std::int16_t* out) {
  for (int i = 0; i < count; ++i)
    out[i] = static_cast<std::int16_t>(
        (values[i] + values[i + 1] + next_row[i] + next_row[i + 1] + 2) >> 2);
}

constexpr UpdateKernels kKernels{kInstructionSet, add,        add_masked, sample,
                                 add_sums,        mark,       threshold,  threshold_2x2,
                                 count_above,     sum_counts, sum_table,  mean_2x2};

}  // namespace
}  // namespace watersky::detail
