// SPDX-License-Identifier: MIT
#include "watersky/map/detail/evidence_levels.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

namespace watersky::detail {

namespace {

/// What is left of 16 bits when four values may be added.
constexpr double kMostOfFour = 8191.0;
constexpr int kMostFinerBits = 4;

std::int16_t to_pixel(float log_odds, float units) {
  if (!(log_odds == log_odds)) return kUnknownPixel;
  return static_cast<std::int16_t>(std::lrintf(std::clamp(log_odds * units, -32767.0F, 32767.0F)));
}

/// The largest magnitude of those that are numbers, and whether some are none.
std::pair<float, bool> largest(const cv::Mat& image) {
  float most = 0.0F;
  int none = 0;
  for (int v = 0; v < image.rows; ++v) {
    const float* p = image.ptr<float>(v);
    for (int u = 0; u < image.cols; ++u) {
      // Comparisons with NaN are false, so NaN is passed over.
      most = std::abs(p[u]) > most ? std::abs(p[u]) : most;
      none |= p[u] == p[u] ? 0 : 1;
    }
  }
  return {most, none != 0};
}

std::int16_t mean_of(std::int32_t sum, std::int32_t count) {
  const double mean = static_cast<double>(sum) / count;
  return static_cast<std::int16_t>(mean < 0 ? mean - 0.5 : mean + 0.5);
}

}  // namespace

void EvidenceLevels::begin(const Evidence& evidence) {
  image_ = evidence.image();
  valid_ = evidence.valid();
  levels_ = evidence.has_levels();
  count_table_shrink_ = 0;
  for (auto& level : made_) spare_.push_back(std::move(level));
  made_.clear();

  float most = 0.0F;
  if (levels_) {
    may_be_unknown_ = !valid_.empty();
    for (const float e : evidence.table()) {
      may_be_unknown_ |= std::isnan(e);
      if (!std::isnan(e)) most = std::max(most, std::abs(e));
    }
  } else {
    std::tie(most, may_be_unknown_) = largest(image_);
  }
  const double units = most * kEvidenceUnits;
  finer_ = units > 0 ? std::clamp(static_cast<int>(std::floor(std::log2(kMostOfFour / units))), 0,
                                  kMostFinerBits)
                     : kMostFinerBits;
  four_add_ = units * (1 << finer_) <= kMostOfFour;
  // A frame that says more than 8 in log-odds, P beyond 0.9997, is as fine as a cell.
  steps_ = false;
  if (!levels_) return;
  const auto scale = static_cast<float>(kEvidenceUnits << finer_);
  for (std::size_t i = 0; i < table_.size(); ++i) table_[i] = to_pixel(evidence.table()[i], scale);
  const auto changes = std::adjacent_find(table_.begin(), table_.end(), std::not_equal_to<>());
  below_ = table_.front();
  above_ = table_.back();
  threshold_ = changes == table_.end() ? std::uint8_t{255}
                                       : static_cast<std::uint8_t>(changes - table_.begin());
  steps_ = !may_be_unknown_ && four_add_ &&
           (changes == table_.end() ||
            std::adjacent_find(changes + 1, table_.end(), std::not_equal_to<>()) == table_.end());
}

EvidenceLevels::Level& EvidenceLevels::level(const Averaging& averaging) {
  for (auto& l : made_)
    if (l->averaging == averaging) return *l;
  // Memory of earlier frames first: fresh pages cost as much as the pixels.
  auto found = std::find_if(spare_.begin(), spare_.end(),
                            [&](const auto& l) { return l->averaging == averaging; });
  std::unique_ptr<Level> l;
  if (found != spare_.end()) {
    l = std::move(*found);
    spare_.erase(found);
  } else {
    l = std::make_unique<Level>();
    l->averaging = averaging;
  }
  const int k = averaging.shrink;
  l->width = (image_.cols + k - 1) / k;
  l->height = (image_.rows + k - 1) / k;
  l->stride = (l->width + 2 + 15) / 16 * 16 + 16;  // loads of a pair may end beyond the last
  const std::size_t size =
      static_cast<std::size_t>(l->stride) * static_cast<std::size_t>(l->height + 3);
  if (l->pixels.size() < size) l->pixels.resize(size);
  const std::size_t across =
      static_cast<std::size_t>((l->width + 2 + kChunkWidth - 1) / kChunkWidth);
  const std::size_t down =
      static_cast<std::size_t>((l->height + 2 + kChunkHeight - 1) / kChunkHeight);
  l->chunks.assign(across * down, kMissing);
  made_.push_back(std::move(l));
  return *made_.back();
}

bool EvidenceLevels::make(Level& level, int u0, int v0, int u1, int v1) {
  const int across = (level.width + 2 + kChunkWidth - 1) / kChunkWidth;
  bool unknown = false;
  for (int cv = (v0 + 1) / kChunkHeight; cv <= (v1 + 1) / kChunkHeight; ++cv)
    for (int cu = (u0 + 1) / kChunkWidth; cu <= (u1 + 1) / kChunkWidth; ++cu) {
      std::uint8_t& chunk = level.chunks[static_cast<std::size_t>(cv * across + cu)];
      if (chunk == kMissing) {
        const int from_u = cu * kChunkWidth - 1, from_v = cv * kChunkHeight - 1;
        const int to_u = std::min(from_u + kChunkWidth, level.width + 1);
        const int to_v = std::min(from_v + kChunkHeight, level.height + 1);
        make_chunk(level, from_u, from_v, to_u, to_v);
        chunk = kMade;
        for (int v = from_v; may_be_unknown_ && v < to_v && chunk == kMade; ++v) {
          const std::int16_t* p = level.at(from_u, v);
          if (std::find(p, p + (to_u - from_u), kUnknownPixel) != p + (to_u - from_u))
            chunk = kMadeWithUnknown;
        }
      }
      unknown |= chunk == kMadeWithUnknown;
    }
  return unknown;
}

/// A row of the full image; `v`, `u0` and all columns within it.
void EvidenceLevels::full_row(int v, int u0, int count, std::int16_t* out) const {
  if (levels_) {
    const std::uint8_t* p = image_.ptr<std::uint8_t>(v, u0);
    if (steps_) {
      kernels_.threshold(p, count, threshold_, below_, above_, out);
    } else {
      for (int i = 0; i < count; ++i) out[i] = table_[p[i]];
    }
  } else {
    const float* p = image_.ptr<float>(v, u0);
    const auto units = static_cast<float>(kEvidenceUnits << finer_);
    for (int i = 0; i < count; ++i) out[i] = to_pixel(p[i], units);
  }
  if (valid_.empty()) return;
  const std::uint8_t* valid = valid_.ptr<std::uint8_t>(v, u0);
  for (int i = 0; i < count; ++i)
    if (valid[i] == 0) out[i] = kUnknownPixel;
}

void EvidenceLevels::fill_count_table(int shrink) {
  if (count_table_shrink_ == shrink) return;
  count_table_shrink_ = shrink;
  const std::int32_t all = shrink * shrink;
  count_table_.resize(static_cast<std::size_t>(all) + 1);
  for (std::int32_t c = 0; c <= all; ++c)
    count_table_[static_cast<std::size_t>(c)] = mean_of((all - c) * below_ + c * above_, all);
}

/// Means of the known pixels of each group; unknown when less than half of them are known. For
/// groups that the image's edge cuts, and for images in which something is not known.
void EvidenceLevels::shrunk_carefully(int shrink, int v, int u0, int count, std::int16_t* out) {
  const int first = u0 * shrink, end = std::min((u0 + count) * shrink, image_.cols);
  const auto n = static_cast<std::size_t>(count);
  sums_.assign(n, 0);
  known_.assign(n, 0);
  full_.resize(static_cast<std::size_t>(end - first));
  const int end_v = std::min((v + 1) * shrink, image_.rows);
  for (int y = v * shrink; y < end_v; ++y) {
    full_row(y, first, end - first, full_.data());
    std::size_t i = 0;
    for (std::size_t group = 0; group < n; ++group)
      for (int k = 0; k < shrink && i < full_.size(); ++k, ++i) {
        if (full_[i] == kUnknownPixel) continue;
        sums_[group] += full_[i];
        ++known_[group];
      }
  }
  for (int i = 0; i < count; ++i) {
    const int columns = std::min((u0 + i + 1) * shrink, image_.cols) - (u0 + i) * shrink;
    const int pixels = columns * (end_v - v * shrink);
    const std::int32_t k = known_[static_cast<std::size_t>(i)];
    out[i] =
        k > 0 && 2 * k >= pixels ? mean_of(sums_[static_cast<std::size_t>(i)], k) : kUnknownPixel;
  }
}

/// A row of the shrunk image, whose edge pixels are repeated outwards.
void EvidenceLevels::shrunk_row(const Averaging& averaging, int width, int height, int v, int u0,
                                int count, std::int16_t* out) {
  const int k = averaging.shrink;
  v = std::clamp(v, 0, height - 1);
  if (u0 >= width) {  // a piece of nothing but the repeated edge
    std::int16_t last = 0;
    shrunk_row(averaging, width, height, v, width - 1, 1, &last);
    std::fill(out, out + count, last);
    return;
  }
  const int from = std::clamp(u0, 0, width - 1), to = std::clamp(u0 + count, from + 1, width);
  std::int16_t* inside = out + (from - u0);
  if (k == 1) {
    full_row(v, from, to - from, inside);
  } else {
    const int whole = (v + 1) * k <= image_.rows ? std::clamp(image_.cols / k, from, to) : from;
    if (may_be_unknown_ || !levels_) {
      shrunk_carefully(k, v, from, to - from, inside);
    } else if (whole > from) {
      const int n = whole - from;
      if (steps_) {
        fill_count_table(k);
        counts_.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(k));
        kernels_.count_above(image_.ptr<std::uint8_t>(v * k, from * k),
                             static_cast<int>(image_.step[0]), k, n * k, threshold_,
                             counts_.data());
        kernels_.sum_counts(counts_.data(), k, n, count_table_.data(), inside);
      } else {
        sums_.resize(static_cast<std::size_t>(n));
        kernels_.sum_table(image_.ptr<std::uint8_t>(v * k, from * k),
                           static_cast<int>(image_.step[0]), k, n, table_.data(), sums_.data());
        const std::int32_t* sums = sums_.data();
        const float share = 1.0F / static_cast<float>(k * k);
        for (int i = 0; i < n; ++i) {
          const float mean = static_cast<float>(sums[i]) * share;
          inside[i] = static_cast<std::int16_t>(
              static_cast<std::int32_t>(mean < 0 ? mean - 0.5F : mean + 0.5F));
        }
      }
      if (whole < to) shrunk_carefully(k, v, whole, to - whole, inside + n);
    } else {
      shrunk_carefully(k, v, from, to - from, inside);
    }
  }
  std::fill(out, inside, inside[0]);
  std::fill(inside + (to - from), out + count, inside[to - from - 1]);
}

