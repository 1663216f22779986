// SPDX-License-Identifier: MIT
#include "watersky/registration/detail/tracking.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "watersky/registration/detail/start.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky::detail {

namespace {

/// There and back must end this near, px of the view.
constexpr double kMostReturn_px = 0.7;
/// Windows are of 15 x 15 pixels.
constexpr int kHalf_px = 7, kPyramid = 2;
/// What no window can tell better, whatever its gradients: the scene is not quite flat.
constexpr double kModel_px = 0.02;
/// Windows of noise alone come back as well, to wherever the start put them; they do not correlate.
constexpr double kLeastWindowCorrelation = 0.6;
constexpr int kConsensusIterations = 400;
/// Beyond so many robust spreads a pair is no inlier of the last fit.
constexpr double kMostSpreads = 3.5;
/// Agreement is judged on every second pixel each way, in patches of this side, px of the view.
constexpr int kStride_px = 2, kPatch_px = 40;
/// Nearer than this to where it was a track has not moved, px of the view.
constexpr double kStill_px = 0.6;
constexpr std::size_t kFewestMoving = 14;
constexpr double kLeastMovingShare = 0.25;

cv::Matx33d cv_matrix(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

cv::Mat drawn_as_a(const cv::Mat& b, const Eigen::Matrix3d& b_from_a, cv::Size a_size,
                   double outside) {
  cv::Mat out;
  cv::warpPerspective(b, out, cv_matrix(b_from_a), a_size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                      cv::BORDER_CONSTANT, cv::Scalar(outside));
  return out;
}

/// Correlation of the windows about `p` in `a` and `q` in `b`; p to the whole pixel.
double window_correlation(const cv::Mat& a, const cv::Mat& b, cv::Point2f p, cv::Point2f q,
                          int half) {
  const int px = cvRound(p.x), py = cvRound(p.y);
  const float x = q.x + static_cast<float>(px) - p.x, y = q.y + static_cast<float>(py) - p.y;
  const int qx = cvFloor(x), qy = cvFloor(y);
  if (px < half || py < half || px + half >= a.cols || py + half >= a.rows || qx < half ||
      qy < half || qx + half + 1 >= b.cols || qy + half + 1 >= b.rows)
    return -1.0;
  const float fx = x - static_cast<float>(qx), fy = y - static_cast<float>(qy);
  const float w00 = (1 - fx) * (1 - fy), w01 = fx * (1 - fy), w10 = (1 - fx) * fy, w11 = fx * fy;
  float sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int dy = -half; dy <= half; ++dy) {
    const std::uint8_t* ra = a.ptr<std::uint8_t>(py + dy) + px;
    const std::uint8_t* rb = b.ptr<std::uint8_t>(qy + dy) + qx;
    const std::uint8_t* rc = b.ptr<std::uint8_t>(qy + dy + 1) + qx;
    for (int dx = -half; dx <= half; ++dx) {
      const auto at = [](std::uint8_t level) { return static_cast<float>(level) - 128.0F; };
      const float va = at(ra[dx]);
      const float vb =
          w00 * at(rb[dx]) + w01 * at(rb[dx + 1]) + w10 * at(rc[dx]) + w11 * at(rc[dx + 1]);
      sa += va, sb += vb, saa += va * va, sbb += vb * vb, sab += va * vb;
    }
  }
  const auto n = static_cast<float>((2 * half + 1) * (2 * half + 1));
  const float va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return va > 0 && vb > 0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : 0.0;
}

/// How a small offset at `p` is carried by `h`: its linear part there.
Eigen::Matrix2d linear_at(const Eigen::Matrix3d& h, cv::Point2d p) {
  const cv::Point2d q = apply(h, p);
  const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
  Eigen::Matrix2d m;
  m << h(0, 0) - q.x * h(2, 0), h(0, 1) - q.x * h(2, 1), h(1, 0) - q.y * h(2, 0),
      h(1, 1) - q.y * h(2, 1);
  return m / w;
}
cv::Point2d along(const Eigen::Matrix3d& h, cv::Point2d p, cv::Point2d offset) {
  const Eigen::Vector2d moved = linear_at(h, p) * Eigen::Vector2d(offset.x, offset.y);
  return {moved.x(), moved.y()};
}

/// Where the window about `p` in `from` lies in `to`, from where `start` puts it: Lucas and
/// Kanade's, inverse compositional, on values less their mean and times a gain. nullopt where it
/// leaves the picture or its neighbourhood, does not settle, or does not correlate there.
struct Followed {
  cv::Point2d at;
  Eigen::Matrix2d covariance;  ///< px² of `to`, from the window's gradients and what does not match
};
std::optional<Followed> follow(const cv::Mat& from, const cv::Mat& to, cv::Point p,
                               const Eigen::Matrix3d& start) {
  constexpr int kSide = 2 * kHalf_px + 1, kPixels = kSide * kSide, kSteps = 12;
  constexpr float kSettled_px = 0.01F, kMostWander_px = 4.0F;
  if (p.x <= kHalf_px || p.y <= kHalf_px || p.x + kHalf_px + 1 >= from.cols ||
      p.y + kHalf_px + 1 >= from.rows)
    return std::nullopt;
  std::array<float, kPixels> value{}, gx{}, gy{};
  float mean = 0, mean_x = 0, mean_y = 0;
  for (int y = -kHalf_px, i = 0; y <= kHalf_px; ++y) {
    const float* above = from.ptr<float>(p.y + y - 1) + p.x;
    const float* row = from.ptr<float>(p.y + y) + p.x;
    const float* below = from.ptr<float>(p.y + y + 1) + p.x;
    for (int x = -kHalf_px; x <= kHalf_px; ++x, ++i) {
      const auto k = static_cast<std::size_t>(i);
      value[k] = row[x];
      gx[k] = 0.5F * (row[x + 1] - row[x - 1]);
      gy[k] = 0.5F * (below[x] - above[x]);
      mean += value[k], mean_x += gx[k], mean_y += gy[k];
    }
  }
  mean /= kPixels, mean_x /= kPixels, mean_y /= kPixels;
  float xx = 0, xy = 0, yy = 0, square = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    value[i] -= mean, gx[i] -= mean_x, gy[i] -= mean_y;
    xx += gx[i] * gx[i], xy += gx[i] * gy[i], yy += gy[i] * gy[i];
    square += value[i] * value[i];
  }
  const float determinant = xx * yy - xy * xy;
  if (!(determinant > 1e-4F * (xx + yy) * (xx + yy)) || !(square > 0)) return std::nullopt;

