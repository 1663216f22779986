// SPDX-License-Identifier: MIT
#include "watersky/map/position_uncertainty.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "watersky/map/detail/polygon_span.hpp"

namespace watersky {

namespace {

/// Below this a cell's own size says more than its place's uncertainty.
constexpr double kLeastSigma_cells = 0.3;

int block_of(int cell) {
  constexpr int k = PositionUncertainty::kBlockCells;
  return cell >= 0 ? cell / k : -((-cell + k - 1) / k);
}

}  // namespace

namespace {

/// Number, cc, cr and rr at a block, or no finite covariance.
using Entries = std::array<float, 4>;
std::optional<Entries> entries_at(const PositionCovariance& covariance, double column, double row) {
  constexpr int k = PositionUncertainty::kBlockCells;
  const Eigen::Matrix2d c =
      covariance(Eigen::Vector2d((column + 0.5) * k - 0.5, (row + 0.5) * k - 0.5));
  if (!c.allFinite()) return std::nullopt;
  return Entries{1.0F, static_cast<float>(c(0, 0)), static_cast<float>(c(0, 1)),
                 static_cast<float>(c(1, 1))};
}

/// A square of blocks whose covariances are a quadratic in each axis through 3 x 3 of them.
class CovariancePatch {
 public:
  /// nullopt when the covariance is not finite there, or is off by more than 1 % of its trace.
  static std::optional<CovariancePatch> fit(const PositionCovariance& covariance, int column,
                                            int row, int blocks) {
    CovariancePatch patch;
    patch.column_ = column;
    patch.row_ = row;
    patch.half_ = 0.5F * static_cast<float>(blocks - 1);
    for (std::size_t r = 0; r < 3; ++r) {
      std::array<Entries, 3> e{};
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = entries_at(covariance, column + static_cast<double>(c) * patch.half_,
                                   row + static_cast<double>(r) * patch.half_);
        if (!at) return std::nullopt;
        e[c] = *at;
      }
      for (std::size_t k = 0; k < 4; ++k)
        patch.lines_[r][k] = {e[1][k], 0.5F * (e[2][k] - e[0][k]),
                              0.5F * (e[2][k] + e[0][k]) - e[1][k]};
    }
    for (const float part : {0.25F, 0.75F}) {
      const float x = 2 * part * patch.half_, y = x;
      const auto exact =
          entries_at(covariance, column + static_cast<double>(x), row + static_cast<double>(y));
      if (!exact) return std::nullopt;
      const Line line = patch.line(y);
      for (std::size_t k = 1; k < 4; ++k)
        if (!(std::abs(value(line, k, x / patch.half_ - 1) - (*exact)[k]) <=
              0.01F * ((*exact)[1] + (*exact)[3])))
          return std::nullopt;
    }
    return patch;
  }

  /// Adds the covariances of `count` blocks of a row to their sums.
  void add(int row, int column, int count, Entries* sums) const {
    const Line line = this->line(static_cast<float>(row - row_));
    for (int i = 0; i < count; ++i) {
      const float x = static_cast<float>(column + i - column_) / half_ - 1;
      for (std::size_t k = 0; k < 4; ++k) sums[i][k] += value(line, k, x);
    }
  }

 private:
  struct Quadratic {
    float middle, slope, bend;  ///< by -1 to 1 over the patch
  };
  using Line = std::array<Quadratic, 4>;
  static float value(const Line& line, std::size_t k, float x) {
    return line[k].middle + x * (line[k].slope + x * line[k].bend);
  }
  [[nodiscard]] Line line(float y) const {
    const float t = y / half_ - 1;
    const std::array<float, 3> weight{0.5F * t * (t - 1), 1 - t * t, 0.5F * t * (t + 1)};
    Line out{};
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 4; ++k) {
        out[k].middle += weight[r] * lines_[r][k].middle;
        out[k].slope += weight[r] * lines_[r][k].slope;
        out[k].bend += weight[r] * lines_[r][k].bend;
      }
    return out;
  }

  int column_ = 0, row_ = 0;
  float half_ = 1.0F;
  std::array<Line, 3> lines_{};
};

}  // namespace

