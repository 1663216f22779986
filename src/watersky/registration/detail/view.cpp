// SPDX-License-Identifier: MIT
#include "watersky/registration/detail/view.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace watersky::detail {

namespace {

constexpr int kCoarse_px = 320, kTiny_px = 80, kFeature_px = 900;
/// Beyond this the feature view is finer than the coarse one; below it SIFT's time counts.
constexpr int kLarge_px = 800;
/// Of the best corner: no threshold that contrast could miss.
constexpr double kQuality = 0.01;
constexpr int kCoarseCorners = 160;
constexpr double kCoarseApart_px = 9.0;
/// Means are taken over windows of this part of the view's width.
constexpr double kWindow = 0.1;
/// Rounding to whole levels, rms: nothing below it is texture.
constexpr double kRounding = 0.29;
/// A quiet part of the picture is raised to at most this times the spread of the whole.
constexpr double kLeastOfSpread = 0.15;
/// And to at least this times what noise is left there, lest noise and fixed pattern look like ice.
constexpr double kLeastOfNoise = 2.0;
/// Where the local spread is not this times what noise alone makes, there is nothing to see.
constexpr double kTextured = 1.4;
/// Texture over noise that blurring aims at, within these sigmas.
constexpr double kTextureOverNoise = 4.0, kLeastBlur_px = 0.7, kMostBlur_px = 3.0;

int reduction_to(cv::Size size, int wanted_px) {
  return std::max(1, static_cast<int>(std::lround(std::max(size.width, size.height) /
                                                  static_cast<double>(wanted_px))));
}

/// By whole factors; what does not fill a pixel at the right and bottom is left out.
cv::Mat reduced(const cv::Mat& image, int s, int depth) {
  cv::Mat out;
  if (s == 1) {
    image.convertTo(out, depth);
    return out;
  }
  const cv::Size size(std::max(1, image.cols / s), std::max(1, image.rows / s));
  const cv::Mat whole = image(
      cv::Rect(0, 0, std::min(image.cols, size.width * s), std::min(image.rows, size.height * s)));
  cv::Mat wide;
  whole.convertTo(wide, depth);
  cv::resize(wide, out, size, 0, 0, cv::INTER_AREA);
  return out;
}

cv::Mat reduced_mask(const cv::Mat& valid, int s) {
  if (valid.empty()) return {};
  cv::Mat out = reduced(valid, s, CV_32F);
  return out > 254.0;
}

int window(cv::Size size) {
  return std::max(9, static_cast<int>(kWindow * std::max(size.width, size.height)) | 1);
}

/// The image less its local mean, unless masked.
cv::Mat flattened(cv::Mat image, const cv::Mat& valid, int width) {
  cv::Mat mean;
  const cv::Size box(width, width);
  if (!valid.empty()) {
    image.setTo(cv::mean(image, valid), ~valid);  // or their levels would spread
  }
  cv::boxFilter(image, mean, CV_32F, box, {-1, -1}, true, cv::BORDER_REFLECT);
  image -= mean;
  if (!valid.empty()) image.setTo(0, ~valid);
  return image;
}

/// What whole columns and rows share after flattening is the sensor's: without it two thermal
/// frames agree best where neither has moved. A scene lends them next to nothing.
void take_out_stripes(cv::Mat& image) {
  cv::Mat columns, rows;
  cv::reduce(image, columns, 0, cv::REDUCE_AVG);
  cv::reduce(image, rows, 1, cv::REDUCE_AVG);
  for (int y = 0; y < image.rows; ++y) {
    float* level = image.ptr<float>(y);
    const float* column = columns.ptr<float>(0);
    const float row = rows.at<float>(y);
    for (int x = 0; x < image.cols; ++x) level[x] -= column[x] + row;
  }
}

double mean_square(const cv::Mat& image) {
  return image.dot(image) / static_cast<double>(std::max<std::size_t>(1, image.total()));
}

/// White noise from diagonal differences of 2x2 pixels, in the quietest fifth of blocks of 16x16.
double noise_of(const cv::Mat& image) {
  constexpr int kBlock = 16;
  std::vector<float> squares;
  for (int y0 = 0; y0 + kBlock < image.rows; y0 += kBlock)
    for (int x0 = 0; x0 + kBlock < image.cols; x0 += kBlock) {
      float sum = 0.0F;
      for (int y = y0; y < y0 + kBlock; ++y) {
        const float* p = image.ptr<float>(y);
        const float* q = image.ptr<float>(y + 1);
        for (int x = x0; x < x0 + kBlock; ++x) {
          const float d = p[x] - p[x + 1] - q[x] + q[x + 1];
          sum += d * d;
        }
      }
      squares.push_back(sum / (4.0F * kBlock * kBlock));
    }
  if (squares.empty()) return 0.0;
  const auto at = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 5);
  std::nth_element(squares.begin(), at, squares.end());
  return std::sqrt(static_cast<double>(*at));
}