  const Eigen::Matrix2f j = linear_at(start, p).cast<float>();
  const cv::Point2d began = apply(start, p);
  auto qx = static_cast<float>(began.x), qy = static_cast<float>(began.y);
  float moved_x = 0, moved_y = 0;  // in pixels of `from`
  // How far the window reaches in `to`.
  const float reach_x = kHalf_px * (std::abs(j(0, 0)) + std::abs(j(0, 1))) + 2.0F;
  const float reach_y = kHalf_px * (std::abs(j(1, 0)) + std::abs(j(1, 1))) + 2.0F;
  std::array<float, kPixels> seen{};
  for (int step = 0; step < kSteps; ++step) {
    if (!(qx > reach_x && qy > reach_y && qx + reach_x < static_cast<float>(to.cols) &&
          qy + reach_y < static_cast<float>(to.rows)))
      return std::nullopt;
    float seen_mean = 0;
    for (int y = -kHalf_px, i = 0; y <= kHalf_px; ++y) {
      float sx = qx + j(0, 1) * static_cast<float>(y) - j(0, 0) * kHalf_px;
      float sy = qy + j(1, 1) * static_cast<float>(y) - j(1, 0) * kHalf_px;
      for (int x = 0; x < kSide; ++x, ++i, sx += j(0, 0), sy += j(1, 0)) {
        const int ix = static_cast<int>(sx), iy = static_cast<int>(sy);
        const float fx = sx - static_cast<float>(ix), fy = sy - static_cast<float>(iy);
        const float* r0 = to.ptr<float>(iy) + ix;
        const float* r1 = to.ptr<float>(iy + 1) + ix;
        const float top = r0[0] + fx * (r0[1] - r0[0]);
        const float bottom = r1[0] + fx * (r1[1] - r1[0]);
        const float v = top + fy * (bottom - top);
        seen[static_cast<std::size_t>(i)] = v;
        seen_mean += v;
      }
    }
    seen_mean /= kPixels;
    float sx = 0, sy = 0, product = 0, seen_square = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      const float v = seen[i] - seen_mean;
      sx += gx[i] * v, sy += gy[i] * v;
      product += v * value[i], seen_square += v * v;
    }
    if (!(product > 0)) return std::nullopt;
    const float gain = product / square;
    float vx = 0, vy = 0;  // what the window itself would give
    for (std::size_t i = 0; i < kPixels; ++i) vx += gx[i] * value[i], vy += gy[i] * value[i];
    sx = sx / gain - vx, sy = sy / gain - vy;
    const float dx = (yy * sx - xy * sy) / determinant, dy = (xx * sy - xy * sx) / determinant;
    qx -= j(0, 0) * dx + j(0, 1) * dy;
    qy -= j(1, 0) * dx + j(1, 1) * dy;
    moved_x -= dx, moved_y -= dy;
    if (!(std::abs(moved_x) < kMostWander_px && std::abs(moved_y) < kMostWander_px))
      return std::nullopt;
    if (std::abs(dx) + std::abs(dy) < kSettled_px) {
      if (product < kLeastWindowCorrelation * std::sqrt(square * seen_square)) return std::nullopt;
      // What is left over is the noise of both windows.
      const double noise = std::max(0.0F, seen_square / (gain * gain) - square) / kPixels;
      Eigen::Matrix2d normal;
      normal << xx, xy, xy, yy;
      const Eigen::Matrix2d jd = j.cast<double>();
      Eigen::Matrix2d covariance = noise * (jd * normal.inverse() * jd.transpose());
      covariance.diagonal().array() += kModel_px * kModel_px;
      return Followed{{qx, qy}, covariance};
    }
  }
  return std::nullopt;
}

