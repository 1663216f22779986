// SPDX-License-Identifier: MIT
#include "watersky/map/detail/footprint_update.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace watersky::detail {

namespace {

static_assert(kCellStride == MapTile::kBlockCells);

constexpr double kOne = 1 << kPositionBits;
/// Rounding of a patch's coefficients to whole numbers moves a cell by less than this.
constexpr double kRounding_px = 0.004;

/// To whole numbers without a call into the library, which is half of what a block costs.
std::int32_t nearest(double x) { return static_cast<std::int32_t>(x < 0 ? x - 0.5 : x + 0.5); }
int whole_below(double x) {
  const auto towards_zero = static_cast<int>(x);
  return x < towards_zero ? towards_zero - 1 : towards_zero;
}

std::int32_t fixed(double pixels) { return nearest(pixels * kOne); }
/// Held where positions are.
std::int32_t bound(double pixels) { return fixed(std::clamp(pixels, -2040.0, 2040.0)); }

/// A patch moved by a part of a cell.
std::array<double, 6> moved(const std::array<double, 6>& c, double x, double y) {
  return {c[0] + x * (c[1] + x * c[3] + y * c[4]) + y * (c[2] + y * c[5]),
          c[1] + 2 * x * c[3] + y * c[4],
          c[2] + 2 * y * c[5] + x * c[4],
          c[3],
          c[4],
          c[5]};
}

/// The kernels' bilinear reading, of one position: kSampleBits more bits than a pixel; false when
/// one of the four is not known.
bool read_one(const EvidenceLevels::Level& level, double u, double v, std::int32_t& sum) {
  const auto iu = whole_below(u), iv = whole_below(v);
  const std::int16_t* top = level.at(iu, iv);
  const std::int16_t* bottom = top + level.stride;
  const auto fu = static_cast<std::int32_t>((u - iu) * 128),
             fv = static_cast<std::int32_t>((v - iv) * 128);
  for (const std::int16_t p : {top[0], top[1], bottom[0], bottom[1]})
    if (p == kUnknownPixel) return false;
  const std::int32_t all = (128 - fv) * ((128 - fu) * top[0] + fu * top[1]) +
                           fv * ((128 - fu) * bottom[0] + fu * bottom[1]);
  sum = (all + (1 << (kSumBits - kSampleBits - 1))) >> (kSumBits - kSampleBits);
  return true;
}

/// Dither for cells whose looks no longer count, another for every frame.
std::uint8_t turn_of(Time time) {
  const auto t = static_cast<std::uint64_t>(time.time_since_epoch().count());
  return static_cast<std::uint8_t>((t * 0x9E3779B97F4A7C15U) >> 60U);
}

std::size_t count_of(const std::uint8_t* mask, int cells) {
  std::size_t count = 0;
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells; column += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, mask + row * kCellStride + column, sizeof eight);
      // One bit a byte, all added up in the highest.
      count += (eight & 0x0101010101010101U) * 0x0101010101010101U >> 56U;
    }
  return count;
}

}  // namespace

FootprintUpdate::Placed FootprintUpdate::place(const FootprintPart& part,
                                               EvidenceLevels::Level& level, double dx, double dy) {
  const double k = level.averaging.shrink;
  // The pixels that the part may need, of those that there are.
  const auto pixel = [&](double full, int end) {
    return std::clamp(whole_below(level.scaled(full) - 1.0 / 64), -1, end - 1);
  };
  const int u0 = pixel(part.low.x(), level.width), v0 = pixel(part.low.y(), level.height);
  const int u1 = std::min(level.width, pixel(part.high.x(), level.width) + 2);
  const int v1 = std::min(level.height, pixel(part.high.y(), level.height) + 2);
  Placed placed;
  placed.unknown = levels_.make(level, u0, v0, u1, v1);

  CellJob& job = placed.job;
  job.columns = job.rows = part.cells;
  job.image = level.at(u0, v0);
  job.stride = level.stride;
  const auto whole = [&](const std::array<double, 6>& full, int origin) {
    std::array<double, 6> c = moved(full, dx, dy);
    c[0] = level.scaled(c[0]) - origin;
    for (std::size_t i = 1; i < c.size(); ++i) c[i] /= k;
    std::array<std::int32_t, 6> out{};
    for (std::size_t i = 0; i < c.size(); ++i) out[i] = fixed(c[i]);
    return out;
  };
  const auto u = whole(part.patch.u, u0), v = whole(part.patch.v, v0);
  job.at = {u[0], u[1], u[2], u[3], u[4], u[5], v[0], v[1], v[2], v[3], v[4], v[5]};
  // The last position whose right and lower neighbours are still made.
  job.highest_u = ((u1 - u0) << kPositionBits) - 1;
  job.highest_v = ((v1 - v0) << kPositionBits) - 1;

  const double width = level.scaled(levels_.width_px() - 0.5) - u0;
  const double height = level.scaled(levels_.height_px() - 0.5) - v0;
  const double first_u = level.scaled(-0.5) - u0, first_v = level.scaled(-0.5) - v0;
  const double slack = Footprint::kMostError_px + kRounding_px;
  placed.surely = {bound(first_u + slack), bound(width - slack), bound(first_v + slack),
                   bound(height - slack)};
  placed.perhaps = {bound(first_u - slack), bound(width + slack), bound(first_v - slack),
                    bound(height + slack)};
  return placed;
}

