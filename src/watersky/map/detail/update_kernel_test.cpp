// SPDX-License-Identifier: MIT
#include "watersky/map/detail/update_kernel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

namespace watersky::detail {
namespace {

/// What a kernel may read and write, with something in it.
struct Cells {
  std::array<std::int16_t, 1024> evidence{};
  std::array<std::uint8_t, 1024> looks{}, seen{}, mask{}, possible{};
  std::array<std::int32_t, 1024> sums{}, counts{};
  bool operator==(const Cells&) const = default;
};

class UpdateKernel : public testing::Test {
 protected:
  static constexpr int kWidth = 240, kHeight = 200;

  UpdateKernel() : image_(static_cast<std::size_t>(kWidth * kHeight)) {
    for (auto& p : image_) p = static_cast<std::int16_t>(pick(-32767, 32767));
    for (int i = 0; i < 40; ++i)
      image_[static_cast<std::size_t>(pick(0, kWidth * kHeight - 1))] = kUnknownPixel;
  }
  int pick(int low, int high) { return std::uniform_int_distribution<int>(low, high)(rng_); }

  Cells random_cells() {
    Cells c;
    for (std::size_t i = 0; i < 1024; ++i) {
      c.evidence[i] = static_cast<std::int16_t>(pick(-32767, 32767));
      c.looks[i] = static_cast<std::uint8_t>(pick(0, 3) == 0 ? 255 : pick(0, 254));
      c.seen[i] = static_cast<std::uint8_t>(pick(0, 255));
      c.mask[i] = pick(0, 1) == 0 ? 0 : 255;
      c.sums[i] = pick(-(1 << 28), 1 << 28);
      c.counts[i] = pick(0, 9);
    }
    return c;
  }
  /// Positions that stay in the image when `stays`; else they leave it on all sides.
  CellJob random_job(bool stays) {
    CellJob job{};
    const auto one = 1 << kPositionBits;
    const int step = stays ? one / 2 : 6 * one;
    job.at = {40 * one + pick(0, one), pick(0, step),         pick(0, step),
              pick(0, 2000),           pick(0, 2000),         pick(-2000, 2000),
              30 * one + pick(0, one), pick(-step / 4, step), pick(0, step),
              pick(-2000, 2000),       pick(-2000, 2000),     pick(0, 2000)};
    job.columns = job.rows = pick(0, 1) == 0 ? 16 : 32;
    job.image = image_.data();
    job.stride = kWidth;
    job.highest_u = ((kWidth - 1) << kPositionBits) - 1;
    job.steps = stays ? std::array{0, 1, 3}[static_cast<std::size_t>(pick(0, 2))] : 0;
    for (int s = 0; s < job.steps; ++s) {
      job.step_u[s] = pick(-5 * one, 5 * one);
      job.step_v[s] = pick(-5 * one, 5 * one);
    }
    job.highest_v = ((kHeight - 1) << kPositionBits) - 1;
    return job;
  }
  CellState state_of(Cells& c) {
    return {c.evidence.data(), c.looks.data(), c.seen.data(), lowest_,
            highest_,          shift_,         place_,        turn_};
  }
  void new_state() {
    lowest_ = static_cast<std::int16_t>(pick(-32767, 0));
    highest_ = static_cast<std::int16_t>(pick(0, 32767));
    shift_ = pick(14, 18);
    place_ = static_cast<std::uint8_t>(pick(0, 255));
    turn_ = static_cast<std::uint8_t>(pick(0, 15));
  }

  /// All kernels do to a copy of the same cells what `use` says, and all copies stay equal.
  template <class Use>
  void expect_same(const Use& use) {
    const Cells before = random_cells();
    new_state();
    std::vector<Cells> after;
    for (const UpdateKernels* const* k = all_update_kernels(); *k != nullptr; ++k) {
      after.push_back(before);
      use(**k, after.back());
      ASSERT_TRUE(after.back() == after.front()) << (*k)->name;
    }
  }

