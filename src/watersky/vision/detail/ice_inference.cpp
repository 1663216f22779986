// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/ice_inference.hpp"

#include <opencv2/core.hpp>

namespace watersky::detail {
namespace {

constexpr double kMostOdds = 2980.958;  // exp(8)

/// Odds against a class whose score is `of`: exp(a - of) + exp(b - of).
cv::Mat odds_against(const cv::Mat& of, const cv::Mat& a, const cv::Mat& b) {
  cv::Mat odds, other;
  cv::subtract(a, of, odds);
  cv::exp(odds, odds);
  cv::subtract(b, of, other);
  cv::exp(other, other);
  cv::add(odds, other, odds);
  cv::min(odds, kMostOdds, odds);
  cv::max(odds, 1.0 / kMostOdds, odds);
  return odds;
}

}  // namespace

cv::Mat probability(const Planes& scores, bool ponds_are_ice) {
  cv::Mat p, odds = ponds_are_ice ? odds_against(scores[kWater], scores[kPond], scores[kIce])
                                  : odds_against(scores[kIce], scores[kPond], scores[kWater]);
  if (ponds_are_ice) cv::divide(1.0, odds, odds);
  cv::add(odds, 1.0, odds);
  cv::divide(1.0, odds, p);
  return p;
}

cv::Mat log_odds(const cv::Mat& p) {
  cv::Mat odds;
  cv::divide(1.0, p, odds);
  cv::subtract(odds, 1.0, odds);
  cv::log(odds, odds);
  odds *= -1.0;
  return odds;
}

cv::Mat rough_p_ice(const IceNetworks& networks, const IceScene& scene,
                    const LevelStatistics& levels, bool ponds_are_ice) {
  return probability(evaluate(*networks.coarse, coarse_features(scene, levels)), ponds_are_ice);
}

Planes ice_scores(const IceNetworks& networks, const IceScene& scene,
                  const LevelStatistics& levels) {
  const cv::Mat rough = rough_p_ice(networks, scene, levels);
  return evaluate(*networks.fine, fine_features(scene, levels),
                  context_features(scene, levels, rough, log_odds(rough)));
}

}  // namespace watersky::detail
