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
constexpr int kSteps = 16;           // of the search, up to 4, closer where couplings are small
constexpr int kStepsBeyondBest = 3;  // after which nothing better is expected

double coupling_at(int step) { return 4.0 * step * step / (kSteps * kSteps); }

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
  const cv::Mat asked =
      log_odds.cols <= kWindow && log_odds.rows <= kWindow * kWindow ? log_odds : sample(log_odds);
  out.cells = seen_cells(asked);
  if (out.cells == 0) return out;

  const double alone = prediction(asked, 0.0);
  double most = alone;
  int best = 0;
  for (int step = 1; step <= kSteps && step <= best + kStepsBeyondBest; ++step)
    if (const double score = prediction(asked, coupling_at(step)); score > most) {
      most = score;
      best = step;
    }
  out.best_foretelling = coupling_at(best);
  double low = 0.0, high = out.best_foretelling;
  const double enough = alone + kForetellingShare * (most - alone);
  while (high - low > 0.005) {
    const double middle = 0.5 * (low + high);
    (prediction(asked, middle) >= enough ? high : low) = middle;
  }
  out.coupling = high;
  return out;
}

}  // namespace watersky::field
