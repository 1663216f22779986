// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/target_detection.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "watersky/target_calibration/detail/blobs.hpp"
#include "watersky/target_calibration/detail/chessboard.hpp"
#include "watersky/target_calibration/detail/lattice.hpp"

namespace watersky {

namespace {

using namespace detail;

/// Circles are looked for at this size and measured at full size.
constexpr int kSearchWidth_px = 1000;

cv::Mat gray_float(const cv::Mat& image) {
  cv::Mat gray = image, out;
  if (image.channels() == 3) cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, gray, cv::COLOR_BGRA2GRAY);
  gray.convertTo(out, CV_32F);
  return out;
}

/// From its 0.5 % to its 99.5 % quantile: a thermal image of a few kelvins, or one hot pixel.
cv::Mat stretched(const cv::Mat& gray) {
  std::vector<float> levels;
  const int step =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(gray.total()) / 40000)));
  for (int y = 0; y < gray.rows; y += step)
    for (int x = 0; x < gray.cols; x += step) levels.push_back(gray.at<float>(y, x));
  const auto quantile = [&](double share) {
    const auto at = levels.begin() + std::lround(share * static_cast<double>(levels.size() - 1));
    std::nth_element(levels.begin(), at, levels.end());
    return static_cast<double>(*at);
  };
  const double low = quantile(0.005), high = quantile(0.995);
  const double scale = high > low ? 255.0 / (high - low) : 1.0;
  cv::Mat out;
  gray.convertTo(out, CV_8U, scale, -scale * low);
  return out;
}

struct FoundLattice {
  ReadLattice read;
  std::vector<Blob> blobs;
  bool bright = false;
};