/// What a Gaussian of `sigma` pixels leaves of white noise.
double noise_left(double sigma) { return std::min(1.0, 1.0 / (2.0 * std::sqrt(CV_PI) * sigma)); }

double blur_against(double noise, double texture) {
  const double sigma =
      kTextureOverNoise * noise / (2.0 * std::sqrt(CV_PI) * std::max(texture, 1e-9));
  return std::clamp(sigma, kLeastBlur_px, kMostBlur_px);
}

void blur(cv::Mat& image, double sigma) {
  const int width = 2 * static_cast<int>(std::ceil(2.0 * sigma)) + 1;
  cv::GaussianBlur(image, image, {width, width}, sigma);
}

}  // namespace

Eigen::Matrix3d full_from_reduced(int reduction) {
  Eigen::Matrix3d m;
  const double s = reduction, shift = (s - 1.0) / 2.0;
  m << s, 0, shift, 0, s, shift, 0, 0, 1;
  return m;
}

Eigen::Matrix3d View::full_from_view() const { return full_from_reduced(reduction); }

View even_view(const cv::Mat& gray, const cv::Mat& valid, int s) {
  View view;
  view.reduction = s;
  view.valid = reduced_mask(valid, s);
  cv::Mat image = reduced(gray, s, CV_32F);
  const int width = window(image.size());
  view.noise = noise_of(image);
  image = flattened(std::move(image), view.valid, width);
  take_out_stripes(image);
  view.texture = std::sqrt(std::max(0.0, mean_square(image) - view.noise * view.noise));
  view.blur_px = blur_against(view.noise, view.texture);
  const double left = view.noise * noise_left(view.blur_px);
  blur(image, view.blur_px);
  cv::Mat spread;
  cv::sqrBoxFilter(image, spread, CV_32F, {width, width}, {-1, -1}, true, cv::BORDER_REFLECT);
  const double floor =
      std::max({kRounding / s, kLeastOfSpread * view.texture, kLeastOfNoise * left});
  const auto least = static_cast<float>(floor * floor);
  const auto middle = static_cast<float>(kMiddle + 0.5), gain = static_cast<float>(kGain);
  const auto quiet = static_cast<float>(std::pow(std::max(kRounding / s, kTextured * left), 2));
  view.levels.create(image.size(), CV_8U);
  view.textured.create(image.size(), CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    const float* from = image.ptr<float>(y);
    const float* square = spread.ptr<float>(y);
    std::uint8_t* to = view.levels.ptr<std::uint8_t>(y);
    std::uint8_t* textured = view.textured.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      const float value = middle + gain * from[x] / std::sqrt(std::max(square[x], least));
      to[x] = static_cast<std::uint8_t>(std::min(std::max(value, 0.0F), 255.0F));
      textured[x] = square[x] > quiet ? 255 : 0;
    }
  }
  return view;
}

std::vector<cv::Point2f> corners_in(const View& view, int most, double apart_px) {
  std::vector<cv::Point2f> corners;
  cv::Mat mask = view.textured;
  if (!view.valid.empty()) {
    cv::erode(view.valid, mask, cv::Mat::ones(9, 9, CV_8U));
    if (!view.textured.empty()) mask &= view.textured;
  }
  cv::goodFeaturesToTrack(view.levels, corners, most, kQuality, apart_px, mask, 5);
  return corners;
}