bool inside(cv::Size size, cv::Point2d p) {
  return p.x > 2 && p.y > 2 && p.x < size.width - 3 && p.y < size.height - 3;
}
std::vector<cv::Point2f> shown_in(cv::Size b, std::span<const cv::Point2f> corners,
                                  const Eigen::Matrix3d& start) {
  std::vector<cv::Point2f> shown;
  for (const cv::Point2f& p : corners)
    if (inside(b, apply(start, p))) shown.push_back(p);
  return shown;
}

/// The fit to all pairs near it, twice over, so that the inliers are those of the final fit.
std::optional<HomographyFit> settled(std::span<const PointPair> pairs, const Consensus& first,
                                     double threshold_px, cv::Size a_size) {
  auto fit = fit_homography(first.inliers, first.b_from_a, a_size);
  for (int round = 0; fit && round < 2; ++round) {
    const auto distance = [&](const PointPair& pair) {  // in its own sigmas
      const cv::Point2d error = apply(fit->b_from_a, pair.a) - pair.b;
      const Eigen::Vector2d e(error.x, error.y);
      return std::sqrt(e.dot(pair.covariance.inverse() * e));
    };
    std::vector<double> distances;
    for (const PointPair& pair : fit->inliers) distances.push_back(distance(pair));
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    // The median distance of two normal errors is 1.18 of their sigma.
    const double most = kMostSpreads * std::max(*middle / 1.18, 1e-6);
    std::vector<PointPair> near;
    for (const PointPair& pair : pairs)
      if (cv::norm(apply(fit->b_from_a, pair.a) - pair.b) <= 2.0 * threshold_px &&
          distance(pair) <= most)
        near.push_back(pair);
    fit = fit_homography(near, fit->b_from_a, a_size);
  }
  return fit;
}

