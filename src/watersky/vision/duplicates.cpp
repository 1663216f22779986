// SPDX-License-Identifier: MIT
#include "watersky/vision/duplicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace watersky {
namespace {

constexpr int kBlock = FrameSample::kBlock_px;
constexpr std::size_t kBlockPixels = kBlock * kBlock;
constexpr std::size_t kMostBlocks = 512;

/// The thesis's threshold on the Hellinger distance.
constexpr double kMostHellinger = 0.03;
/// Detail below these says nothing: rounding alone makes as much. Gray levels, rms.
constexpr double kLeastNoise = 0.3;
constexpr double kLeastCoarse = 0.1;
/// So many of the blocks must show detail; captions and dirt on the lens fill fewer.
constexpr double kLeastInformative = 0.1;
// Measured on made video of 640x512, noise of 1 and 3 levels, MJPEG q 2 and 8, x264 crf 18 to 30
// (duplicates_test.cpp): duplicates' coarse detail correlates to at least 0.98 (median of blocks
// 0.99), their noise to at least 0.6 where there is any, and they seem to move by up to 0.2 px.
constexpr double kLeastCoarseCorrelation = 0.97;
constexpr double kLeastNoiseCorrelation = 0.5;
constexpr double kMostShift_px = 0.3;

Status check_pair(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || a.size() != b.size() || a.type() != b.type())
    return Error{ErrorCode::InvalidInput,
                 "images of " + std::to_string(a.cols) + "x" + std::to_string(a.rows) + " " +
                     cv::typeToString(a.type()) + " and " + std::to_string(b.cols) + "x" +
                     std::to_string(b.rows) + " " + cv::typeToString(b.type()) +
                     " cannot be compared; give two of one size and type"};
  return {};
}

Status check_type(const cv::Mat& image) {
  if ((image.depth() != CV_8U && image.depth() != CV_16U) ||
      (image.channels() != 1 && image.channels() != 3))
    return Error{ErrorCode::Unsupported, "image is of type " + cv::typeToString(image.type()) +
                                             "; give 8 or 16 bit with 1 or 3 channels"};
  return {};
}

/// Hellinger's distance of two histograms of one number of pixels.
double hellinger(const std::array<std::uint32_t, 256>& a, const std::array<std::uint32_t, 256>& b,
                 double pixels) {
  double overlap = 0.0;
  for (std::size_t i = 0; i < 256; ++i)
    overlap += std::sqrt(static_cast<double>(a[i]) * static_cast<double>(b[i]));
  return std::sqrt(std::max(0.0, 1.0 - overlap / pixels));
}

/// Counts levels from `low` to `low + span` in 256 bins.
void count(const std::uint16_t* level, std::size_t n, unsigned low, unsigned span,
           std::array<std::uint32_t, 256>& bins) {
  if (span < 256) {
    for (std::size_t i = 0; i < n; ++i) ++bins[level[i] - low];
    return;
  }
  const float scale = 256.0F / (static_cast<float>(span) + 1.0F);
  for (std::size_t i = 0; i < n; ++i)
    ++bins[std::min<unsigned>(255,
                              static_cast<unsigned>(static_cast<float>(level[i] - low) * scale))];
}

double hellinger_of(const std::uint16_t* a, const std::uint16_t* b, std::size_t n, int depth) {
  unsigned low = 0, high = 255;
  if (depth == CV_16U) {
    const auto [least_a, most_a] = std::minmax_element(a, a + n);
    const auto [least_b, most_b] = std::minmax_element(b, b + n);
    low = std::min(*least_a, *least_b);
    high = std::max(*most_a, *most_b);
  }
  std::array<std::uint32_t, 256> bins_a{}, bins_b{};
  count(a, n, low, high - low, bins_a);
  count(b, n, low, high - low, bins_b);
  return hellinger(bins_a, bins_b, static_cast<double>(n));
}

