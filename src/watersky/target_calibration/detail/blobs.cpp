// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/blobs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace watersky::detail {

namespace {

constexpr double kLeastArea_px = 9.0;
constexpr std::size_t kMostBlobs = 3000;

/// A plane over the image: level(d) at an offset d from the spot's centre.
struct Plane {
  Eigen::Vector3d of = Eigen::Vector3d::Zero();
  [[nodiscard]] double level(double x, double y) const { return of[0] + of[1] * x + of[2] * y; }
};

/// Sums for a plane through pixels; a mean where they do not spread enough for one.
class PlaneFit {
 public:
  void add(double x, double y, double level) {
    const Eigen::Vector3d row(1, x, y);
    normal_ += row * row.transpose();
    right_ += row * level;
  }
  [[nodiscard]] double count() const { return normal_(0, 0); }
  [[nodiscard]] Plane plane(bool sloped) const {
    Plane p;
    p.of[0] = right_[0] / normal_(0, 0);
    if (!sloped) return p;
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(normal_);
    if (ldlt.info() == Eigen::Success && ldlt.rcond() > 1e-9) p.of = ldlt.solve(right_);
    return p;
  }

 private:
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

}  // namespace

double Blob::area_px2() const {
  return 4 * std::numbers::pi * std::sqrt(std::max(0.0, moments.determinant()));
}

double noise_of(const cv::Mat& gray) {
  // Immerkaer's mask (1996) sees neither planes nor straight edges; the median forgets the rest.
  const cv::Mat mask = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat rough;
  cv::filter2D(gray, rough, CV_32F, mask);
  std::vector<float> size;
  const int step =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(gray.total()) / 40000)));
  for (int y = 1; y + 1 < gray.rows; y += step)
    for (int x = 1; x + 1 < gray.cols; x += step) size.push_back(std::abs(rough.at<float>(y, x)));
  if (size.empty()) return 0;
  const auto middle = size.begin() + static_cast<long>(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  return static_cast<double>(*middle) / 0.6745 / 6.0;  // the mask's norm is 6
}

std::vector<Blob> find_blobs(const cv::Mat& gray, int window_px, bool bright, double noise) {
  cv::Mat smooth, mean, spread;
  cv::GaussianBlur(gray, smooth, {}, 1.0);
  cv::boxFilter(smooth, mean, CV_32F, {window_px, window_px}, {-1, -1}, true, cv::BORDER_REFLECT);
  cv::Mat off = bright ? cv::Mat(smooth - mean) : cv::Mat(mean - smooth);
  cv::boxFilter(cv::abs(off), spread, CV_32F, {window_px, window_px}, {-1, -1}, true,
                cv::BORDER_REFLECT);
  // The blur leaves 0.28 of white noise.
  const cv::Mat floor = cv::max(0.5 * spread, 3.0 * 0.28 * noise);
  const cv::Mat mask = off > floor;
  cv::Mat labels;
  const int count = cv::connectedComponents(mask, labels, 4, CV_32S);
  struct Sums {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, level = 0;
    bool cut = false;
  };
  std::vector<Sums> sums(static_cast<std::size_t>(count));
  for (int y = 0; y < labels.rows; ++y) {
    const int* label = labels.ptr<int>(y);
    const float* level = off.ptr<float>(y);
    for (int x = 0; x < labels.cols; ++x) {
      if (label[x] == 0) continue;
      Sums& s = sums[static_cast<std::size_t>(label[x])];
      s.n += 1, s.x += x, s.y += y, s.xx += x * x, s.xy += x * y, s.yy += y * y;
      s.level += static_cast<double>(level[x]);
      if (x == 0 || y == 0 || x == labels.cols - 1 || y == labels.rows - 1) s.cut = true;
    }
  }
  std::vector<Blob> blobs;
  for (const Sums& s : sums) {
    if (s.cut || s.n < kLeastArea_px || s.n > 1.2 * window_px * window_px) continue;
    Blob blob;
    blob.centre = {s.x / s.n, s.y / s.n};
    blob.moments << s.xx / s.n - blob.centre.x() * blob.centre.x() + 1.0 / 12,
        s.xy / s.n - blob.centre.x() * blob.centre.y(), 0,
        s.yy / s.n - blob.centre.y() * blob.centre.y() + 1.0 / 12;
    blob.moments(1, 0) = blob.moments(0, 1);
    blob.contrast = (bright ? 1 : -1) * s.level / s.n;
    // An ellipse has the area that its moments tell (a square 5 % less, a ring much less); lens
    // and pixels bend small ones a little.
    const double roundness = s.n / blob.area_px2();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(blob.moments);
    const double flatness = std::sqrt(axes.eigenvalues()[1] / axes.eigenvalues()[0]);
    if (roundness < 0.8 || roundness > 1.2 || !(flatness < 5)) continue;
    blobs.push_back(blob);
  }
  if (blobs.size() > kMostBlobs) {
    std::nth_element(
        blobs.begin(), blobs.begin() + kMostBlobs, blobs.end(), [](const Blob& a, const Blob& b) {
          return std::abs(a.contrast) * a.area_px2() > std::abs(b.contrast) * b.area_px2();
        });
    blobs.resize(kMostBlobs);
  }
  return blobs;
}