/// The samples of a cell after the first as steps from there: those of the patch's middle, which
/// is where they are on the mean over a block, and exact for the mean of samples that lie opposite.
void FootprintUpdate::add_steps(const FootprintPart& part, double shrink, CellJob& job) {
  const double h = 0.5 * part.cells;
  const auto step = [&](const std::array<double, 6>& c, double dx, double dy) {
    return fixed((dx * (c[1] + h * (2 * c[3] + c[4])) + dy * (c[2] + h * (2 * c[5] + c[4]))) /
                 shrink);
  };
  for (int k = 1; k < part.samples_x * part.samples_y; ++k) {
    const double dx = static_cast<double>(k % part.samples_x) / part.samples_x;
    const double dy = static_cast<double>(k / part.samples_x) / part.samples_y;
    job.step_u[job.steps] = step(part.patch.u, dx, dy);
    job.step_v[job.steps] = step(part.patch.v, dx, dy);
    ++job.steps;
  }
}

/// Cells in the image by their patch; those nearer to its edge than a patch may err, and those that
/// the grazing limit may hide, by exact positions.
void FootprintUpdate::mark_seen(const Footprint& footprint, const FootprintPart& part,
                                const Placed& placed, double dx, double dy) {
  if (part.inside) {
    mask_.fill(255);
  } else {
    kernels_.mark(placed.job, placed.surely, placed.perhaps, mask_.data(), possible_.data());
    for (int row = 0; row < part.cells; ++row)
      for (int column = 0; column < part.cells; column += 8) {
        const std::size_t cell = static_cast<std::size_t>(row * kCellStride + column);
        std::uint64_t sure = 0, possible = 0;
        std::memcpy(&sure, mask_.data() + cell, sizeof sure);
        std::memcpy(&possible, possible_.data() + cell, sizeof possible);
        if (sure == possible) continue;
        for (int i = 0; i < 8; ++i) {
          const std::size_t c = cell + static_cast<std::size_t>(i);
          if (mask_[c] != possible_[c])
            mask_[c] =
                footprint.seen(part.first_column() + column + i + dx, part.first_row() + row + dy)
                    ? std::uint8_t{255}
                    : std::uint8_t{0};
        }
      }
  }
  if (!part.limited) return;
  for (int row = 0; row < part.cells; ++row)
    for (int column = 0; column < part.cells; ++column)
      if (!footprint.within_limit(part.first_column() + column + dx, part.first_row() + row + dy))
        mask_[static_cast<std::size_t>(row * kCellStride + column)] = 0;
}

void FootprintUpdate::sample_exactly(const Footprint& footprint, const FootprintPart& part,
                                     EvidenceLevels::Level& level, double dx, double dy) {
  for (int row = 0; row < part.cells; ++row)
    for (int column = 0; column < part.cells; ++column) {
      const auto p = footprint.seen(part.first_column() + column + dx, part.first_row() + row + dy);
      if (!p) continue;
      const double u = std::clamp(level.scaled(p->u), -1.0, level.width - 1e-9);
      const double v = std::clamp(level.scaled(p->v), -1.0, level.height - 1e-9);
      const auto iu = whole_below(u), iv = whole_below(v);
      levels_.make(level, iu, iv, iu + 1, iv + 1);
      std::int32_t sum = 0;
      if (!read_one(level, u, v, sum)) continue;
      const auto cell = static_cast<std::size_t>(row * kCellStride + column);
      sums_[cell] += sum;
      ++counts_[cell];
    }
}

