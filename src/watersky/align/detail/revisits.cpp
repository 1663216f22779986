// SPDX-License-Identifier: MIT
#include "watersky/align/detail/revisits.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "watersky/registration/homography.hpp"

namespace watersky::align {

std::vector<RevisitPair> revisit_pairs(const std::vector<Revisitable>& frames, double apart_s,
                                       std::size_t most) {
  // Sorted into squares as wide as the largest reach, so that only neighbours are compared.
  double reach = 1e-6;
  for (const Revisitable& f : frames) reach = std::max(reach, f.reach_m);
  const auto square = [&](double x) { return static_cast<std::int64_t>(std::floor(x / reach)); };
  const auto key = [](std::int64_t x, std::int64_t y) { return x * 1000003 + y; };
  std::unordered_map<std::int64_t, std::vector<std::size_t>> squares;
  std::vector<RevisitPair> pairs;
  constexpr int kMostOfOne = 3;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Revisitable& b = frames[i];
    const std::int64_t x = square(b.middle_m.x()), y = square(b.middle_m.y());
    std::vector<std::pair<double, std::size_t>> near;
    for (std::int64_t dx = -1; dx <= 1; ++dx)
      for (std::int64_t dy = -1; dy <= 1; ++dy)
        if (const auto found = squares.find(key(x + dx, y + dy)); found != squares.end())
          for (const std::size_t k : found->second) {
            const Revisitable& a = frames[k];
            const double share = (a.middle_m - b.middle_m).norm() / std::min(a.reach_m, b.reach_m);
            if (share < 1.0 && b.t_s - a.t_s >= apart_s) near.emplace_back(share, k);
          }
    std::sort(near.begin(), near.end());
    std::vector<double> taken_s;
    for (const auto& [share, k] : near) {
      if (static_cast<int>(taken_s.size()) >= kMostOfOne) break;
      const double t = frames[k].t_s;
      if (std::any_of(taken_s.begin(), taken_s.end(),
                      [&](double s) { return std::abs(s - t) < apart_s; }))
        continue;
      taken_s.push_back(t);
      pairs.push_back({frames[k].frame, b.frame});
    }
    squares[key(x, y)].push_back(i);
  }
  if (pairs.size() <= most) return pairs;
  std::vector<RevisitPair> thinned;
  for (std::size_t k = 0; k < most; ++k) thinned.push_back(pairs[k * pairs.size() / most]);
  return thinned;
}

namespace {

constexpr double kLeastCorrelation = 0.85;

cv::Mat levels_of(const cv::Mat& gray, double& noise) {
  cv::Mat levels;
  gray.convertTo(levels, CV_32F);
  cv::Scalar mean, spread;
  cv::meanStdDev(levels, mean, spread);
  const double scale = 40.0 / std::max(spread[0], 0.5);
  levels.convertTo(levels, CV_32F, scale, -scale * mean[0]);
  noise = 0.7 * pixel_noise(levels);
  cv::GaussianBlur(levels, levels, {}, 1.5);
  return levels;
}

std::vector<PixelPair> by_places(const cv::Mat& a, const cv::Mat& b,
                                 const Eigen::Matrix3d& b_from_a, double reach_px, int most) {
  double noise_a = 0.0, noise_b = 0.0;
  const cv::Mat la = levels_of(a, noise_a), lb = levels_of(b, noise_b);
  cv::Mat bytes;
  la.convertTo(bytes, CV_8U, 1.0, 128.0);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(bytes, corners, 3 * most, 0.01, 8.0, {}, 7);
  std::vector<PixelPair> found;
  std::vector<Eigen::Vector2d> off;
  for (const cv::Point2f& c : corners) {
    const Eigen::Vector2d p(c.x, c.y);
    const Eigen::Vector3d q = b_from_a * p.homogeneous();
    if (!(q.z() > 0)) continue;
    const Eigen::Vector2d guess = q.hnormalized();
    const auto patch = Patch::cut(la, p, noise_a);
    if (!patch) continue;
    Eigen::Matrix2d map;
    for (int k = 0; k < 2; ++k)
      map.col(k) = (b_from_a.col(k).head<2>() - guess * b_from_a(2, k)) / q.z();
    // Starts around the guess: a window is drawn in from a few pixels only.
    std::optional<Patch::Found> best;
    const int steps = static_cast<int>(std::ceil(reach_px / 3.0));
    for (int y = -steps; y <= steps; ++y)
      for (int x = -steps; x <= steps; ++x) {
        const auto here = patch->find(lb, guess + 3.0 * Eigen::Vector2d(x, y), map, 3.0);
        if (here && here->correlation > kLeastCorrelation &&
            (!best || here->correlation > best->correlation))
          best = here;
      }
    if (!best) continue;
    found.push_back({p, best->at});
    off.push_back(best->at - guess);
  }
  // Poses err alike for all places of a frame: most must be off by the same.
  if (found.size() < 2) return {};
  const auto median = [&](int axis) {
    std::vector<double> v;
    for (const auto& o : off) v.push_back(o[axis]);
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  const Eigen::Vector2d common(median(0), median(1));
  std::vector<PixelPair> agreeing;
  for (std::size_t i = 0; i < found.size(); ++i)
    if ((off[i] - common).norm() < 2.0 && static_cast<int>(agreeing.size()) < most)
      agreeing.push_back(found[i]);
  if (agreeing.size() < 2 || agreeing.size() * 10 < found.size() * 6) return {};
  return agreeing;
}

}  // namespace

std::vector<PixelPair> find_again(const cv::Mat& a, const cv::Mat& b, int reduction,
                                  const Eigen::Matrix3d& b_from_a, double reach_px,
                                  const Registrar& registrar, int most) {
  Eigen::Matrix3d full = Eigen::Matrix3d::Identity();
  full(0, 0) = full(1, 1) = reduction;
  full(0, 2) = full(1, 2) = 0.5 * (reduction - 1);
  const Eigen::Matrix3d here = full.inverse() * b_from_a * full;
  std::vector<PixelPair> pairs;
  const auto ra = registrar.prepare(a), rb = registrar.prepare(b);
  if (ra && rb)
    if (const auto r = registrar.align(*ra, *rb, here); r && r->fit) {
      const auto& inliers = r->fit->inliers;
      const std::size_t step =
          std::max<std::size_t>(1, inliers.size() / static_cast<std::size_t>(most));
      for (std::size_t i = 0; i < inliers.size(); i += step)
        pairs.push_back({{inliers[i].a.x, inliers[i].a.y}, {inliers[i].b.x, inliers[i].b.y}});
    }
  if (pairs.empty()) pairs = by_places(a, b, here, std::min(reach_px / reduction, 9.0), most);
  for (PixelPair& p : pairs) {
    p.a = (full * p.a.homogeneous()).head<2>();
    p.b = (full * p.b.homogeneous()).head<2>();
  }
  return pairs;
}

}  // namespace watersky::align
