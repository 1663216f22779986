// SPDX-License-Identifier: MIT
#include "watersky/evaluation/segmentation_score.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace watersky {

namespace {

std::string size_text(const cv::Mat& image) {
  return std::to_string(image.cols) + "x" + std::to_string(image.rows);
}

double share(double part, double whole) {
  return whole > 0.0 ? part / whole : SegmentationScore::kNone;
}

}  // namespace

void Reliability::add(double p_ice, bool is_ice) {
  const double place = std::clamp(p_ice, 0.0, 1.0) * static_cast<double>(kBins);
  Bin& bin = bins_[std::min(kBins - 1, static_cast<std::size_t>(place))];
  ++bin.pixels;
  bin.ice += is_ice ? 1 : 0;
  bin.p_sum += p_ice;
}

void Reliability::add(const Reliability& other) {
  for (std::size_t i = 0; i < kBins; ++i) {
    bins_[i].pixels += other.bins_[i].pixels;
    bins_[i].ice += other.bins_[i].ice;
    bins_[i].p_sum += other.bins_[i].p_sum;
  }
}

std::size_t Reliability::pixels() const {
  std::size_t sum = 0;
  for (const Bin& bin : bins_) sum += bin.pixels;
  return sum;
}

double Reliability::calibration_error() const {
  double sum = 0.0;
  for (const Bin& bin : bins_) sum += std::abs(bin.p_sum - static_cast<double>(bin.ice));
  return share(sum, static_cast<double>(pixels()));
}

double SegmentationScore::concentration_error() const {
  return std::abs((std::isnan(concentration) ? 0.5 : concentration) - true_concentration);
}

Result<SegmentationScore> score_segmentation(const cv::Mat& p_ice, const cv::Mat& ice,
                                             const cv::Mat& judged) {
  if (p_ice.type() != CV_32FC1 || ice.type() != CV_8UC1 ||
      (!judged.empty() && judged.type() != CV_8UC1))
    return Error{ErrorCode::InvalidInput, "P(ice) must be CV_32F, the masks CV_8U"};
  if (ice.size() != p_ice.size() || (!judged.empty() && judged.size() != p_ice.size()))
    return Error{ErrorCode::InvalidInput,
                 "the mask has " + size_text(ice) + " pixels, the image " + size_text(p_ice)};
  SegmentationScore score;
  std::size_t unknown = 0, right = 0, both = 0, any = 0, classed_ice = 0, true_ice = 0;
  double square = 0.0;
  for (int y = 0; y < p_ice.rows; ++y) {
    const float* p = p_ice.ptr<float>(y);
    const unsigned char* truth = ice.ptr(y);
    const unsigned char* asked = judged.empty() ? nullptr : judged.ptr(y);
    for (int x = 0; x < p_ice.cols; ++x) {
      if (asked && !asked[x]) continue;
      const bool is_ice = truth[x] != 0, known = !std::isnan(p[x]);
      const bool said_ice = known && p[x] > 0.5F;
      const double said = known ? static_cast<double>(p[x]) : 0.5;
      ++score.pixels;
      unknown += known ? 0 : 1;
      true_ice += is_ice ? 1 : 0;
      classed_ice += said_ice ? 1 : 0;
      right += known && said_ice == is_ice ? 1 : 0;
      both += said_ice && is_ice ? 1 : 0;
      any += said_ice || is_ice ? 1 : 0;
      square += (said - is_ice) * (said - is_ice);
      score.reliability.add(said, is_ice);
    }
  }
  if (score.pixels == 0)
    return Error{ErrorCode::InvalidInput, "no pixel is judged: there is nothing to compare"};
  const auto n = static_cast<double>(score.pixels);
  const std::size_t known = score.pixels - unknown, water = known - classed_ice;
  // Ice among the pixels that are known and not classed ice.
  const std::size_t missed = known - right - (classed_ice - both);
  score.unknown_share = static_cast<double>(unknown) / n;
  score.accuracy = static_cast<double>(right) / n;
  score.iou = any == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(any);
  score.concentration = share(static_cast<double>(classed_ice), static_cast<double>(known));
  score.true_concentration = static_cast<double>(true_ice) / n;
  score.brier = square / n;
  score.p_ice_if_ice = share(static_cast<double>(both), static_cast<double>(classed_ice));
  score.p_ice_if_water = share(static_cast<double>(missed), static_cast<double>(water));
  return score;
}

MeanSegmentationScore mean_score(const std::vector<SegmentationScore>& scores) {
  MeanSegmentationScore mean;
  mean.images = scores.size();
  if (scores.empty()) return mean;
  mean.worst_accuracy = mean.worst_iou = 1.0;
  double classed_ice = 0.0, both = 0.0, classed_water = 0.0, missed = 0.0;
  const double n = static_cast<double>(scores.size());
  for (const SegmentationScore& s : scores) {
    mean.accuracy += s.accuracy / n;
    mean.iou += s.iou / n;
    mean.concentration_error += s.concentration_error() / n;
    mean.brier += s.brier / n;
    mean.calibration_error += s.calibration_error() / n;
    mean.unknown_share += s.unknown_share / n;
    mean.worst_accuracy = std::min(mean.worst_accuracy, s.accuracy);
    mean.worst_iou = std::min(mean.worst_iou, s.iou);
    mean.reliability.add(s.reliability);
    const double known = static_cast<double>(s.pixels) * (1.0 - s.unknown_share);
    if (known <= 0.0) continue;
    classed_ice += known * s.concentration;
    classed_water += known * (1.0 - s.concentration);
    if (!std::isnan(s.p_ice_if_ice)) both += known * s.concentration * s.p_ice_if_ice;
    if (!std::isnan(s.p_ice_if_water)) missed += known * (1.0 - s.concentration) * s.p_ice_if_water;
  }
  mean.pooled_calibration_error = mean.reliability.calibration_error();
  mean.p_ice_if_ice = share(both, classed_ice);
  mean.p_ice_if_water = share(missed, classed_water);
  return mean;
}

}  // namespace watersky
