// SPDX-License-Identifier: MIT
#include "watersky/map/position_uncertainty.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace watersky {

namespace {

/// Below this a cell's own size says more than its place's uncertainty.
constexpr double kLeastSigma_cells = 0.3;

bool in_polygon(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, k = polygon.size() - 1; i < polygon.size(); k = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[k];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

int block_of(int cell) {
  constexpr int k = PositionUncertainty::kBlockCells;
  return cell >= 0 ? cell / k : -((-cell + k - 1) / k);
}

}  // namespace

void PositionUncertainty::add(const GridView& view, const PositionCovariance& covariance) {
  if (view.box.empty()) return;
  for (int row = block_of(view.box.first_row); row <= block_of(view.box.end_row() - 1); ++row)
    for (int column = block_of(view.box.first_column);
         column <= block_of(view.box.end_column() - 1); ++column) {
      const Eigen::Vector2d middle((column + 0.5) * kBlockCells - 0.5,
                                   (row + 0.5) * kBlockCells - 0.5);
      // A footprint narrower than a block still counts in the one around its middle.
      const bool small = view.box.columns < 2 * kBlockCells || view.box.rows < 2 * kBlockCells;
      if (!small && !in_polygon(view.footprint, middle)) continue;
      const Eigen::Matrix2d c = covariance(middle);
      if (!c.allFinite()) continue;
      const TileIndex index{tile_of(column * kBlockCells), tile_of(row * kBlockCells)};
      auto& sums = tiles_[index].sums[static_cast<std::size_t>(
          (row - index.row * kBlocks) * kBlocks + (column - index.column * kBlocks))];
      sums[0] += 1.0F;
      sums[1] += static_cast<float>(c(0, 0));
      sums[2] += static_cast<float>(c(0, 1));
      sums[3] += static_cast<float>(c(1, 1));
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