/// Tracks that stay where they are on the sensor may follow its pattern. If enough others move,
/// they have no say: of a moving picture they hold little.
void agree_on(Tracked& tracked, cv::Size a_size, const TrackingOptions& options) {
  std::vector<PointPair> moving;
  if (options.still)
    for (const PointPair& pair : tracked.matches)
      if (cv::norm(apply(*options.still, pair.a) - pair.b) > kStill_px) moving.push_back(pair);
  const bool moved = moving.size() >= kFewestMoving &&
                     static_cast<double>(moving.size()) >
                         kLeastMovingShare * static_cast<double>(tracked.matches.size());
  const std::span<const PointPair> speaking = moved ? moving : tracked.matches;
  const auto agreed = consensus(speaking, options.threshold_px, kConsensusIterations);
  if (agreed) tracked.fit = settled(speaking, *agreed, options.threshold_px, a_size);
}

}  // namespace

Tracked track_far(const View& a, const View& b, std::span<const cv::Point2f> corners,
                  const Eigen::Matrix3d& start, const TrackingOptions& options) {
  Tracked tracked;
  const auto from = shown_in(b.size(), corners, start);
  tracked.tried = from.size();
  if (from.size() < 8) return tracked;

  const cv::Mat seen = drawn_as_a(b.levels, start, a.size(), kMiddle);
  const cv::Size window(2 * kHalf_px + 1, 2 * kHalf_px + 1);
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 0.03);
  std::vector<cv::Mat> pyramid_a, pyramid_b;
  const int levels = cv::buildOpticalFlowPyramid(a.levels, pyramid_a, window, kPyramid);
  cv::buildOpticalFlowPyramid(seen, pyramid_b, window, kPyramid, false);
  std::vector<cv::Point2f> there = from;
  std::vector<std::uint8_t> found;
  std::vector<float> ignored;
  cv::calcOpticalFlowPyrLK(pyramid_a, pyramid_b, from, there, found, ignored, window, levels, until,
                           cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (found[i] == 0 ||
        window_correlation(a.levels, seen, from[i], there[i], kHalf_px) < kLeastWindowCorrelation)
      continue;
    const cv::Point2d in_b = apply(start, there[i]);
    if (inside(b.size(), in_b)) tracked.matches.push_back({from[i], in_b});
  }
  agree_on(tracked, a.size(), options);
  return tracked;
}

Tracked track_near(const cv::Mat& a, const cv::Mat& b, std::span<const cv::Point2f> corners,
                   const Eigen::Matrix3d& start, const TrackingOptions& options) {
  Tracked tracked;
  const auto from = shown_in(b.size(), corners, start);
  tracked.tried = from.size();
  const Eigen::Matrix3d back = start.inverse();
  for (const cv::Point2f& corner : from) {
    const cv::Point p(cvRound(corner.x), cvRound(corner.y));
    const auto q = follow(a, b, p, start);
    if (!q) continue;
    // Back from the whole pixel next to where it went: other samples, other noise.
    const cv::Point r(cvRound(q->at.x), cvRound(q->at.y));
    const auto returned = follow(b, a, r, back);
    if (!returned) continue;
    const cv::Point2d offset = q->at - cv::Point2d(r);
    const cv::Point2d expected = cv::Point2d(p) - along(back, r, offset);
    if (cv::norm(returned->at - expected) > kMostReturn_px) continue;
    // Both ways tell the same place; their mean has less noise.
    const cv::Point2d other = q->at + along(start, p, expected - returned->at);
    tracked.matches.push_back({cv::Point2d(p), 0.5 * (q->at + other), q->covariance});
  }
  agree_on(tracked, a.size(), options);
  return tracked;
}