/// A block's gray levels into 16 bit. Of colour the mean with green twice: near enough to
/// luminance, and exact in whole numbers.
template <class Level>
void copy_block(const cv::Mat& image, int x0, int y0, std::uint16_t* out) {
  for (int y = 0; y < kBlock; ++y) {
    if (image.channels() == 1) {
      const Level* row = image.ptr<Level>(y0 + y) + x0;
      std::copy(row, row + kBlock, out);
    } else {
      const Level* row = image.ptr<Level>(y0 + y) + std::ptrdiff_t{3} * x0;
      for (int x = 0; x < kBlock; ++x)
        out[x] =
            static_cast<std::uint16_t>((row[3 * x] + 2 * row[3 * x + 1] + row[3 * x + 2] + 2) / 4);
    }
    out += kBlock;
  }
}

/// Energies of one block pair: of both frames together, and of their difference.
struct BlockEnergy {
  float noise = 0.0F, noise_difference = 0.0F;
  float coarse = 0.0F, coarse_difference = 0.0F;
};

constexpr int kNoisePerBlock = kBlock * kBlock / 4;
constexpr int kCoarsePerBlock = 13;

/// Diagonal differences of 2x2 pixels: blind to shading and to straight edges along the axes.
void noise_energy(const std::uint16_t* a, const std::uint16_t* b, BlockEnergy& energy) {
  float sum = 0.0F, difference = 0.0F;
  for (int y = 0; y < kBlock; y += 2) {
    const std::uint16_t* a0 = a + y * kBlock;
    const std::uint16_t* b0 = b + y * kBlock;
    for (int x = 0; x < kBlock; x += 2) {
      const auto da = static_cast<float>(a0[x] - a0[x + 1] - a0[x + kBlock] + a0[x + kBlock + 1]);
      const auto db = static_cast<float>(b0[x] - b0[x + 1] - b0[x + kBlock] + b0[x + kBlock + 1]);
      sum += da * da + db * db;
      difference += (da - db) * (da - db);
    }
  }
  energy.noise = sum / 4.0F;
  energy.noise_difference = difference / 4.0F;
}

using Means = std::array<float, 16>;  ///< of 4x4 pixels each, row by row

Means means_of(const std::uint16_t* block) {
  std::array<unsigned, 16> sums{};
  for (unsigned y = 0; y < kBlock; ++y)
    for (unsigned x = 0; x < kBlock; ++x) sums[y / 4 * 4 + x / 4] += block[y * kBlock + x];
  Means means{};
  std::transform(sums.begin(), sums.end(), means.begin(),
                 [](unsigned sum) { return static_cast<float>(sum) / 16.0F; });
  return means;
}

/// The means' two-dimensional Walsh transform, orthonormal, sequency order. Its first row and
/// column hold the mean and the slopes.
Means walsh(Means m) {
  const auto butterfly = [&m](std::size_t i, std::size_t step) {
    const float a = m[i], b = m[i + step], c = m[i + 2 * step], d = m[i + 3 * step];
    m[i] = 0.5F * (a + b + c + d);
    m[i + step] = 0.5F * (a + b - c - d);
    m[i + 2 * step] = 0.5F * (a - b - c + d);
    m[i + 3 * step] = 0.5F * (a - b + c - d);
  };
  for (std::size_t y = 0; y < 4; ++y) butterfly(4 * y, 1);
  for (std::size_t x = 0; x < 4; ++x) butterfly(x, 4);
  return m;
}

/// Normal equations of the one shift that explains the difference best.
struct ShiftFit {
  double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;

  void add(const Means& a, const Means& b) {
    for (std::size_t y = 1; y < 3; ++y)
      for (std::size_t x = 1; x < 3; ++x) {
        const std::size_t i = 4 * y + x;
        // Central differences of the mean frame, levels per pixel.
        const float gx = (a[i + 1] - a[i - 1] + b[i + 1] - b[i - 1]) / 16.0F;
        const float gy = (a[i + 4] - a[i - 4] + b[i + 4] - b[i - 4]) / 16.0F;
        const float d = a[i] - b[i];
        xx += gx * gx;
        xy += gx * gy;
        yy += gy * gy;
        xd += gx * d;
        yd += gy * d;
      }
  }
  [[nodiscard]] double shift_px() const {
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-6 * (xx + yy) * (xx + yy))) return 0.0;
    return std::hypot((yy * xd - xy * yd) / determinant, (xx * yd - xy * xd) / determinant);
  }
};

}  // namespace