std::optional<Blob> refine_blob(const cv::Mat& gray, const Blob& blob) {
  // In units of the ellipse's own radius; pixels at the rim are mixed and belong to neither plane.
  constexpr double kCore = 0.7, kRim = 1.25, kOutside = 1.75;
  constexpr int kRounds = 5;
  Blob now = blob;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Matrix2d inverse = now.moments.inverse();
    if (!inverse.allFinite() || !now.centre.allFinite()) return std::nullopt;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(now.moments);
    const double small = 2 * std::sqrt(axes.eigenvalues()[0]);  // px
    const double rim = std::max(kRim, 1 + 2.0 / small), out = std::max(kOutside, rim + 2.0 / small);
    const double reach_x = out * 2 * std::sqrt(now.moments(0, 0));
    const double reach_y = out * 2 * std::sqrt(now.moments(1, 1));
    const int left = static_cast<int>(std::floor(now.centre.x() - reach_x));
    const int right = static_cast<int>(std::ceil(now.centre.x() + reach_x));
    const int top = static_cast<int>(std::floor(now.centre.y() - reach_y));
    const int bottom = static_cast<int>(std::ceil(now.centre.y() + reach_y));
    // A ring that is cut would weigh one side of the background alone.
    const int slack = static_cast<int>(std::ceil(0.3 * std::max(reach_x, reach_y)));
    if (left < -slack || top < -slack || right >= gray.cols + slack || bottom >= gray.rows + slack)
      return std::nullopt;
    const auto radius = [&](double x, double y) {
      const Eigen::Vector2d d(x, y);
      return 0.5 * std::sqrt(d.dot(inverse * d));
    };
    PlaneFit back_fit, core_fit;
    const auto each = [&](const auto& visit) {
      for (int y = std::max(top, 0); y <= std::min(bottom, gray.rows - 1); ++y) {
        const float* row = gray.ptr<float>(y);
        for (int x = std::max(left, 0); x <= std::min(right, gray.cols - 1); ++x) {
          const double dx = x - now.centre.x(), dy = y - now.centre.y();
          visit(dx, dy, radius(dx, dy), static_cast<double>(row[x]));
        }
      }
    };
    each([&](double x, double y, double r, double level) {
      if (r > rim && r < out) back_fit.add(x, y, level);
      if (r < kCore) core_fit.add(x, y, level);
    });
    if (back_fit.count() < 12 || core_fit.count() < 1) return std::nullopt;
    const Plane back = back_fit.plane(true);
    const Plane core = core_fit.plane(core_fit.count() >= 30);
    const double contrast = core.of[0] - back.of[0];
    if (!(std::abs(contrast) > 0) || contrast * blob.contrast < 0) return std::nullopt;
    // How much of each pixel is spot. Not held to 0 and 1: that would turn noise into a bias.
    double n = 0, mixed = 0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    bool reversed = false;
    each([&](double x, double y, double r, double level) {
      if (r >= rim) return;
      const double step = core.level(x, y) - back.level(x, y);
      if (step * contrast <= 0) {
        reversed = true;
        return;
      }
      const double share = (level - back.level(x, y)) / step;
      const Eigen::Vector2d d(x, y);
      n += share;
      first += share * d;
      second += share * d * d.transpose();
      const double held = std::clamp(share, 0.0, 1.0);
      mixed += held * (1 - held);
    });
    if (reversed || !(n > 0.5 * kLeastArea_px)) return std::nullopt;
    const Eigen::Vector2d shift = first / n;
    if (!(shift.norm() < 0.5 * std::sqrt(now.area_px2()))) return std::nullopt;
    now.centre += shift;
    Eigen::Matrix2d moments = second / n - shift * shift.transpose();
    // The shape follows the area, which noise far out moves less than it moves second moments.
    const double area = 4 * std::numbers::pi * std::sqrt(std::max(1e-9, moments.determinant()));
    if (!(area > 0.4 * n && area < 2.5 * n) || !(moments(0, 0) > 0)) return std::nullopt;
    now.moments = moments * (n / area);
    now.contrast = contrast;
    // A straight edge under a Gaussian blur of s has ∫ share (1 - share) = s/√π along its normal;
    // 10 % to 90 % are 2.563 s.
    const double perimeter =
        std::numbers::pi * std::sqrt(2 * 4 * (now.moments(0, 0) + now.moments(1, 1)));
    now.edge_width_px = 2.563 * std::sqrt(std::numbers::pi) * mixed / perimeter;
    if (round > 0 && shift.norm() < 1e-3) break;
  }
  return now;
}

}  // namespace watersky::detail
