// SPDX-License-Identifier: MIT
#pragma once
/// Small fields for the tests and the experiment, and all their maps one by one: the oracle.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <random>
#include <vector>

#include "watersky/field/ising.hpp"

namespace watersky::test {

/// Log-odds, normal with `scale`; a share of the cells was never seen.
inline cv::Mat random_field(int rows, int columns, double scale, double unseen_share,
                            std::mt19937& random) {
  std::normal_distribution<float> normal(0.0F, static_cast<float>(scale));
  std::uniform_real_distribution<double> u(0, 1);
  cv::Mat l(rows, columns, CV_32F);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      l.at<float>(r, c) =
          u(random) < unseen_share ? std::numeric_limits<float>::quiet_NaN() : normal(random);
  return l;
}

struct Enumeration {
  double least_energy = std::numeric_limits<double>::infinity();
  int least_ice = 0;            ///< cells of ice in the map of least energy that has the fewest
  std::vector<double> p_ice{};  ///< exact, row by row; 0 where never seen
};

/// Of 2^cells maps: for no more than some 16 cells.
inline Enumeration enumerate(const cv::Mat& log_odds, double coupling) {
  const int cells = log_odds.rows * log_odds.cols;
  Enumeration out;
  out.p_ice.assign(static_cast<std::size_t>(cells), 0.0);
  double total = 0.0;
  cv::Mat labels(log_odds.size(), CV_8U);
  for (std::uint32_t map = 0; map < (1U << cells); ++map) {
    bool possible = true;
    int ice = 0;
    for (int i = 0; i < cells; ++i) {
      const int r = i / log_odds.cols, c = i % log_odds.cols;
      const bool is_ice = (map >> i) & 1U;
      const bool unseen = std::isnan(log_odds.at<float>(r, c));
      possible = possible && !(unseen && is_ice);
      ice += is_ice;
      labels.at<std::uint8_t>(r, c) = static_cast<std::uint8_t>(unseen   ? field::kUnseen
                                                                : is_ice ? 1
                                                                         : 0);
    }
    if (!possible) continue;
    const double e = field::energy(log_odds, labels, coupling);
    if (e < out.least_energy - 1e-6) {
      out.least_energy = e;
      out.least_ice = ice;
    } else if (e < out.least_energy + 1e-6) {
      out.least_ice = std::min(out.least_ice, ice);
    }
    const double weight = std::exp(-e);
    total += weight;
    for (std::size_t i = 0; i < out.p_ice.size(); ++i)
      if ((map >> i) & 1U) out.p_ice[i] += weight;
  }
  for (double& p : out.p_ice) p /= total;
  return out;
}

}  // namespace watersky::test