/// The largest lattice over all sizes of window and both polarities.
std::optional<FoundLattice> find_circles(const cv::Mat& small, const TargetRequest& request) {
  std::optional<FoundLattice> best;
  const double noise = noise_of(small);
  const int longest = std::max(small.cols, small.rows);
  for (const int parts : {6, 12, 24, 48}) {
    const int window = std::max(5, longest / parts) | 1;
    for (const bool bright : {false, true}) {
      std::vector<Blob> blobs = find_blobs(small, window, bright, noise);
      std::vector<LatticeCandidate> candidates;
      for (const Blob& blob : blobs) candidates.push_back({blob.centre, blob.area_px2()});
      const Lattice lattice = find_lattice(candidates);
      auto read = read_lattice(lattice, candidates, request.kind, request.size);
      if (!read || (best && read->points.size() <= best->read.points.size())) continue;
      best = FoundLattice{*std::move(read), std::move(blobs), bright};
    }
  }
  return best;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Radius of the discs in lattice steps: their area against that of the lattice's cells.
double disc_radius(const ReadLattice& read, const std::map<std::pair<int, int>, Blob>& blobs) {
  const int step = read.kind == TargetKind::AsymmetricCircles ? 2 : 1;
  std::vector<double> radii;
  for (const auto& [index, blob] : blobs) {
    const auto right = blobs.find({index.first + step, index.second});
    const auto left = blobs.find({index.first - step, index.second});
    const auto below = blobs.find({index.first, index.second + step});
    const auto above = blobs.find({index.first, index.second - step});
    if (right == blobs.end() || left == blobs.end() || below == blobs.end() || above == blobs.end())
      continue;
    const Eigen::Vector2d u = (right->second.centre - left->second.centre) / (2 * step);
    const Eigen::Vector2d v = (below->second.centre - above->second.centre) / (2 * step);
    const double cell = std::abs(u.x() * v.y() - u.y() * v.x());
    radii.push_back(std::sqrt(blob.area_px2() / std::numbers::pi / cell));
  }
  return radii.empty() ? 0.0 : median(radii);
}

std::string circles_of(const TargetRequest& request) {
  const TargetKind kind = request.kind.value_or(TargetKind::Circles);
  return kind == TargetKind::Holes ? "holes" : "circles";
}

Result<DetectedTarget> detect_circles(const cv::Mat& gray, const TargetRequest& request) {
  const int longest = std::max(gray.cols, gray.rows);
  const double scale = std::min(1.0, static_cast<double>(kSearchWidth_px) / longest);
  cv::Mat small = gray;
  if (scale < 1) cv::resize(gray, small, {}, scale, scale, cv::INTER_AREA);
  const auto found = find_circles(small, request);
  if (!found) return Error{ErrorCode::NotFound, "no grid of " + circles_of(request) + " is seen"};

  std::map<std::pair<int, int>, Blob> blobs;
  for (const auto& [index, i] : found->read.points) {
    Blob blob = found->blobs[i];
    blob.centre = (blob.centre + Eigen::Vector2d(0.5, 0.5)) / scale - Eigen::Vector2d(0.5, 0.5);
    blob.moments /= scale * scale;
    if (const auto refined = refine_blob(gray, blob)) blobs[index] = *refined;
  }
  const bool staggered = found->read.kind == TargetKind::AsymmetricCircles;
  const TargetSize seen = found->read.size;
  const auto wanted = static_cast<double>(request.size ? request.size->points() : seen.points());
  if (blobs.size() < 9 || static_cast<double>(blobs.size()) < 0.5 * wanted)
    return Error{ErrorCode::NotFound, "only " + std::to_string(blobs.size()) + " of " +
                                          std::to_string(static_cast<int>(wanted)) + " " +
                                          circles_of(request) + " can be measured"};
  if (seen.rows < 3 || seen.columns < (staggered ? 2 : 3))
    return Error{ErrorCode::NotFound,
                 "only a strip of " + to_string(seen) + " " + circles_of(request) + " is seen"};

  DetectedTarget target;
  target.kind = request.kind.value_or(found->read.kind);
  target.size = seen;
  target.bright = found->bright;
  target.radius = disc_radius(found->read, blobs);
  std::vector<double> widths, contrasts;
  for (const auto& [index, blob] : blobs) {
    widths.push_back(blob.edge_width_px);
    contrasts.push_back(std::abs(blob.contrast));
  }
  target.edge_width_px = median(widths);
  target.contrast = median(contrasts);
  for (int row = 0; row < seen.rows; ++row)  // the map is by columns
    for (int column = 0; column < (staggered ? 2 : 1) * seen.columns + 1; ++column)
      if (const auto it = blobs.find({column, row}); it != blobs.end())
        target.points.push_back({{static_cast<double>(column), static_cast<double>(row)},
                                 {it->second.centre.x(), it->second.centre.y()}});
  return target;
}

}  // namespace

Result<DetectedTarget> detect_target(const cv::Mat& image, const TargetRequest& request) {
  if (image.empty() || image.cols < 32 || image.rows < 32)
    return Error{ErrorCode::NotFound, "the image is smaller than 32x32 pixels"};
  const cv::Mat gray = gray_float(image);
  if (request.kind == TargetKind::Chessboard)
    return detect_chessboard(stretched(gray), request.size);
  auto circles = detect_circles(gray, request);
  if (request.kind) return circles;
  // Between circles the detector of chessboards sees corners, and a chessboard's dark squares are
  // a grid of spots. A chessboard has contrast up to its corners, and more corners than spots.
  const cv::Mat shown = stretched(gray);
  auto board = detect_chessboard(shown, request.size);
  constexpr double kSquare = 0.35;
  if (board && (!circles || (squareness(shown, *board) > kSquare &&
                             board->points.size() > circles->points.size())))
    return board;
  if (!circles && !request.kind)
    return Error{ErrorCode::NotFound,
                 "neither a chessboard nor a grid of circles or holes is seen" +
                     (request.size ? " of " + to_string(*request.size) : std::string())};
  return circles;
}

}  // namespace watersky
