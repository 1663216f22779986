// SPDX-License-Identifier: MIT
#include "watersky/field/ising.hpp"

#include <cmath>
#include <cstdint>
#include <string>

namespace watersky::field {

double energy(const cv::Mat& log_odds, const cv::Mat& labels, double coupling) {
  double sum = 0.0;
  for (int r = 0; r < log_odds.rows; ++r)
    for (int c = 0; c < log_odds.cols; ++c) {
      const float l = log_odds.at<float>(r, c);
      if (std::isnan(l)) continue;
      const int label = labels.at<std::uint8_t>(r, c);
      sum -= static_cast<double>(l) * label;
      for (std::size_t d = 4; d < kNeighbours.size(); ++d) {  // each pair once
        const int row = r + kNeighbours[d].row, column = c + kNeighbours[d].column;
        if (row >= log_odds.rows || column < 0 || column >= log_odds.cols) continue;
        if (std::isnan(log_odds.at<float>(row, column))) continue;
        if (labels.at<std::uint8_t>(row, column) != label) sum += coupling * kNeighbours[d].weight;
      }
    }
  return sum;
}

Status check_field(const cv::Mat& log_odds, double coupling) {
  if (!log_odds.empty() && (log_odds.dims != 2 || log_odds.type() != CV_32F))
    return Error{ErrorCode::InvalidInput, "log-odds must be one channel of 32-bit floats"};
  if (!(coupling >= 0.0 && coupling <= kMaxCoupling))
    return Error{ErrorCode::InvalidInput, "the coupling must be from 0 to " +
                                              std::to_string(static_cast<int>(kMaxCoupling)) +
                                              ", is " + std::to_string(coupling)};
  return {};
}

}  // namespace watersky::field
