// SPDX-License-Identifier: MIT
#include "watersky/products/segmentation_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace watersky {

namespace {

constexpr float kUnsureFrom = 0.4F, kUnsureTo = 0.6F;

cv::Vec3b bgr(const Rgb& color) { return {color.blue, color.green, color.red}; }

void blend(cv::Vec3b& pixel, const cv::Vec3b& color, float weight) {
  for (int c = 0; c < 3; ++c)
    pixel[c] = cv::saturate_cast<unsigned char>((1.0F - weight) * static_cast<float>(pixel[c]) +
                                                weight * static_cast<float>(color[c]));
}

/// Lines and stripes grow with the picture, so that it can be looked at made smaller.
int stroke_px(const cv::Mat& image) { return 1 + std::max(image.cols, image.rows) / 900; }

bool on_stripe(int x, int y, int stroke) { return (x + y) % (7 * stroke) < 2 * stroke; }

}  // namespace

cv::Mat displayed(const cv::Mat& image) {
  cv::Mat shown = image;
  if (image.depth() == CV_16U) {
    std::vector<unsigned short> levels;
    const int step =
        std::max(1, static_cast<int>(std::sqrt(static_cast<double>(image.total()) / 40000)));
    for (int y = 0; y < image.rows; y += step) {
      const auto* row = image.ptr<unsigned short>(y);
      for (int x = 0; x < image.cols; x += step)
        for (int c = 0; c < image.channels(); ++c) levels.push_back(row[x * image.channels() + c]);
    }
    const auto quantile = [&](std::size_t percent) {
      const auto at = levels.begin() + static_cast<long>(percent * (levels.size() - 1) / 100);
      std::nth_element(levels.begin(), at, levels.end());
      return static_cast<double>(*at);
    };
    const double low = quantile(1), high = quantile(99);
    const double scale = high > low ? 255.0 / (high - low) : 1.0;
    image.convertTo(shown, CV_8U, scale, -scale * low);
  }
  cv::Mat color;
  if (shown.channels() == 3) {
    color = shown.clone();
  } else {
    cv::cvtColor(shown, color, cv::COLOR_GRAY2BGR);
  }
  return color;
}

cv::Mat overlay_picture(const cv::Mat& image, const cv::Mat& p_ice) {
  cv::Mat picture = displayed(image);
  const int stroke = stroke_px(image);
  cv::Mat ice(p_ice.size(), CV_8U);
  for (int y = 0; y < p_ice.rows; ++y) {
    const float* p = p_ice.ptr<float>(y);
    auto* pixel = picture.ptr<cv::Vec3b>(y);
    unsigned char* is_ice = ice.ptr(y);
    for (int x = 0; x < p_ice.cols; ++x) {
      is_ice[x] = p[x] > 0.5F ? 255 : 0;
      if (std::isnan(p[x])) {
        if (on_stripe(x, y, stroke)) blend(pixel[x], bgr(kUnknownStripes), 0.8F);
        continue;
      }
      // Deep enough to be seen at P2 of (2.31), deeper where surer.
      if (p[x] <= 0.5F) blend(pixel[x], bgr(kWaterTint), 0.35F + 0.35F * (1.0F - 2.0F * p[x]));
      if (p[x] > kUnsureFrom && p[x] < kUnsureTo && on_stripe(x, y, stroke))
        blend(pixel[x], bgr(kUnsureStripes), 0.7F);
    }
  }
  // The inner border: ice at the picture's edge is not outlined there.
  cv::Mat padded, eroded;
  cv::copyMakeBorder(ice, padded, stroke, stroke, stroke, stroke, cv::BORDER_REPLICATE);
  cv::erode(padded, eroded,
            cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * stroke + 1, 2 * stroke + 1)));
  const cv::Mat inside = eroded(cv::Rect(stroke, stroke, ice.cols, ice.rows));
  picture.setTo(cv::Scalar(kIceOutline.blue, kIceOutline.green, kIceOutline.red), ice & ~inside);
  return picture;
}

cv::Mat error_picture(const cv::Mat& image, const cv::Mat& p_ice, const cv::Mat& ice,
                      const cv::Mat& judged) {
  cv::Mat gray, picture;
  cv::cvtColor(displayed(image), gray, cv::COLOR_BGR2GRAY);
  gray.convertTo(gray, CV_8U, 0.7, 40.0);
  cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
  const int stroke = stroke_px(image);
  for (int y = 0; y < p_ice.rows; ++y) {
    const float* p = p_ice.ptr<float>(y);
    const unsigned char* truth = ice.ptr(y);
    const unsigned char* asked = judged.empty() ? nullptr : judged.ptr(y);
    auto* pixel = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < p_ice.cols; ++x) {
      if (asked && !asked[x]) continue;
      if (std::isnan(p[x])) {
        if (on_stripe(x, y, stroke)) blend(pixel[x], bgr(kUnknownStripes), 0.8F);
      } else if ((p[x] > 0.5F) != (truth[x] != 0)) {
        blend(pixel[x], bgr(truth[x] ? kMissedIce : kFalseIce), 0.85F);
      }
    }
  }
  return picture;
}

cv::Mat probability_picture(const cv::Mat& p_ice) {
  cv::Mat picture(p_ice.size(), CV_8U);
  for (int y = 0; y < p_ice.rows; ++y) {
    const float* p = p_ice.ptr<float>(y);
    unsigned char* out = picture.ptr(y);
    for (int x = 0; x < p_ice.cols; ++x)
      out[x] = std::isnan(p[x])
                   ? kUnknownProbability
                   : static_cast<unsigned char>(std::lround(255.0F * std::clamp(p[x], 0.0F, 1.0F)));
  }
  return picture;
}

cv::Mat unknown_picture(const cv::Mat& p_ice) {
  cv::Mat picture(p_ice.size(), CV_8U, cv::Scalar(0));
  bool any = false;
  for (int y = 0; y < p_ice.rows; ++y) {
    const float* p = p_ice.ptr<float>(y);
    for (int x = 0; x < p_ice.cols; ++x)
      if (std::isnan(p[x])) {
        picture.ptr(y)[x] = 255;
        any = true;
      }
  }
  return any ? picture : cv::Mat();
}

}  // namespace watersky