Result<double> l2_norm(const cv::Mat& a, const cv::Mat& b) {
  WATERSKY_CHECK(check_pair(a, b));
  return cv::norm(a, b, cv::NORM_L2);
}

Result<double> hellinger_distance(const cv::Mat& a, const cv::Mat& b) {
  WATERSKY_CHECK(check_pair(a, b));
  WATERSKY_CHECK(check_type(a));
  const auto levels = [](const cv::Mat& image) {
    cv::Mat gray = image;
    if (image.channels() == 3) cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
    cv::Mat wide;
    gray.convertTo(wide, CV_16U);
    return wide.isContinuous() ? wide : wide.clone();
  };
  const cv::Mat wide_a = levels(a), wide_b = levels(b);
  return hellinger_of(wide_a.ptr<std::uint16_t>(), wide_b.ptr<std::uint16_t>(), wide_a.total(),
                      a.depth());
}

Result<FrameSample> FrameSample::of(const cv::Mat& image) {
  WATERSKY_CHECK(check_type(image));
  if (image.cols < 2 * kBlock || image.rows < 2 * kBlock)
    return Error{ErrorCode::InvalidInput, "image is " + std::to_string(image.cols) + "x" +
                                              std::to_string(image.rows) + "; give at least " +
                                              std::to_string(2 * kBlock) + " pixels each way"};
  FrameSample sample;
  sample.cols_ = image.cols;
  sample.rows_ = image.rows;
  sample.depth_ = image.depth();
  const int columns = image.cols / kBlock, rows = image.rows / kBlock;
  const auto all = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  const std::size_t count = std::min(all, kMostBlocks);
  sample.blocks_.resize(count * kBlockPixels);
  for (std::size_t k = 0; k < count; ++k) {
    const auto at = static_cast<int>(k * all / count);
    const int x0 = at % columns * kBlock, y0 = at / columns * kBlock;
    std::uint16_t* out = sample.blocks_.data() + k * kBlockPixels;
    if (image.depth() == CV_8U)
      copy_block<std::uint8_t>(image, x0, y0, out);
    else
      copy_block<std::uint16_t>(image, x0, y0, out);
  }
  return sample;
}

struct SampleComparison {
  const FrameSample& a;
  const FrameSample& b;

  [[nodiscard]] bool comparable() const {
    return a.cols_ == b.cols_ && a.rows_ == b.rows_ && a.depth_ == b.depth_;
  }
  [[nodiscard]] std::size_t blocks() const { return a.blocks_.size() / kBlockPixels; }
  [[nodiscard]] FrameDifference difference() const;

 private:
  void judge_detail(FrameDifference& difference) const;
};

FrameDifference SampleComparison::difference() const {
  FrameDifference difference;
  const std::size_t n = a.blocks_.size();
  difference.hellinger = hellinger_of(a.blocks_.data(), b.blocks_.data(), n, a.depth_);
  double sum = 0.0;
  for (std::size_t first = 0; first < n; first += kBlockPixels) {
    std::int64_t square = 0;
    for (std::size_t i = first; i < first + kBlockPixels; ++i) {
      const std::int64_t d = int{b.blocks_[i]} - int{a.blocks_[i]};
      square += d * d;
    }
    sum += static_cast<double>(square);
  }
  difference.rms = std::sqrt(sum / static_cast<double>(n));
  if (difference.hellinger < kMostHellinger) judge_detail(difference);
  return difference;
}