void EvidenceLevels::make_chunk(Level& level, int u0, int v0, int u1, int v1) {
  const int count = u1 - u0;
  const Averaging& a = level.averaging;
  const auto out = [&](int v) {
    return level.pixels.data() + (level.at(u0, v) - level.pixels.data());
  };
  if (!a.doubled) {
    for (int v = v0; v < v1; ++v) shrunk_row(a, level.width, level.height, v, u0, count, out(v));
    return;
  }
  if (steps_ && a.shrink == 1) {
    // Columns whose neighbours there are; left and right of them the edge is its own neighbour.
    const int from = std::max(u0, 0), to = std::max(from, std::min(u1, image_.cols - 1));
    for (int v = v0; v < v1; ++v) {
      const auto* row = image_.ptr<std::uint8_t>(std::clamp(v, 0, image_.rows - 1));
      const auto* next = image_.ptr<std::uint8_t>(std::clamp(v + 1, 0, image_.rows - 1));
      kernels_.threshold_2x2(row + from, next + from, to - from, threshold_, below_, above_,
                             out(v) + (from - u0));
      const auto beside = [&](int u) {
        const int edge = std::clamp(u, 0, image_.cols - 1);
        const std::uint8_t upper[2] = {row[edge], row[edge]}, lower[2] = {next[edge], next[edge]};
        kernels_.threshold_2x2(upper, lower, 1, threshold_, below_, above_, out(v) + (u - u0));
      };
      if (u0 < from) beside(u0);
      for (int u = to; u < u1; ++u) beside(u);
    }
    return;
  }
  const auto length = static_cast<std::size_t>(count + 1);
  rows_.resize(2 * length);
  std::int16_t *here = rows_.data(), *next = rows_.data() + length;
  shrunk_row(a, level.width, level.height, v0, u0, count + 1, here);
  for (int v = v0; v < v1; ++v) {
    shrunk_row(a, level.width, level.height, v + 1, u0, count + 1, next);
    std::int16_t* to = out(v);
    if (!may_be_unknown_) {
      kernels_.mean_2x2(here, next, count, to);
    } else {
      for (int i = 0; i < count; ++i) {
        std::int32_t sum = 0, known = 0;
        for (const std::int16_t p : {here[i], here[i + 1], next[i], next[i + 1]})
          if (p != kUnknownPixel) sum += p, ++known;
        to[i] = known >= 2 ? mean_of(sum, known) : kUnknownPixel;
      }
    }
    std::swap(here, next);
  }
}

}  // namespace watersky::detail
