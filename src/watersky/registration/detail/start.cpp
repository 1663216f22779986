// SPDX-License-Identifier: MIT
#include "watersky/registration/detail/start.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/registration/homography.hpp"

namespace watersky::detail {

namespace {

/// Turns that are tried, degrees. KLT bridges half a step.
constexpr double kTurnStep_deg = 4.0;
constexpr int kTurnsEachWay = 3;
constexpr std::size_t kMostStarts = 3;
constexpr double kStandsOut = 14.0, kBehind = 0.75;
/// Starts nearer than this, in pixels of the tiny view at its corners, are one.
constexpr double kAlike_px = 5.0;
constexpr float kRatio = 0.85F;

Eigen::Matrix3d turn_about_middle(cv::Size size, double angle_rad) {
  const double cx = (size.width - 1) / 2.0, cy = (size.height - 1) / 2.0;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Eigen::Matrix3d m;
  m << c, -s, cx - c * cx + s * cy, s, c, cy - s * cx - c * cy, 0, 0, 1;
  return m;
}

cv::Mat spectrum(const cv::Mat& image, cv::Size size) {
  cv::Mat padded, out;
  cv::copyMakeBorder(image, padded, 0, size.height - image.rows, 0, size.width - image.cols,
                     cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::dft(padded, out, cv::DFT_COMPLEX_OUTPUT);
  return out;
}

/// Amplitudes half evened out: all of it would give the noise of empty bands a full vote.
void whiten(cv::Mat& product) {
  for (int y = 0; y < product.rows; ++y) {
    auto* p = product.ptr<cv::Vec2f>(y);
    for (int x = 0; x < product.cols; ++x) {
      const float amplitude = std::sqrt(p[x][0] * p[x][0] + p[x][1] * p[x][1]);
      const float scale = amplitude > 0 ? 1.0F / std::sqrt(amplitude) : 0.0F;
      p[x] *= scale;
    }
  }
}

}  // namespace

std::vector<Start> correlation_starts(const KltFrame& a, const KltFrame& b) {
  const cv::Mat &small_a = a.tiny(), &small_b = b.tiny();
  const cv::Size size(cv::getOptimalDFTSize(std::max(small_a.cols, small_b.cols)),
                      cv::getOptimalDFTSize(std::max(small_a.rows, small_b.rows)));
  const cv::Mat spectrum_b = spectrum(small_b, size);
  std::vector<Start> starts;
  double best = 0.0;
  for (int i = 0; i <= 2 * kTurnsEachWay; ++i) {
    const int k = (i + 1) / 2 * (i % 2 == 0 ? 1 : -1);  // 0, -1, 1, -2, 2 …
    // Once a turn stands out, those beyond its neighbours are of no use.
    if (best > kStandsOut && starts.size() >= 3 && i % 2 == 1 &&
        std::max(starts.back().peak, starts[starts.size() - 2].peak) < kBehind * best)
      break;
    const Eigen::Matrix3d turn =
        turn_about_middle(small_a.size(), k * kTurnStep_deg * CV_PI / 180.0);
    cv::Mat turned;
    if (k == 0) {
      turned = small_a;
    } else {
      const cv::Matx23d m(turn(0, 0), turn(0, 1), turn(0, 2), turn(1, 0), turn(1, 1), turn(1, 2));
      cv::warpAffine(small_a, turned, m, small_a.size(), cv::INTER_LINEAR);
    }
    cv::Mat product, surface;
    cv::mulSpectrums(spectrum_b, spectrum(turned, size), product, 0, true);
    whiten(product);
    cv::dft(product, surface, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
    cv::Scalar mean, spread;
    cv::meanStdDev(surface, mean, spread);
    cv::Point at;
    double most = 0;
    cv::minMaxLoc(surface, nullptr, &most, nullptr, &at);
    if (!(spread[0] > 0)) continue;
    const int dx = at.x > size.width / 2 ? at.x - size.width : at.x;
    const int dy = at.y > size.height / 2 ? at.y - size.height : at.y;
    Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
    shift(0, 2) = dx;
    shift(1, 2) = dy;
    starts.push_back({shift * turn, (most - mean[0]) / spread[0]});
    best = std::max(best, starts.back().peak);
  }
  std::sort(starts.begin(), starts.end(),
            [](const Start& l, const Start& r) { return l.peak > r.peak; });
  std::vector<Start> kept;
  for (const Start& start : starts) {
    const bool is_new = std::all_of(kept.begin(), kept.end(), [&](const Start& k) {
      return corner_error_px(k.b_from_a, start.b_from_a, small_a.size()) > kAlike_px;
    });
    if (is_new && kept.size() < kMostStarts) kept.push_back(start);
  }
  // From tiny to coarse views.
  const auto coarse_from_tiny = [](const KltFrame& f) {
    View tiny;
    tiny.reduction = f.tiny_reduction();
    return tiny.full_from_view();
  };
  for (Start& start : kept)
    start.b_from_a = coarse_from_tiny(b) * start.b_from_a * coarse_from_tiny(a).inverse();
  return kept;
}

std::optional<Consensus> consensus(std::span<const PointPair> pairs, double threshold_px,
                                   int iterations) {
  if (pairs.size() < 8) return std::nullopt;
  std::vector<cv::Point2f> from, to;
  for (const PointPair& pair : pairs) {
    from.emplace_back(pair.a);
    to.emplace_back(pair.b);
  }
  cv::UsacParams parameters;
  parameters.confidence = 0.999;
  parameters.isParallel = false;
  parameters.loIterations = 5;
  parameters.loMethod = cv::LOCAL_OPTIM_SIGMA;
  parameters.loSampleSize = 14;
  parameters.maxIterations = iterations;
  parameters.neighborsSearch = cv::NEIGH_GRID;
  parameters.randomGeneratorState = 0;
  parameters.sampler = cv::SAMPLING_UNIFORM;
  parameters.score = cv::SCORE_METHOD_MAGSAC;
  parameters.threshold = threshold_px;
  cv::Mat h, mask;
  try {
    h = cv::findHomography(from, to, mask, parameters);
  } catch (const cv::Exception&) {
    return std::nullopt;  // points that no homography can be drawn from
  }
  if (h.empty() || mask.empty()) return std::nullopt;
  Consensus found;
  for (int i = 0; i < 9; ++i) found.b_from_a(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
  if (!found.b_from_a.allFinite()) return std::nullopt;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (mask.at<std::uint8_t>(static_cast<int>(i)) != 0) found.inliers.push_back(pairs[i]);
  return found;
}

std::optional<Start> feature_start(const KltFrame& a, const KltFrame& b) {
  const Features &fa = a.features(), &fb = b.features();
  if (fa.keypoints.size() < 8 || fb.keypoints.size() < 8 ||
      fa.descriptors.type() != fb.descriptors.type())
    return std::nullopt;
  std::vector<std::vector<cv::DMatch>> nearest;
  cv::BFMatcher(fa.descriptors.type() == CV_8U ? cv::NORM_HAMMING : cv::NORM_L2)
      .knnMatch(fa.descriptors, fb.descriptors, nearest, 2);
  std::vector<PointPair> pairs;
  for (const auto& two : nearest)
    if (two.size() == 2 && two[0].distance < kRatio * two[1].distance)
      pairs.push_back({fa.keypoints[static_cast<std::size_t>(two[0].queryIdx)].pt,
                       fb.keypoints[static_cast<std::size_t>(two[0].trainIdx)].pt});
  const auto found = consensus(pairs, 3.0, 2000);
  if (!found || found->inliers.size() < 8) return std::nullopt;
  const auto coarse_from_features = [](const KltFrame& f) -> Eigen::Matrix3d {
    return f.coarse().full_from_view().inverse() * f.feature_view().full_from_view();
  };
  return Start{coarse_from_features(b) * found->b_from_a * coarse_from_features(a).inverse(),
               static_cast<double>(found->inliers.size())};
}

}  // namespace watersky::detail