void SampleComparison::judge_detail(FrameDifference& difference) const {
  const std::size_t count = blocks();
  std::vector<BlockEnergy> energies(count);
  ShiftFit fit;
  double coarse = 0.0, coarse_difference = 0.0;
  std::size_t informative = 0;
  std::vector<float> correlations;
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint16_t* pa = a.blocks_.data() + k * kBlockPixels;
    const std::uint16_t* pb = b.blocks_.data() + k * kBlockPixels;
    BlockEnergy& e = energies[k];
    noise_energy(pa, pb, e);
    const Means means_a = means_of(pa), means_b = means_of(pb);
    fit.add(means_a, means_b);
    const Means wa = walsh(means_a), wb = walsh(means_b);
    for (std::size_t i = 2; i < 16; ++i) {
      if (i == 4) continue;  // the slope downwards; 0 and 1 are the mean and the slope across
      e.coarse += wa[i] * wa[i] + wb[i] * wb[i];
      e.coarse_difference += (wa[i] - wb[i]) * (wa[i] - wb[i]);
    }
    const bool shows_coarse = e.coarse > 2.0 * kCoarsePerBlock * kLeastCoarse * kLeastCoarse;
    const bool shows_noise = e.noise > 2.0 * kNoisePerBlock * kLeastNoise * kLeastNoise;
    informative += shows_coarse || shows_noise;
    if (!shows_coarse) continue;
    coarse += e.coarse;
    coarse_difference += e.coarse_difference;
    correlations.push_back(1.0F - e.coarse_difference / e.coarse);
  }
  difference.enough_detail =
      static_cast<double>(informative) >= kLeastInformative * static_cast<double>(count);
  difference.shift_px = fit.shift_px();

  // The flattest sixteenth: least scene, most noise.
  const std::size_t flat = std::max<std::size_t>(1, count / 16);
  std::nth_element(energies.begin(), energies.begin() + static_cast<std::ptrdiff_t>(flat - 1),
                   energies.end(),
                   [](const BlockEnergy& l, const BlockEnergy& r) { return l.noise < r.noise; });
  double noise = 0.0, noise_difference = 0.0;
  for (std::size_t k = 0; k < flat; ++k) {
    noise += energies[k].noise;
    noise_difference += energies[k].noise_difference;
  }
  const bool noisy =
      noise > 2.0 * kNoisePerBlock * static_cast<double>(flat) * kLeastNoise * kLeastNoise;
  difference.noise_correlation = noise > 0.0 ? 1.0 - noise_difference / noise : 1.0;
  difference.coarse_correlation = coarse > 0.0 ? 1.0 - coarse_difference / coarse : 0.0;

  const auto agree = [&] {
    if (difference.rms == 0.0) return true;
    if (noisy && difference.noise_correlation < kLeastNoiseCorrelation) return false;
    if (difference.shift_px > kMostShift_px) return false;
    if (static_cast<double>(correlations.size()) < kLeastInformative * static_cast<double>(count))
      return false;
    // The median, because captions and dirt agree whatever the scene does.
    const auto middle = correlations.begin() + static_cast<std::ptrdiff_t>(correlations.size() / 2);
    std::nth_element(correlations.begin(), middle, correlations.end());
    return difference.coarse_correlation >= kLeastCoarseCorrelation &&
           *middle >= kLeastCoarseCorrelation;
  };
  difference.duplicate = difference.enough_detail && agree();
}

Result<FrameDifference> compare(const FrameSample& earlier, const FrameSample& later) {
  const SampleComparison comparison{earlier, later};
  if (!comparison.comparable())
    return Error{ErrorCode::InvalidInput, "frames differ in size or depth: nothing to compare"};
  return comparison.difference();
}

std::optional<FrameDifference> DuplicateFilter::judge(FrameSample sample) {
  std::optional<FrameDifference> difference;
  if (kept_)
    if (const SampleComparison comparison{*kept_, sample}; comparison.comparable())
      difference = comparison.difference();
  if (!difference || !difference->duplicate) kept_ = std::move(sample);
  return difference;
}

}  // namespace watersky