/// Sums to means; a cell counts when at least half of its samples are known. False: none does.
bool FootprintUpdate::finish_samples(const FootprintPart& part) {
  const int samples = part.samples_x * part.samples_y;
  std::uint8_t any = 0;
  for (int row = 0; row < part.cells; ++row)
    for (int column = 0; column < part.cells; ++column) {
      const auto cell = static_cast<std::size_t>(row * kCellStride + column);
      const std::int32_t known = counts_[cell];
      const std::uint8_t counts = known > 0 && 2 * known >= samples ? 255 : 0;
      mask_[cell] = counts;
      any |= counts;
      sums_[cell] = nearest(static_cast<double>(sums_[cell]) / std::max(1, known));
    }
  return any != 0;
}

std::size_t FootprintUpdate::run(const GridView& view, const Evidence& evidence, Time time,
                                 const LookLimits& limits, const BlockAt& block_at) {
  levels_.begin(evidence);
  const Footprint footprint(view, limits.supersampling);
  std::size_t touched = 0;
  footprint.for_each([&](const FootprintPart& part) {
    EvidenceLevels::Level& level = levels_.level(part.averaging);
    const int samples = part.samples_x * part.samples_y;
    const int first = part.row * kCellStride + part.column;
    const bool whole = part.cells == MapTile::kBlockCells;
    const auto state = [&](MapTile::Block& block, int shift) {
      return CellState{block.evidence.data() + first,
                       block.looks.data() + first,
                       block.seen.data() + first,
                       limits.lowest,
                       limits.highest,
                       shift + levels_.finer_bits(),
                       block.place_of(time),
                       turn_of(time)};
    };
    /// The mask of a quarter, where it lies in the block.
    const auto open = [&]() -> MapTile::Block& {
      if (whole) return block_at(part.block_column, part.block_row, mask_.data());
      possible_.fill(0);
      for (int row = 0; row < part.cells; ++row)
        std::copy_n(mask_.data() + row * kCellStride, part.cells,
                    possible_.data() + first + row * kCellStride);
      return block_at(part.block_column, part.block_row, possible_.data());
    };

    const bool all = part.inside && !part.limited && (samples == 2 || samples == 4) &&
                     levels_.four_add() && limits.supersampling == 0;
    if (!part.exact && (samples == 1 || all)) {
      const double first_x = 0.5 / part.samples_x - 0.5, first_y = 0.5 / part.samples_y - 0.5;
      Placed placed = place(part, level, first_x, first_y);
      if (!placed.unknown) {
        if (part.inside && !part.limited) {
          add_steps(part, level.averaging.shrink, placed.job);
          mask_.fill(255);
          MapTile::Block& block =
              whole ? block_at(part.block_column, part.block_row, nullptr) : open();
          kernels_.add(
              placed.job,
              state(
                  block,
                  kSumBits + static_cast<int>(std::bit_width(static_cast<unsigned>(samples))) - 1));
          touched += static_cast<std::size_t>(part.cells) * static_cast<std::size_t>(part.cells);
          return;
        }
        mark_seen(footprint, part, placed, 0.0, 0.0);
        const std::size_t count = count_of(mask_.data(), part.cells);
        if (count == 0) return;
        MapTile::Block& block = open();
        kernels_.add_masked(placed.job, state(block, kSumBits), mask_.data());
        touched += count;
        return;
      }
    }
    sums_.fill(0);
    counts_.fill(0);
    for (int j = 0; j < part.samples_y; ++j)
      for (int i = 0; i < part.samples_x; ++i) {
        const double dx = (i + 0.5) / part.samples_x - 0.5, dy = (j + 0.5) / part.samples_y - 0.5;
        if (part.exact) {
          sample_exactly(footprint, part, level, dx, dy);
        } else {
          const Placed placed = place(part, level, dx, dy);
          mark_seen(footprint, part, placed, dx, dy);
          kernels_.sample(placed.job, mask_.data(), sums_.data(), counts_.data());
        }
      }
    if (!finish_samples(part)) return;
    touched += count_of(mask_.data(), part.cells);
    MapTile::Block& block = open();
    kernels_.add_sums(part.cells, part.cells, sums_.data(), state(block, kSampleBits),
                      mask_.data());
  });
  return touched;
}

}  // namespace watersky::detail