void PositionUncertainty::add(const GridView& view, const PositionCovariance& covariance) {
  if (view.box.empty()) return;
  const int first_row = block_of(view.box.first_row),
            end_row = block_of(view.box.end_row() - 1) + 1;
  const int first_column = block_of(view.box.first_column);
  const int end_column = block_of(view.box.end_column() - 1) + 1;
  // Blocks whose middle lies in the footprint; one narrower than a block still counts in the one
  // around its middle.
  const bool small = view.box.columns < 2 * kBlockCells || view.box.rows < 2 * kBlockCells;
  std::vector<std::pair<int, int>> spans(static_cast<std::size_t>(end_row - first_row),
                                         {first_column, end_column});
  for (int row = first_row; !small && row < end_row; ++row) {
    const double y = (row + 0.5) * kBlockCells - 0.5;
    const auto [low, high] = detail::span_between(view.footprint, y, y);
    auto& span = spans[static_cast<std::size_t>(row - first_row)];
    if (!(low <= high)) {
      span = {0, 0};
      continue;
    }
    const auto from_middle = [](double cell) { return (cell + 0.5) / kBlockCells - 0.5; };
    span.first = std::max(first_column, static_cast<int>(std::ceil(from_middle(low))));
    span.second = std::min(end_column, static_cast<int>(std::floor(from_middle(high))) + 1);
  }

  const auto add_square = [&](const auto& self, Tile& tile, int column, int row,
                              int blocks) -> void {
    std::optional<CovariancePatch> patch;
    bool asked = false;
    for (int r = std::max(row, first_row); r < std::min(row + blocks, end_row); ++r) {
      const auto& span = spans[static_cast<std::size_t>(r - first_row)];
      const int from = std::max(column, span.first), to = std::min(column + blocks, span.second);
      if (from >= to) continue;
      if (!asked && blocks > 2) {
        patch = CovariancePatch::fit(covariance, column, row, blocks);
        if (!patch) {
          const int half = blocks / 2;
          for (const auto& [c, d] : {std::pair{0, 0}, {half, 0}, {0, half}, {half, half}})
            self(self, tile, column + c, row + d, half);
          return;
        }
      }
      asked = true;
      const int tile_row = tile_of(r * kBlockCells), tile_column = tile_of(from * kBlockCells);
      auto* sums =
          tile.sums.data() + (r - tile_row * kBlocks) * kBlocks + (from - tile_column * kBlocks);
      if (patch) {
        patch->add(r, from, to - from, sums);
        continue;
      }
      for (int c = from; c < to; ++c, ++sums)
        if (const auto e = entries_at(covariance, c, r))
          for (std::size_t k = 0; k < 4; ++k) (*sums)[k] += (*e)[k];
    }
  };
  for (int tile_row = tile_of(first_row * kBlockCells);
       tile_row <= tile_of((end_row - 1) * kBlockCells); ++tile_row)
    for (int tile_column = tile_of(first_column * kBlockCells);
         tile_column <= tile_of((end_column - 1) * kBlockCells); ++tile_column) {
      const int row = tile_row * kBlocks, column = tile_column * kBlocks;
      bool any = false;
      for (int r = std::max(row, first_row); r < std::min(row + kBlocks, end_row); ++r) {
        const auto& span = spans[static_cast<std::size_t>(r - first_row)];
        any |= std::max(column, span.first) < std::min(column + kBlocks, span.second);
      }
      if (any)
        add_square(add_square, tiles_[TileIndex{tile_column, tile_row}], column, row, kBlocks);
    }
}

cv::Mat PositionUncertainty::covariance(const CellBox& box) const {
  if (box.empty()) return {};
  const int c0 = block_of(box.first_column), r0 = block_of(box.first_row);
  cv::Mat_<cv::Vec3f> out(block_of(box.end_row() - 1) - r0 + 1,
                          block_of(box.end_column() - 1) - c0 + 1, cv::Vec3f(0, 0, 0));
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c) {
      const int column = c + c0, row = r + r0;
      const TileIndex index{tile_of(column * kBlockCells), tile_of(row * kBlockCells)};
      const auto found = tiles_.find(index);
      if (found == tiles_.end()) continue;
      const auto& sums = found->second.sums[static_cast<std::size_t>(
          (row - index.row * kBlocks) * kBlocks + (column - index.column * kBlocks))];
      if (sums[0] > 0) out(r, c) = {sums[1] / sums[0], sums[2] / sums[0], sums[3] / sums[0]};
    }
  return cv::Mat(out);
}

cv::Mat gaussian_mean(const cv::Mat& values, const Eigen::Matrix2d& covariance) {
  cv::Mat known(values.size(), CV_32F), filled(values.size(), CV_32F);
  for (int r = 0; r < values.rows; ++r) {
    const float* v = values.ptr<float>(r);
    float *k = known.ptr<float>(r), *f = filled.ptr<float>(r);
    for (int c = 0; c < values.cols; ++c) {
      const bool is_known = v[c] == v[c];
      k[c] = is_known ? 1.0F : 0.0F;
      f[c] = is_known ? v[c] : 0.0F;
    }
  }
  const double widest = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  const int half = std::max(1, static_cast<int>(std::ceil(3.0 * widest)));
  const Eigen::Matrix2d inverse = (covariance + 1e-4 * Eigen::Matrix2d::Identity()).inverse();
  cv::Mat kernel(2 * half + 1, 2 * half + 1, CV_32F);
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) {
      const Eigen::Vector2d d(x, y);
      kernel.at<float>(y + half, x + half) =
          static_cast<float>(std::exp(-0.5 * d.dot(inverse * d)));
    }
  kernel /= cv::sum(kernel)[0];
  cv::Mat sum, weight;
  cv::filter2D(filled, sum, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_CONSTANT);
  cv::filter2D(known, weight, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_CONSTANT);
  cv::Mat out(values.size(), CV_32F);
  for (int r = 0; r < values.rows; ++r) {
    const float *v = values.ptr<float>(r), *s = sum.ptr<float>(r), *w = weight.ptr<float>(r);
    float* o = out.ptr<float>(r);
    for (int c = 0; c < values.cols; ++c)
      o[c] = v[c] == v[c] ? std::clamp(s[c] / std::max(w[c], 1e-6F), 0.0F, 1.0F) : v[c];
  }
  return out;
}