  std::mt19937 rng_{7};
  std::vector<std::int16_t> image_;
  std::int16_t lowest_ = 0, highest_ = 0;
  int shift_ = 14;
  std::uint8_t place_ = 0, turn_ = 0;
};

TEST_F(UpdateKernel, EveryInstructionSetGivesTheSameBits) {
  for (int i = 0; i < 2000; ++i) {
    const CellJob inside = random_job(true), anywhere = random_job(false);
    expect_same([&](const UpdateKernels& k, Cells& c) { k.add(inside, state_of(c)); });
    expect_same([&](const UpdateKernels& k, Cells& c) {
      k.add_masked(anywhere, state_of(c), c.mask.data());
    });
    expect_same([&](const UpdateKernels& k, Cells& c) {
      k.sample(anywhere, c.mask.data(), c.sums.data(), c.counts.data());
    });
    expect_same([&](const UpdateKernels& k, Cells& c) {
      k.add_sums(anywhere.columns, anywhere.rows, c.sums.data(), state_of(c), c.mask.data());
    });
    const Window w{pick(0, 1 << 25), pick(1 << 25, 1 << 28), pick(0, 1 << 25),
                   pick(1 << 25, 1 << 28)};
    const Window wider{w.low_u - 99, w.high_u + 99, w.low_v - 99, w.high_v + 99};
    expect_same([&](const UpdateKernels& k, Cells& c) {
      k.mark(anywhere, w, wider, c.mask.data(), c.possible.data());
    });
  }
}

TEST_F(UpdateKernel, EveryInstructionSetReadsPixelsAlike) {
  std::vector<std::uint8_t> levels(2000);
  for (auto& l : levels) l = static_cast<std::uint8_t>(pick(0, 255));
  std::vector<std::int16_t> table(900 + 1);
  for (auto& t : table) t = static_cast<std::int16_t>(pick(-8191, 8191));
  for (int i = 0; i < 400; ++i) {
    const int count = pick(1, 300), k = pick(2, 7);
    const auto t = static_cast<std::uint8_t>(pick(0, 255));
    const auto below = static_cast<std::int16_t>(pick(-8191, 8191));
    const auto above = static_cast<std::int16_t>(pick(-8191, 8191));
    const std::uint8_t* row = levels.data() + pick(0, 300);
    const std::uint8_t* next = levels.data() + pick(600, 900);
    std::vector<std::vector<std::int16_t>> all;
    for (const UpdateKernels* const* kernels = all_update_kernels(); *kernels != nullptr;
         ++kernels) {
      const UpdateKernels& f = **kernels;
      std::vector<std::int16_t> out(1600, 0);
      f.threshold(row, count, t, below, above, out.data());
      f.threshold_2x2(row, next, count, t, below, above, out.data() + 320);
      std::vector<std::uint8_t> counts(2100, 0);
      f.count_above(row, 7, k, std::min(count * k, 1000), t, counts.data());
      f.sum_counts(counts.data(), k, count, table.data(), out.data() + 640);
      std::vector<std::int32_t> sums(300);
      f.sum_table(row, 11, 2 + i % 5, std::min(count, 150), image_.data(), sums.data());
      for (std::size_t c = 0; c < 150; ++c)
        out[1280 + c] = static_cast<std::int16_t>(sums[c] % 30000);
      f.mean_2x2(image_.data() + 5, image_.data() + 777, count, out.data() + 960);
      all.push_back(out);
      ASSERT_EQ(all.front(), out) << f.name;
    }
    // What they are to be equal to.
    for (int c = 0; c < count; ++c) {
      const auto value = [&](const std::uint8_t* p) { return *p > t ? above : below; };
      ASSERT_EQ(all[0][static_cast<std::size_t>(c)], value(row + c));
      const int sum = value(row + c) + value(row + c + 1) + value(next + c) + value(next + c + 1);
      ASSERT_EQ(all[0][static_cast<std::size_t>(320 + c)], (sum + 2) >> 2);
    }
  }
}

TEST_F(UpdateKernel, ReadsBilinearlyToTheWeightsOf128ths) {
  std::vector<std::uint8_t> mask(1024, 255);
  const UpdateKernels& k = update_kernels();
  for (auto& p : image_) p = static_cast<std::int16_t>(p == kUnknownPixel ? 0 : p / 16);
  for (int i = 0; i < 200; ++i) {
    const CellJob job = random_job(true);
    std::array<std::int32_t, 1024> sums{}, counts{};
    k.sample(job, mask.data(), sums.data(), counts.data());
    for (int row = 0; row < job.rows; ++row)
      for (int column = 0; column < job.columns; ++column) {
        const auto cell = static_cast<std::size_t>(row * kCellStride + column);
        const auto at = [&](auto c, auto ci, auto cj, auto cii, auto cij, auto cjj) {
          return (static_cast<double>(c) + 1.0 * ci * column + 1.0 * cj * row +
                  1.0 * cii * column * column + 1.0 * cij * column * row + 1.0 * cjj * row * row) /
                 (1 << kPositionBits);
        };
        const CellPatch& p = job.at;
        const double u = at(p.u, p.ui, p.uj, p.uii, p.uij, p.ujj);
        const double v = at(p.v, p.vi, p.vj, p.vii, p.vij, p.vjj);
        const int iu = static_cast<int>(u), iv = static_cast<int>(v);
        const double fu = u - iu, fv = v - iv;
        const std::int16_t* q = image_.data() + iv * kWidth + iu;
        const double exact = (1 - fv) * ((1 - fu) * q[0] + fu * q[1]) +
                             fv * ((1 - fu) * q[kWidth] + fu * q[kWidth + 1]);
        const double range = std::max({q[0], q[1], q[kWidth], q[kWidth + 1]}) -
                             std::min({q[0], q[1], q[kWidth], q[kWidth + 1]});
        ASSERT_EQ(counts[cell], 1);
        ASSERT_NEAR(sums[cell] / 64.0, exact, 2 * range / 128 + 0.02);
      }
  }
}

// The dither takes sixteen values in sixteen looks: what a cell is told sixteen times it knows
// exactly, to a sixteenth of what it can hold a look.
TEST_F(UpdateKernel, SixteenLooksAddWithoutRounding) {
  const int shift = 4 + kSampleBits;
  for (int sixteenths = -50; sixteenths <= 50; ++sixteenths) {
    Cells c{};
    c.mask.fill(255);
    c.sums.fill(sixteenths << (shift - 4));
    for (int look = 0; look < 16; ++look)
      update_kernels().add_sums(
          32, 32, c.sums.data(),
          {c.evidence.data(), c.looks.data(), c.seen.data(), -32767, 32767, shift, 0, 0},
          c.mask.data());
    EXPECT_EQ(c.evidence[0], sixteenths);
    EXPECT_EQ(c.evidence[1023], sixteenths);
  }
}

}  // namespace
}  // namespace watersky::detail