Agreement agreement(const View& a, const View& b, const Eigen::Matrix3d& b_from_a) {
  // 0 marks what B does not show; levels themselves are kept from it.
  const cv::Size size(a.size().width / kStride_px, a.size().height / kStride_px);
  Eigen::Matrix3d sparse = b_from_a;
  sparse.leftCols<2>() *= kStride_px;
  const cv::Mat seen = drawn_as_a(cv::max(b.levels, 1), sparse, size, 0);
  cv::Mat shown;
  if (!b.valid.empty()) shown = drawn_as_a(b.valid, sparse, size, 0);
  struct Sums {
    double shown = 0;  ///< pixels that both show; the others count textured ones
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    void add(const Sums& o) {
      shown += o.shown, n += o.n, a += o.a, b += o.b, aa += o.aa, bb += o.bb, ab += o.ab;
    }
    [[nodiscard]] double correlation() const {
      if (n < 2) return 0.0;
      const double va = aa - a * a / n, vb = bb - b * b / n;
      return va > 1e-9 && vb > 1e-9 ? (ab - a * b / n) / std::sqrt(va * vb) : 0.0;
    }
  };
  constexpr int kPatch = kPatch_px / kStride_px;
  const int across = std::max(1, size.width / kPatch), down = std::max(1, size.height / kPatch);
  std::vector<Sums> patches(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
  for (int y = 0; y < size.height; ++y) {
    const std::uint8_t* pa = a.levels.ptr<std::uint8_t>(kStride_px * y);
    const std::uint8_t* pt =
        a.textured.empty() ? nullptr : a.textured.ptr<std::uint8_t>(kStride_px * y);
    const std::uint8_t* pb = seen.ptr<std::uint8_t>(y);
    const std::uint8_t* va = a.valid.empty() ? nullptr : a.valid.ptr<std::uint8_t>(kStride_px * y);
    const std::uint8_t* vb = shown.empty() ? nullptr : shown.ptr<std::uint8_t>(y);
    const int row = std::min(down - 1, y * down / size.height);
    for (int column = 0; column < across; ++column) {
      const int first = column * size.width / across, last = (column + 1) * size.width / across;
      int textured = 0, n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
      for (int x = first; x < last; ++x) {
        if (pb[x] == 0 || (va && va[kStride_px * x] == 0) || (vb && vb[x] < 255)) continue;
        ++n;
        if (pt && pt[kStride_px * x] == 0) continue;  // noise agrees with nothing
        ++textured;
        const int ia = pa[kStride_px * x] - 128, ib = pb[x] - 128;
        sa += ia;
        sb += ib;
        saa += ia * ia;
        sbb += ib * ib;
        sab += ia * ib;
      }
      patches[static_cast<std::size_t>(row * across + column)].add(
          {double(n), double(textured), double(sa), double(sb), double(saa), double(sbb),
           double(sab)});
    }
  }
  Agreement found;
  Sums all;
  int agreeing = 0;
  const double full = static_cast<double>(size.area()) / static_cast<double>(patches.size());
  for (const Sums& patch : patches) {
    all.add(patch);
    if (patch.shown < 0.5 * full || patch.n < 0.5 * patch.shown) continue;
    ++found.patches;
    // By chance a patch of some 40 independent places correlates to 0.16, one sigma.
    if (patch.correlation() > 0.25) ++agreeing;
  }
  found.correlation = all.correlation();
  // Detail is some 3 px of the view wide, so of `kStride_px`'s samples every fourth is its own.
  found.chance = 1.0 / std::sqrt(std::max(1.0, all.n / 4.0));
  found.overlap = all.shown / static_cast<double>(size.area());
  found.patches_agreeing = found.patches > 0 ? static_cast<double>(agreeing) / found.patches : 0.0;
  return found;
}

}  // namespace watersky::detail