std::vector<cv::Point2f> Scale::corners(int most, const std::vector<cv::Point2f>& outline) const {
  std::vector<cv::Point2f> found;
  cv::Mat mask;
  if (valid.empty())
    mask = cv::Mat(pixels.size(), CV_8U, cv::Scalar(255));
  else
    cv::erode(valid, mask, cv::Mat::ones(9, 9, CV_8U));
  std::vector<cv::Point> polygon;
  polygon.reserve(outline.size());
  for (const cv::Point2f& p : outline) polygon.emplace_back(cvRound(p.x), cvRound(p.y));
  cv::Mat inside(pixels.size(), CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(inside, polygon, 255);
  mask &= inside;
  const double apart_px = 0.6 * std::sqrt(cv::countNonZero(mask) / static_cast<double>(most));
  cv::goodFeaturesToTrack(pixels, found, most, kQuality, std::max(4.0, apart_px), mask, 5);
  return found;
}

Scale KltFrame::coarse_scale() const {
  Scale scale{coarse_.reduction, {}, coarse_.valid};
  coarse_.levels.convertTo(scale.pixels, CV_32F);
  return scale;
}

KltFrame::KltFrame(cv::Mat gray, cv::Mat valid) : gray_(std::move(gray)), valid_(std::move(valid)) {
  size = gray_.size();
  const int s = reduction_to(size, kCoarse_px);
  coarse_ = even_view(gray_, valid_, s);
  for (int next = s; next > 1;) {
    next = std::max(1, static_cast<int>(std::lround(next / 3.0)));
    finer_reductions_.push_back(next);
  }
  finer_.resize(finer_reductions_.size());
  finer_once_ = std::make_unique<std::once_flag[]>(finer_.size());

  tiny_reduction_ = reduction_to(coarse_.size(), kTiny_px);
  cv::Mat informed(coarse_.size(), CV_8U, cv::Scalar(kMiddle));
  coarse_.levels.copyTo(informed, coarse_.textured);
  cv::Mat(reduced(informed, tiny_reduction_, CV_32F) - kMiddle).copyTo(tiny_);
  cv::Mat across(1, tiny_.cols, CV_32F), down(tiny_.rows, 1, CV_32F);
  const auto taper = [](int i, int n) {
    const double edge = std::min(i + 0.5, n - i - 0.5) / (0.15 * n);
    return edge >= 1 ? 1.0F : static_cast<float>(0.5 - 0.5 * std::cos(CV_PI * edge));
  };
  for (int x = 0; x < tiny_.cols; ++x) across.at<float>(x) = taper(x, tiny_.cols);
  for (int y = 0; y < tiny_.rows; ++y) down.at<float>(y) = taper(y, tiny_.rows);
  tiny_ = tiny_.mul(cv::Mat(down * across));
}

const std::vector<cv::Point2f>& KltFrame::coarse_corners() const {
  std::call_once(corners_once_, [this] {
    // Where little of the picture shows anything, what does is looked at closer.
    const double share =
        cv::countNonZero(coarse_.textured) / static_cast<double>(coarse_.textured.total());
    const double apart = kCoarseApart_px * std::clamp(std::sqrt(share), 0.5, 1.0);
    corners_ = corners_in(coarse_, kCoarseCorners, apart);
  });
  return corners_;
}

const Scale& KltFrame::finer(std::size_t i) const {
  std::call_once(finer_once_[i], [this, i] {
    const int s = finer_reductions_[i];
    finer_[i] = {s, reduced(gray_, s, CV_32F), reduced_mask(valid_, s)};
  });
  return finer_[i];
}

double KltFrame::finer_blur_px(std::size_t i) const {
  // Noise is white: its share grows as pixels shrink.
  const double ratio = static_cast<double>(coarse_.reduction) / finer_reductions_[i];
  return blur_against(coarse_.noise * ratio, coarse_.texture);
}

const Features& KltFrame::features() const {
  std::call_once(features_once_, [this] {
    const int s = reduction_to(size, kFeature_px);
    if (std::max(size.width, size.height) > kLarge_px && s != coarse_.reduction) {
      feature_own_ = even_view(gray_, valid_, s);
      feature_view_ = &feature_own_;
    } else {
      feature_view_ = &coarse_;
    }
    // Contrast is even already: low thresholds let through what ice has.
    if (feature_view_ == &coarse_) {
      const auto orb = cv::ORB::create(300, 1.25F, 4, 15, 0, 2, cv::ORB::HARRIS_SCORE, 31, 10);
      orb->detectAndCompute(feature_view_->levels, feature_view_->valid, features_.keypoints,
                            features_.descriptors);
      return;
    }
    const auto sift = cv::SIFT::create(3000, 3, 0.02, 10, 1.6);
    sift->detectAndCompute(feature_view_->levels, feature_view_->valid, features_.keypoints,
                           features_.descriptors);
    for (int i = 0; i < features_.descriptors.rows; ++i) {  // RootSIFT
      cv::Mat row = features_.descriptors.row(i);
      row /= std::max(1e-6, cv::norm(row, cv::NORM_L1));
      cv::sqrt(row, row);
    }
  });
  return features_;
}

}  // namespace watersky::detail
