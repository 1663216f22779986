// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/detail/chessboard.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace watersky::detail {

namespace {

/// The detector's time grows with the image; corners are refined at full size afterwards.
constexpr int kDetectionWidth_px = 1300;

double level(const cv::Mat& gray, const Eigen::Vector2d& p) {
  const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, gray.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(p.y())), 0, gray.rows - 1);
  return gray.at<unsigned char>(y, x);
}

}  // namespace

double squareness(const cv::Mat& gray, const DetectedTarget& board) {
  const auto at = [&](int row, int column) {
    const Pixel& p = board.points[static_cast<std::size_t>(row * board.size.columns + column)].seen;
    return Eigen::Vector2d(p.u, p.v);
  };
  std::vector<double> ratios;
  for (int row = 1; row + 1 < board.size.rows; ++row)
    for (int column = 1; column + 1 < board.size.columns; ++column) {
      // The light and the dark squares' difference, on the way from the corner to their middles.
      const auto step = [&](double way) {
        double sum = 0;
        for (const int down : {-1, 1})
          for (const int right : {-1, 1}) {
            const Eigen::Vector2d middle = 0.5 * (at(row, column) + at(row + down, column + right));
            sum += down * right * level(gray, at(row, column) + way * (middle - at(row, column)));
          }
        return sum;
      };
      const double full = step(1.0);
      ratios.push_back(std::abs(full) > 0 ? step(0.25) / full : 0);
    }
  if (ratios.empty()) return 0;
  const auto middle = ratios.begin() + static_cast<long>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

Result<DetectedTarget> detect_chessboard(const cv::Mat& gray, std::optional<TargetSize> size) {
  const int longest = std::max(gray.cols, gray.rows);
  const double scale = std::min(1.0, static_cast<double>(kDetectionWidth_px) / longest);
  cv::Mat small = gray;
  if (scale < 1) cv::resize(gray, small, {}, scale, scale, cv::INTER_AREA);
  // Its CALIB_CB_ACCURACY takes five times as long and adds nothing to what is refined below.
  const int base = cv::CALIB_CB_NORMALIZE_IMAGE;
  std::vector<cv::Point2f> corners;
  TargetSize found{3, 3};
  bool seen = false;
  try {
    if (size) {
      seen = cv::findChessboardCornersSB(small, {size->columns, size->rows}, corners, base);
      if (!seen)
        seen = cv::findChessboardCornersSB(small, {size->columns, size->rows}, corners,
                                           base | cv::CALIB_CB_EXHAUSTIVE);
      found = *size;
    } else {
      cv::Mat meta;
      seen = cv::findChessboardCornersSB(small, {3, 3}, corners, base | cv::CALIB_CB_LARGER, meta);
      if (seen) found = {meta.cols, meta.rows};
      seen = seen && found.points() == static_cast<int>(corners.size());
    }
  } catch (const cv::Exception&) {  // it refuses images smaller than its own filters
    seen = false;
  }
  if (!seen)
    return Error{ErrorCode::NotFound,
                 size ? "no chessboard with " + to_string(*size) + " inner corners is seen whole"
                      : "no chessboard is seen"};

  if (scale < 1)
    for (cv::Point2f& p : corners)
      p = {static_cast<float>((static_cast<double>(p.x) + 0.5) / scale - 0.5),
           static_cast<float>((static_cast<double>(p.y) + 0.5) / scale - 0.5)};
  const auto at = [&](int row, int column) {
    return corners[static_cast<std::size_t>(row * found.columns + column)];
  };
  // As large as the four squares that meet in a corner allow: measured on drawn boards, half a
  // square halves the error of a quarter.
  const std::vector<cv::Point2f> rough = corners;
  for (int row = 0; row < found.rows; ++row)
    for (int column = 0; column < found.columns; ++column) {
      const auto place = [&](int r, int c) {
        return rough[static_cast<std::size_t>(r * found.columns + c)];
      };
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& [r, c] : {std::pair(row - 1, column), std::pair(row + 1, column),
                                 std::pair(row, column - 1), std::pair(row, column + 1)})
        if (r >= 0 && c >= 0 && r < found.rows && c < found.columns)
          nearest = std::min(nearest, cv::norm(place(r, c) - place(row, column)));
      const int half = std::clamp(static_cast<int>(0.5 * nearest), 2, 30);
      std::vector<cv::Point2f> one{place(row, column)};
      cv::cornerSubPix(gray, one, {half, half}, {-1, -1},
                       {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-4});
      if (cv::norm(one[0] - place(row, column)) < half)
        corners[static_cast<std::size_t>(row * found.columns + column)] = one[0];
    }

  DetectedTarget target;
  target.kind = TargetKind::Chessboard;
  target.size = found;
  for (int row = 0; row < found.rows; ++row)
    for (int column = 0; column < found.columns; ++column) {
      const cv::Point2f p = at(row, column);
      target.points.push_back({{static_cast<double>(column), static_cast<double>(row)},
                               {static_cast<double>(p.x), static_cast<double>(p.y)}});
    }
  try {
    const cv::Scalar sharpness =
        cv::estimateChessboardSharpness(gray, {found.columns, found.rows}, corners);
    target.edge_width_px = sharpness[0];
    target.contrast = sharpness[2] - sharpness[1];
  } catch (const cv::Exception&) {  // the board is too near the rim for its profiles
  }
  return target;
}

}  // namespace watersky::detail