cv::Mat PositionUncertainty::softened(const cv::Mat& probability, const CellBox& box) const {
  const cv::Mat blocks = covariance(box);
  if (blocks.empty() || probability.empty()) return probability;
  // One shape for all, sizes by place: pictures softened by a few sizes, mixed by the local one.
  Eigen::Matrix2d mean = Eigen::Matrix2d::Zero();
  double count = 0.0, largest = 0.0;
  for (int r = 0; r < blocks.rows; ++r)
    for (int c = 0; c < blocks.cols; ++c) {
      const cv::Vec3f b = blocks.at<cv::Vec3f>(r, c);
      const double trace = b[0] + b[2];
      if (!(trace > 0)) continue;
      mean += (Eigen::Matrix2d() << b[0], b[1], b[1], b[2]).finished();
      largest = std::max(largest, trace);
      count += 1.0;
    }
  if (count == 0.0) return probability;
  mean /= count;
  if (std::sqrt(0.5 * largest) < kLeastSigma_cells) return probability;

  // Sizes relative to the mean's, at the middle of each block, then at each cell.
  cv::Mat size_of_block(blocks.size(), CV_32F);
  for (int r = 0; r < blocks.rows; ++r)
    for (int c = 0; c < blocks.cols; ++c) {
      const cv::Vec3f b = blocks.at<cv::Vec3f>(r, c);
      const double trace = b[0] + b[2];
      size_of_block.at<float>(r, c) =
          static_cast<float>(trace > 0 ? std::sqrt(trace / mean.trace()) : 1.0);
    }
  cv::Mat size(probability.size(), CV_32F);
  const int c0 = block_of(box.first_column), r0 = block_of(box.first_row);
  for (int r = 0; r < size.rows; ++r)
    for (int c = 0; c < size.cols; ++c) {
      const double x = (box.first_column + c + 0.5) / kBlockCells - c0 - 0.5;
      const double y = (box.first_row + r + 0.5) / kBlockCells - r0 - 0.5;
      const int ix = std::clamp(static_cast<int>(std::floor(x)), 0, blocks.cols - 1);
      const int iy = std::clamp(static_cast<int>(std::floor(y)), 0, blocks.rows - 1);
      const int jx = std::min(ix + 1, blocks.cols - 1), jy = std::min(iy + 1, blocks.rows - 1);
      const double fx = std::clamp(x - ix, 0.0, 1.0), fy = std::clamp(y - iy, 0.0, 1.0);
      const auto at = [&](int bx, int by) { return size_of_block.at<float>(by, bx); };
      size.at<float>(r, c) =
          static_cast<float>((1 - fy) * ((1 - fx) * at(ix, iy) + fx * at(jx, iy)) +
                             fy * ((1 - fx) * at(ix, jy) + fx * at(jx, jy)));
    }
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(size, &least, &most);
  std::vector<double> levels{least};
  while (levels.back() < most * (1 - 1e-6))
    levels.push_back(std::min(most, levels.back() * 1.35 + 0.02));
  cv::Mat out(probability.size(), CV_32F, cv::Scalar(0));
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const Eigen::Matrix2d here = levels[k] * levels[k] * mean;
    const cv::Mat level = std::sqrt(0.5 * here.trace()) < kLeastSigma_cells
                              ? probability
                              : gaussian_mean(probability, here);
    for (int r = 0; r < out.rows; ++r) {
      const float *s = size.ptr<float>(r), *l = level.ptr<float>(r);
      float* o = out.ptr<float>(r);
      for (int c = 0; c < out.cols; ++c) {
        double weight = 0.0;
        if (k > 0 && s[c] >= levels[k - 1] && s[c] < levels[k])
          weight = (s[c] - levels[k - 1]) / (levels[k] - levels[k - 1]);
        else if (k + 1 < levels.size() && s[c] >= levels[k] && s[c] < levels[k + 1])
          weight = 1.0 - (s[c] - levels[k]) / (levels[k + 1] - levels[k]);
        else if (k + 1 == levels.size() && s[c] >= levels[k])
          weight = 1.0;
        if (weight > 0.0) o[c] += static_cast<float>(weight) * l[c];
      }
    }
  }
  // Unseen stays unseen, whatever weights rounding left out.
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c)
      if (std::isnan(probability.at<float>(r, c)))
        out.at<float>(r, c) = std::numeric_limits<float>::quiet_NaN();
  return out;
}

}  // namespace watersky
