// SPDX-License-Identifier: MIT
#include "watersky/field/coupling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "watersky/field/detail/belief.hpp"

namespace watersky::field {

namespace {

constexpr int kWindow = 128;
constexpr std::size_t kMaxWindows = 16;
constexpr int kIterations = 30;
constexpr double kMostChosen = 4.0;  // beyond it four neighbours outvote P(ice) 0.999 twice over
constexpr int kSteps = 16;

std::size_t seen_cells(const cv::Mat& log_odds) {
  std::size_t seen = 0;
  for (int r = 0; r < log_odds.rows; ++r) {
    const float* l = log_odds.ptr<float>(r);
    seen += static_cast<std::size_t>(
        std::count_if(l, l + log_odds.cols, [](float x) { return !std::isnan(x); }));
  }
  return seen;
}

/// Windows spread evenly over the map, those that were mostly seen before others, one under the
/// other with a row of nothing between them.
cv::Mat sample(const cv::Mat& log_odds) {
  std::vector<cv::Rect> mostly, partly;
  for (int r = 0; r < log_odds.rows; r += kWindow)
    for (int c = 0; c < log_odds.cols; c += kWindow) {
      const cv::Rect window(c, r, std::min(kWindow, log_odds.cols - c),
                            std::min(kWindow, log_odds.rows - r));
      const std::size_t seen = seen_cells(log_odds(window));
      if (2 * seen > static_cast<std::size_t>(kWindow) * kWindow)
        mostly.push_back(window);
      else if (seen > 0)
        partly.push_back(window);
    }
  std::vector<cv::Rect>& windows = mostly.empty() ? partly : mostly;
  const std::size_t count = std::min(windows.size(), kMaxWindows);
  cv::Mat out(static_cast<int>(count) * (kWindow + 1), kWindow, CV_32F,
              cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  for (std::size_t k = 0; k < count; ++k) {
    const cv::Rect& window = windows[k * windows.size() / count];
    log_odds(window).copyTo(
        out(cv::Rect(0, static_cast<int>(k) * (kWindow + 1), window.width, window.height)));
  }
  return out;
}

double prediction(const cv::Mat& log_odds, double coupling) {
  detail::Belief belief(log_odds, coupling);
  for (int k = 0; k < kIterations && belief.sweep() > 1e-2F; ++k) {
  }
  return belief.mean_prediction();
}

}  // namespace

Result<CouplingEstimate> estimate_coupling(const cv::Mat& log_odds) {
  WATERSKY_CHECK(check_field(log_odds, 0.0));
  CouplingEstimate out;
  const cv::Mat asked = log_odds.cols <= kWindow && log_odds.rows <= kWindow * kWindow
                            ? log_odds
                            : sample(log_odds);
  out.cells = seen_cells(asked);
  if (out.cells == 0) return out;

  // The whole range first: the score may have a second, lower maximum. Then a golden section.
  const auto at = [](int step) { return kMostChosen * step * step / (kSteps * kSteps); };
  int best = 0;
  double most = prediction(asked, 0.0);
  for (int step = 1; step <= kSteps; ++step)
    if (const double score = prediction(asked, at(step)); score > most) {
      most = score;
      best = step;
    }
  double low = at(std::max(best - 1, 0)), high = at(std::min(best + 1, kSteps));
  constexpr double kGolden = 0.61803398874989485;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double score_a = prediction(asked, a), score_b = prediction(asked, b);
  while (high - low > 0.02) {
    if (score_a > score_b) {
      high = b;
      b = a;
      score_b = score_a;
      score_a = prediction(asked, a = high - kGolden * (high - low));
    } else {
      low = a;
      a = b;
      score_a = score_b;
      score_b = prediction(asked, b = low + kGolden * (high - low));
    }
  }
  const double refined = score_a > score_b ? a : b;
  out.coupling = std::max(score_a, score_b) > most ? refined : at(best);
  return out;
}

}  // namespace watersky::field
