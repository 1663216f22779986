// SPDX-License-Identifier: MIT
#include "watersky/field/detail/belief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "watersky/field/ising.hpp"

namespace watersky::field::detail {

namespace {

// With all neighbours' 55 log-odds the odds stay within a float's e^±88; 1 - P(ice) at this is
// 1e-11.
constexpr float kMostLogOdds = 25.0F;

}  // namespace

Belief::Belief(const cv::Mat& log_odds, double coupling)
    : rows_(log_odds.rows), columns_(log_odds.cols), stride_(log_odds.cols + 2) {
  for (std::size_t d = 0; d < 8; ++d) {
    offset_[d] = static_cast<std::ptrdiff_t>(kNeighbours[d].row) * stride_ + kNeighbours[d].column;
    q_[d] = static_cast<float>(std::exp(coupling * kNeighbours[d].weight));
  }
  const std::size_t nodes = static_cast<std::size_t>(rows_ + 2) * static_cast<std::size_t>(stride_);
  odds_.assign(nodes, 0.0F);
  probability_.assign(nodes, 0.5F);
  std::array<float, 8> silent{};
  silent.fill(1.0F);
  messages_.assign(nodes, silent);
  for (int r = 0; r < rows_; ++r) {
    const float* l = log_odds.ptr<float>(r);
    for (int c = 0; c < columns_; ++c)
      if (!std::isnan(l[c]))
        odds_[index(r, c)] = std::exp(std::clamp(l[c], -kMostLogOdds, kMostLogOdds));
  }
}

float Belief::told(std::size_t cell) const {
  float product = 1.0F;
  for (const float message : messages_[cell]) product *= message;
  return product;
}

float Belief::sweep() {
  float change = 0.0F;
  for (int color = 0; color < 4; ++color)
    for (int r = color / 2; r < rows_; r += 2)
      for (int c = color % 2; c < columns_; c += 2) {
        const std::size_t i = index(r, c);
        if (odds_[i] == 0.0F) continue;
        const float odds = odds_[i] * told(i);
        const float p = odds / (1.0F + odds);
        change = std::max(change, std::abs(p - probability_[i]));
        probability_[i] = p;
        const std::array<float, 8>& in = messages_[i];
        std::array<float, 8> out;
        for (std::size_t d = 0; d < 8; ++d)  // odds / in[d] is R
          out[d] = (q_[d] * odds + in[d]) / (odds + q_[d] * in[d]);
        for (std::size_t d = 0; d < 8; ++d)
          messages_[i + static_cast<std::size_t>(offset_[d])][7 - d] = out[d];
      }
  return change;
}

cv::Mat Belief::probability() const {
  cv::Mat out(rows_, columns_, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  for (int r = 0; r < rows_; ++r)
    for (int c = 0; c < columns_; ++c)
      if (const std::size_t i = index(r, c); odds_[i] != 0.0F) {
        const float odds = odds_[i] * told(i);
        out.at<float>(r, c) = odds / (1.0F + odds);
      }
  return out;
}

double Belief::mean_prediction() const {
  double sum = 0.0;
  std::size_t cells = 0;
  for (int r = 0; r < rows_; ++r)
    for (int c = 0; c < columns_; ++c) {
      const std::size_t i = index(r, c);
      if (odds_[i] == 0.0F) continue;
      const double others = static_cast<double>(told(i));
      sum += std::log((1.0 + others * static_cast<double>(odds_[i])) / (1.0 + others));
      ++cells;
    }
  return cells == 0 ? 0.0 : sum / static_cast<double>(cells);
}

}  // namespace watersky::field::detail
