// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/ice_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/vision/detail/dispatch.hpp"

namespace watersky::detail {
namespace {

/// Log density of a level that never occurs.
const float kRarest = 0.002F;
/// Weight of the whole image's class means where a neighbourhood has none of that class.
constexpr float kWholeImage = 0.02F;

cv::Mat box(const cv::Mat& plane, int edge) {
  cv::Mat mean;
  cv::blur(plane, mean, {edge, edge}, {-1, -1}, cv::BORDER_REFLECT_101);
  return mean;
}

/// Vertical sums of 3 rows and of 5, of x and of x², and Sobel's smoothing and difference.
constexpr std::size_t kColumnSums = 6;
using ColumnSums = std::array<std::vector<float>, kColumnSums>;

WATERSKY_MULTIVERSION void sum_columns(const float* const (&rows)[5], int width,
                                       float* __restrict x3, float* __restrict x5,
                                       float* __restrict xx3, float* __restrict xx5,
                                       float* __restrict smooth, float* __restrict difference) {
  const float* __restrict a = rows[0];
  const float* __restrict b = rows[1];
  const float* __restrict c = rows[2];
  const float* __restrict d = rows[3];
  const float* __restrict e = rows[4];
  for (int x = 0; x < width; ++x) {
    const float inner = b[x] + c[x] + d[x];
    const float inner2 = b[x] * b[x] + c[x] * c[x] + d[x] * d[x];
    x3[x] = inner;
    x5[x] = inner + a[x] + e[x];
    xx3[x] = inner2;
    xx5[x] = inner2 + a[x] * a[x] + e[x] * e[x];
    smooth[x] = inner + c[x];
    difference[x] = d[x] - b[x];
  }
}

/// Where a row's LocalContrasts go.
struct ContrastRow {
  float *d3, *s3, *d5, *s5, *gradient;
};

/// Column sums have two more columns on either side.
WATERSKY_MULTIVERSION void contrasts_of_row(
    const float* __restrict n, int width, const float* __restrict x3, const float* __restrict x5,
    const float* __restrict xx3, const float* __restrict xx5, const float* __restrict smooth,
    const float* __restrict difference, const ContrastRow& out) {
  float* __restrict d3 = out.d3;
  float* __restrict s3 = out.s3;
  float* __restrict d5 = out.d5;
  float* __restrict s5 = out.s5;
  float* __restrict gradient = out.gradient;
  for (int x = 0; x < width; ++x) {
    const float m3 = (x3[x + 1] + x3[x + 2] + x3[x + 3]) * (1.0F / 9.0F);
    const float q3 = (xx3[x + 1] + xx3[x + 2] + xx3[x + 3]) * (1.0F / 9.0F);
    const float m5 = (x5[x] + x5[x + 1] + x5[x + 2] + x5[x + 3] + x5[x + 4]) * (1.0F / 25.0F);
    const float q5 = (xx5[x] + xx5[x + 1] + xx5[x + 2] + xx5[x + 3] + xx5[x + 4]) * (1.0F / 25.0F);
    d3[x] = n[x] - m3;
    d5[x] = n[x] - m5;
    const float v3 = q3 - m3 * m3, v5 = q5 - m5 * m5;
    s3[x] = __builtin_sqrtf(v3 > 0.0F ? v3 : 0.0F);
    s5[x] = __builtin_sqrtf(v5 > 0.0F ? v5 : 0.0F);
    const float gx = smooth[x + 3] - smooth[x + 1];
    const float gy = difference[x + 1] + 2.0F * difference[x + 2] + difference[x + 3];
    gradient[x] = 0.125F * __builtin_sqrtf(gx * gx + gy * gy);
  }
}

struct LocalContrasts {
  Planes planes;     ///< n - mean and deviation over 3x3, the same over 5x5
  cv::Mat gradient;  ///< magnitude by Sobel, per pixel
};

/// All in one pass over the plane.
LocalContrasts local_contrasts(const cv::Mat& n) {
  LocalContrasts out{Planes(4), cv::Mat(n.size(), CV_32F)};
  for (auto& plane : out.planes) plane.create(n.size(), CV_32F);
  const auto width = static_cast<std::size_t>(n.cols);
  ColumnSums sums;
  for (auto& sum : sums) sum.resize(width + 4);
  const auto row = [&](int y) {
    return n.ptr<float>(cv::borderInterpolate(y, n.rows, cv::BORDER_REFLECT_101));
  };
  for (int y = 0; y < n.rows; ++y) {
    const float* const rows[5] = {row(y - 2), row(y - 1), row(y), row(y + 1), row(y + 2)};
    sum_columns(rows, n.cols, sums[0].data() + 2, sums[1].data() + 2, sums[2].data() + 2,
                sums[3].data() + 2, sums[4].data() + 2, sums[5].data() + 2);
    for (auto& sum : sums)
      for (const int x : {-2, -1, n.cols, n.cols + 1})
        sum[static_cast<std::size_t>(x + 2)] = sum[static_cast<std::size_t>(
            cv::borderInterpolate(x, n.cols, cv::BORDER_REFLECT_101) + 2)];
    const ContrastRow to{out.planes[0].ptr<float>(y), out.planes[1].ptr<float>(y),
                         out.planes[2].ptr<float>(y), out.planes[3].ptr<float>(y),
                         out.gradient.ptr<float>(y)};
    contrasts_of_row(n.ptr<float>(y), n.cols, sums[0].data(), sums[1].data(), sums[2].data(),
                     sums[3].data(), sums[4].data(), sums[5].data(), to);
  }
  return out;
}

/// A pixel of four planes, or the sums of a window of them.
typedef float Quad __attribute__((vector_size(16)));

WATERSKY_MULTIVERSION void add_rows(const float* __restrict in, const float* __restrict out, int n,
                                    float* __restrict sums) {
  for (int i = 0; i < n; ++i) sums[i] += in[i] - out[i];
}

/// Sums over `edge` neighbours along a row. Four planes side by side: each sum waits for the one
/// before it, and four at once wait no longer than one.
void slide(const Quad* __restrict row, int edge, int width, float by, Quad* __restrict means) {
  Quad sum{};
  for (int x = 0; x < edge - 1; ++x) sum += row[x];
  for (int x = 0; x < width; ++x) {
    sum += row[x + edge - 1];
    means[x] = sum * by;
    sum -= row[x];
  }
}

/// Means over edge x edge pixels of four planes, reflected at the borders, in a third of the time
/// of four times cv::blur(), which sums in double precision.
std::array<cv::Mat, 4> box_means(const cv::Mat& four, int edge) {
  const int reach = edge / 2, width = four.cols, rows = four.rows;
  const auto inside = [](int i, int n) {
    return cv::borderInterpolate(i, n, cv::BORDER_REFLECT_101);
  };
  std::vector<Quad> sums(static_cast<std::size_t>(width + 2 * reach));
  float* const middle = reinterpret_cast<float*>(sums.data() + reach);
  const auto row = [&](int y) { return four.ptr<float>(inside(y, rows)); };
  for (int y = -reach - 1; y < reach; ++y)
    for (int i = 0; i < 4 * width; ++i) middle[i] += row(y)[i];
  cv::Mat means(four.size(), CV_32FC4);
  const float by = 1.0F / static_cast<float>(edge * edge);
  for (int y = 0; y < rows; ++y) {
    add_rows(row(y + reach), row(y - reach - 1), 4 * width, middle);
    for (int x = 1; x <= reach; ++x) {
      sums[static_cast<std::size_t>(reach - x)] =
          sums[static_cast<std::size_t>(reach + inside(-x, width))];
      sums[static_cast<std::size_t>(reach + width - 1 + x)] =
          sums[static_cast<std::size_t>(reach + inside(width - 1 + x, width))];
    }
    slide(sums.data(), edge, width, by, reinterpret_cast<Quad*>(means.ptr<float>(y)));
  }
  std::array<cv::Mat, 4> planes;
  cv::split(means, planes.data());
  return planes;
}

cv::Mat interleaved(const std::array<cv::Mat, 4>& planes) {
  cv::Mat four;
  cv::merge(planes.data(), planes.size(), four);
  return four;
}

cv::Mat deviation(const cv::Mat& mean_square, const cv::Mat& mean) {
  cv::Mat variance = mean_square - mean.mul(mean);
  cv::max(variance, 0.0, variance);
  cv::sqrt(variance, variance);
  return variance;
}

/// Between the entries of a table that starts at level `first`.
WATERSKY_MULTIVERSION void interpolate(const float* __restrict level, int n, float first,
                                       float bins_per_level, const float* __restrict table,
                                       float* __restrict out) {
  constexpr float kLast = LevelStatistics::kBins - 1.001F;
  for (int i = 0; i < n; ++i) {
    float bin = (level[i] - first) * bins_per_level - 0.5F;
    bin = bin > 0.0F ? bin : 0.0F;
    bin = bin < kLast ? bin : kLast;
    const int below = static_cast<int>(bin);
    const float a = table[below], b = table[below + 1];
    out[i] = a + (b - a) * (bin - static_cast<float>(below));
  }
}

cv::Mat look_up(const cv::Mat& level, const LevelStatistics& levels,
                const std::array<float, LevelStatistics::kBins>& table) {
  cv::Mat out(level.size(), CV_32F);
  interpolate(level.ptr<float>(), static_cast<int>(level.total()), levels.first,
              levels.bins_per_level, table.data(), out.ptr<float>());
  return out;
}

cv::Mat normalised(const cv::Mat& level, const LevelStatistics& levels) {
  return (level - levels.mode) * (levels.sign * levels.inverse_spread);
}

/// Replaces what is not valid by the mean of what is around it, so that no edge stands there.
void fill_in(cv::Mat& plane, const cv::Mat& weight) {
  cv::Mat sum = plane.mul(weight), near;
  const double shown = cv::sum(weight)[0];
  const double mean = shown > 0.0 ? cv::sum(sum)[0] / shown : 0.0;
  cv::Mat around = box(sum, 31) + 1e-3 * mean, by = box(weight, 31) + 1e-3;
  cv::divide(around, by, near);
  plane = sum + near.mul(1.0 - weight);
}

cv::Mat padded(const cv::Mat& image, int border) {
  const int right = (4 - image.cols % 4) % 4, below = (4 - image.rows % 4) % 4;
  if (right == 0 && below == 0) return image;
  cv::Mat out;
  cv::copyMakeBorder(image, out, 0, below, 0, right, border, cv::Scalar());
  return out;
}

cv::Mat reduced(const cv::Mat& plane, int by) {
  cv::Mat out;
  cv::resize(plane, out, {plane.cols / by, plane.rows / by}, 0, 0, cv::INTER_AREA);
  return out;
}

double full_scale(const cv::Mat& image) {
  return image.depth() == CV_8U ? 255.0 : image.depth() == CV_16U ? 65535.0 : 1.0;
}

/// Whiteness of a BGR picture in its own levels, and the planes of IceScene::half_colour.
cv::Mat take_apart(const cv::Mat& bgr, double full, Planes& colour) {
  cv::Mat whiteness(bgr.size(), CV_32F), luminance(bgr.size(), CV_32F),
      saturation(bgr.size(), CV_32F);
  const auto scale = static_cast<float>(1.0 / full);
  for (int y = 0; y < bgr.rows; ++y) {
    const float* in = bgr.ptr<float>(y);
    float* white = whiteness.ptr<float>(y);
    float* luma = luminance.ptr<float>(y);
    float* saturated = saturation.ptr<float>(y);
    for (int x = 0; x < bgr.cols; ++x, in += 3) {
      const float lowest = std::min({in[0], in[1], in[2]});
      const float highest = std::max({in[0], in[1], in[2]});
      white[x] = lowest;
      luma[x] = (0.114F * in[0] + 0.587F * in[1] + 0.299F * in[2]) * scale;
      saturated[x] = highest > 0.0F ? (highest - lowest) / highest : 0.0F;
    }
  }
  colour = {luminance, whiteness * scale, saturation};
  return whiteness;
}

}  // namespace

LevelStatistics LevelStatistics::of(const std::array<float, kBins>& histogram, float first,
                                    float bins_per_level) {
  LevelStatistics s;
  s.first = first;
  s.bins_per_level = bins_per_level;
  // A Gaussian of four bins: the mode shall be a hill, not a spike.
  constexpr int kReach = 12;
  std::array<float, 2 * kReach + 1> kernel{};
  float weight = 0.0F;
  for (int i = -kReach; i <= kReach; ++i)
    weight += kernel[static_cast<std::size_t>(i + kReach)] =
        std::exp(-static_cast<float>(i * i) / 32.0F);
  std::array<float, kBins> smooth{};
  for (int i = 0; i < kBins; ++i)
    for (int j = std::max(0, i - kReach); j <= std::min(kBins - 1, i + kReach); ++j)
      smooth[static_cast<std::size_t>(j)] += histogram[static_cast<std::size_t>(i)] *
                                             kernel[static_cast<std::size_t>(j - i + kReach)] /
                                             weight;
  double total = 0.0, moment = 0.0;
  for (std::size_t i = 0; i < kBins; ++i) {
    total += smooth[i];
    moment += static_cast<double>(i) * smooth[i];
  }
  const auto level_of_bin = [&](double bin) {
    return static_cast<float>(first + bin / bins_per_level);
  };
  const auto mode =
      static_cast<std::size_t>(std::max_element(smooth.begin(), smooth.end()) - smooth.begin());
  s.mode = level_of_bin(static_cast<double>(mode) + 0.5);

  double below = 0.0, below_moment = 0.0, best = -1.0, contrast = 1.0;
  double low = 0.0, high = kBins;
  for (std::size_t i = 0; i < kBins; ++i) {
    const double before = below;
    below += smooth[i];
    below_moment += static_cast<double>(i) * smooth[i];
    s.density[i] = std::log(smooth[i] / smooth[mode] + kRarest);
    // In the middle of the bin, so that a negative's ranks are the rest to one.
    s.rank[i] = static_cast<float>((below - 0.5 * smooth[i]) / total);
    const auto crossing = [&](double part, double& bin) {
      if (before <= part * total && below > part * total)
        bin = static_cast<double>(i) + (part * total - before) / (below - before);
    };
    crossing(0.02, low);
    crossing(0.98, high);
    if (below <= 0.0 || total - below <= 1e-6 * total) continue;
    const double difference = (moment - below_moment) / (total - below) - below_moment / below;
    const double between = below * (total - below) * difference * difference;
    if (between > best) {
      best = between;
      contrast = difference;
      s.threshold = level_of_bin(static_cast<double>(i) + 1.0);
    }
  }
  s.inverse_spread = static_cast<float>(4.0 * bins_per_level / std::max(high - low, 1.0));
  s.inverse_contrast = static_cast<float>(bins_per_level / std::max(contrast, 1e-3));
  return s;
}

LevelStatistics LevelStatistics::with_ice(bool brighter) const {
  LevelStatistics turned = *this;
  if ((sign > 0.0F) == brighter) return turned;
  turned.sign = -sign;
  for (float& r : turned.rank) r = 1.0F - r;
  return turned;
}

IceScene ice_scene(const cv::Mat& image, const cv::Mat& valid, bool in_colour) {
  IceScene scene;
  scene.size = image.size();
  cv::Mat half;
  {
    cv::Mat level = image;
    if (!in_colour && image.channels() == 3) cv::cvtColor(image, level, cv::COLOR_BGR2GRAY);
    level = padded(level, cv::BORDER_REPLICATE);
    cv::Mat exact;
    level.convertTo(exact, CV_32F);
    half = reduced(exact, 2);
  }
  if (in_colour)
    scene.half = take_apart(half, full_scale(image), scene.half_colour);
  else
    scene.half = half;
  if (!valid.empty()) {
    cv::Mat weight;
    cv::Mat(padded(valid, cv::BORDER_CONSTANT) != 0).convertTo(weight, CV_32F, 1.0 / 255.0);
    weight = reduced(weight, 2);
    cv::threshold(weight, weight, 0.75, 1.0, cv::THRESH_BINARY);
    fill_in(scene.half, weight);
    for (auto& plane : scene.half_colour) fill_in(plane, weight);
    scene.quarter_valid = reduced(weight, 2) > 0.75;
  }
  scene.quarter = reduced(scene.half, 2);
  for (const auto& plane : scene.half_colour) scene.quarter_colour.push_back(reduced(plane, 2));
  return scene;
}

bool level_statistics(const IceScene& scene, LevelStatistics& statistics) {
  double lowest = 0.0, highest = 0.0;
  const cv::Mat& level = scene.quarter;
  const cv::Mat& valid = scene.quarter_valid;
  if (!valid.empty() && cv::countNonZero(valid) == 0) return false;
  cv::minMaxLoc(level, &lowest, &highest, nullptr, nullptr, valid);
  if (!(highest > lowest)) return false;

  // Twice: a single hot pixel may stretch the first range a hundredfold.
  constexpr std::size_t kFine = 4096;
  std::vector<float> counts(kFine);
  for (int pass = 0; pass < 2; ++pass) {
    const auto first = static_cast<float>(lowest);
    const auto scale = static_cast<float>(kFine / (highest - lowest));
    std::fill(counts.begin(), counts.end(), 0.0F);
    double total = 0.0;
    for (int y = 0; y < level.rows; ++y) {
      const float* row = level.ptr<float>(y);
      const unsigned char* shown = valid.empty() ? nullptr : valid.ptr(y);
      for (int x = 0; x < level.cols; ++x)
        if (!shown || shown[x]) {
          const float bin = (row[x] - first) * scale;
          if (bin < 0.0F || bin > static_cast<float>(kFine)) continue;
          counts[std::min(static_cast<std::size_t>(bin), kFine - 1)] += 1.0F;
          total += 1.0;
        }
    }
    double below = 0.0, low = 0.0, high = kFine;
    for (std::size_t i = 0; i < kFine; ++i) {
      if (below <= 0.002 * total) low = static_cast<double>(i);
      below += counts[i];
      if (below < 0.998 * total) high = static_cast<double>(i) + 2.0;
    }
    const double bin_width = (highest - lowest) / kFine;
    const double a = lowest + low * bin_width, b = lowest + high * bin_width;
    const double margin = 0.05 * (b - a);
    lowest = a - margin;
    highest = b + margin;
  }
  std::array<float, LevelStatistics::kBins> histogram{};
  const auto first = static_cast<float>(lowest);
  const auto bins_per_level = static_cast<float>(LevelStatistics::kBins / (highest - lowest));
  for (int y = 0; y < level.rows; ++y) {
    const float* row = level.ptr<float>(y);
    const unsigned char* shown = valid.empty() ? nullptr : valid.ptr(y);
    for (int x = 0; x < level.cols; ++x) {
      const float bin = (row[x] - first) * bins_per_level;
      if ((!shown || shown[x]) && bin >= 0.0F && bin < LevelStatistics::kBins)
        histogram[static_cast<std::size_t>(bin)] += 1.0F;
    }
  }
  statistics = LevelStatistics::of(histogram, first, bins_per_level);
  return true;
}

Planes coarse_features(const IceScene& scene, const LevelStatistics& levels) {
  const cv::Mat n = normalised(scene.quarter, levels), square = n.mul(n);
  const cv::Mat density = look_up(scene.quarter, levels, levels.density);
  Planes planes{n, cv::abs(n), density, look_up(scene.quarter, levels, levels.rank),
                (scene.quarter - levels.threshold) * (levels.sign * levels.inverse_contrast)};
  const LocalContrasts local = local_contrasts(n);
  planes.insert(planes.end(), local.planes.begin(), local.planes.end());
  const cv::Mat& steepness = local.gradient;
  planes.push_back(steepness);
  const cv::Mat four = interleaved({n, square, density, steepness});
  for (const int edge : {5, 9, 17, 31}) {
    const auto [mean, mean_square, dense, steep] = box_means(four, edge);
    if (edge > 5) {
      planes.push_back(n - mean);
      planes.push_back(deviation(mean_square, mean));
    }
    if (edge == 5 || edge == 17) {
      planes.push_back(dense);
      planes.push_back(steep);
    }
  }
  for (const int edge : {5, 9, 17}) {
    const cv::Mat element = cv::Mat::ones(edge, edge, CV_8U);
    cv::Mat highest, lowest;
    cv::dilate(n, highest, element);
    cv::erode(n, lowest, element);
    planes.push_back(highest - n);
    planes.push_back(n - lowest);
  }
  planes.insert(planes.end(), scene.quarter_colour.begin(), scene.quarter_colour.end());
  // An expression may evaluate to a view of its only operand's shape, never less than a plane.
  for (auto& plane : planes)
    if (!plane.isContinuous()) plane = plane.clone();
  return planes;
}

Planes fine_features(const IceScene& scene, const LevelStatistics& levels) {
  const cv::Mat n = normalised(scene.half, levels);
  Planes planes{n, look_up(scene.half, levels, levels.density)};
  const LocalContrasts local = local_contrasts(n);
  planes.insert(planes.end(), local.planes.begin(), local.planes.end());
  planes.push_back(local.gradient);
  planes.insert(planes.end(), scene.half_colour.begin(), scene.half_colour.end());
  return planes;
}

Planes context_features(const IceScene& scene, const LevelStatistics& levels, const cv::Mat& p_ice,
                        const cv::Mat& logit) {
  const cv::Mat n = normalised(scene.quarter, levels);
  const cv::Mat ice = n.mul(p_ice), ice_square = n.mul(ice), water = n - ice;
  const double ice_area = cv::sum(p_ice)[0];
  const double water_area = static_cast<double>(p_ice.total()) - ice_area;
  const double ice_mean = cv::sum(ice)[0] / (ice_area + 1.0);
  const double water_mean = cv::sum(water)[0] / (water_area + 1.0);
  Planes planes{logit, n};
  const cv::Mat four = interleaved({p_ice, ice, water, ice_square});
  for (const int edge : {5, 9, 17, 31}) {
    const auto [area, mean_ice, mean_water, mean_square] = box_means(four, edge);
    cv::Mat here_ice, here_water, spread;
    cv::divide(mean_ice + kWholeImage * ice_mean, area + kWholeImage, here_ice);
    cv::divide(mean_water + kWholeImage * water_mean, (1.0 + kWholeImage) - area, here_water);
    cv::divide(mean_square, area + kWholeImage, spread);
    planes.push_back(area);
    planes.push_back(n - here_ice);
    planes.push_back(n - here_water);
    planes.push_back(here_ice - here_water);
    const cv::Mat sigma = deviation(spread, here_ice);
    cv::Mat distance;
    cv::divide(cv::abs(n - here_ice), sigma + 0.05, distance);
    planes.push_back(distance);
  }
  return planes;
}

}  // namespace watersky::detail
