// SPDX-License-Identifier: MIT
#pragma once
/// Frames of floes on water, for tests of segmenters.
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "watersky/vision/segmenter.hpp"

namespace watersky::test {

/// Round floes that do not touch, on at least `fraction` of the image if they find room.
inline cv::Mat floes(cv::RNG& rng, cv::Size size, double fraction, int largest_px = 60) {
  cv::Mat ice(size, CV_8U, cv::Scalar(0)), taken(size, CV_8U, cv::Scalar(0));
  const double target = fraction * static_cast<double>(ice.total());
  double radius = largest_px;
  int shrunk = 0;
  for (int miss = 0; target > 0 && shrunk < 200 && cv::countNonZero(ice) < target;) {
    const cv::Point centre(rng.uniform(0, size.width), rng.uniform(0, size.height));
    cv::Mat floe(size, CV_8U, cv::Scalar(0));
    const int r = static_cast<int>(radius);
    cv::ellipse(floe, centre, {r, std::max(2, r * 2 / 3)}, rng.uniform(0.0, 180.0), 0, 360, 255,
                -1);
    if (cv::countNonZero(floe & taken) > 0) {
      if (++miss > 20) {
        radius = std::max(4.0, 0.8 * radius);
        miss = 0;
        ++shrunk;
      }
      continue;
    }
    ice |= floe;
    cv::Mat wider;
    cv::dilate(floe, wider, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
    taken |= wider;
  }
  return ice;
}

/// A frame of sensor noise `sigma` with ice `contrast` above water.
inline cv::Mat frame(cv::RNG& rng, const cv::Mat& ice, double water, double contrast, double sigma,
                     int type = CV_8U) {
  cv::Mat level(ice.size(), CV_32F), noise(ice.size(), CV_32F), image;
  level.setTo(water);
  level.setTo(water + contrast, ice);
  rng.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat(level + noise).convertTo(image, type);
  return image;
}

inline cv::Mat ice_found(const Segmenter& segmenter, const cv::Mat& image,
                         const cv::Mat& valid = {}) {
  return segmenter.segment(image, valid).value() > 0.5;
}
inline double fraction(const cv::Mat& mask) {
  return cv::countNonZero(mask) / static_cast<double>(mask.total());
}
inline double error(const cv::Mat& found, const cv::Mat& ice) { return fraction(found ^ ice); }

inline const cv::Size kFrame{320, 256};

/// 255 where P(ice) is not NaN. (cv::compare says NaN == NaN.)
inline cv::Mat known(const cv::Mat& p_ice) {
  cv::Mat mask(p_ice.size(), CV_8U);
  for (int y = 0; y < p_ice.rows; ++y)
    for (int x = 0; x < p_ice.cols; ++x)
      mask.at<unsigned char>(y, x) = std::isnan(p_ice.at<float>(y, x)) ? 0 : 255;
  return mask;
}
inline double known_fraction(const cv::Mat& p_ice) { return fraction(known(p_ice)); }

/// The same frame under fog: `transmission` 1 is clear air, 0 shows nothing but fog and noise.
inline cv::Mat fogged(cv::RNG& rng, const cv::Mat& image, double transmission, double noise) {
  cv::Mat level, grain(image.size(), CV_32F), out;
  image.convertTo(level, CV_32F);
  level = (level - cv::mean(level)[0]) * transmission + cv::mean(level)[0];
  rng.fill(grain, cv::RNG::NORMAL, 0.0, noise);
  cv::Mat(level + grain).convertTo(out, image.type());
  return out;
}

}  // namespace watersky::test
