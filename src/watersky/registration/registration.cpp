// SPDX-License-Identifier: MIT
#include "watersky/registration/registration.hpp"

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/registration/detail/gray.hpp"
#include "watersky/registration/detail/registrars.hpp"

namespace watersky {

namespace {

constexpr std::array kMethods{RegistrationMethod::Klt, RegistrationMethod::Orb,
                              RegistrationMethod::Sift, RegistrationMethod::Akaze,
                              RegistrationMethod::Surf};

}  // namespace

std::span<const RegistrationMethod> registration_methods() { return kMethods; }

std::string_view name_of(RegistrationMethod method) {
  switch (method) {
    case RegistrationMethod::Klt: return "klt";
    case RegistrationMethod::Orb: return "orb";
    case RegistrationMethod::Sift: return "sift";
    case RegistrationMethod::Akaze: return "akaze";
    case RegistrationMethod::Surf: return "surf";
  }
  return "?";
}

std::optional<RegistrationMethod> registration_method(std::string_view name) {
  for (const RegistrationMethod method : kMethods)
    if (name_of(method) == name) return method;
  return std::nullopt;
}

Result<std::unique_ptr<Registrar>> make_registrar(RegistrationMethod method) {
  if (method == RegistrationMethod::Klt) return detail::make_klt_registrar();
  return detail::make_feature_registrar(method);
}

Status available(RegistrationMethod method) {
  WATERSKY_TRY(const auto made, make_registrar(method));
  return {};
}

cv::Mat draw_matches(const cv::Mat& a, const cv::Mat& b, const Registration& found,
                     int most_width_px) {
  const double scale = std::min(1.0, most_width_px / static_cast<double>(a.cols + b.cols));
  const auto shown = [scale](const cv::Mat& image) {
    cv::Mat small, color;
    cv::resize(detail::gray_of(image), small, {}, scale, scale,
               scale < 1 ? cv::INTER_AREA : cv::INTER_NEAREST);
    // Three spreads each way of the mean fill the range: little contrast is to be seen as well.
    cv::Scalar mean, spread;
    cv::meanStdDev(small, mean, spread);
    const double gain = 42.0 / std::max(spread[0], 0.5);
    small.convertTo(small, CV_8U, gain, 128.0 - gain * mean[0]);
    cv::cvtColor(small, color, cv::COLOR_GRAY2BGR);
    return color;
  };
  const cv::Mat left = shown(a), right = shown(b);
  cv::Mat out(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, cv::Scalar::all(0));
  left.copyTo(out(cv::Rect(0, 0, left.cols, left.rows)));
  right.copyTo(out(cv::Rect(left.cols, 0, right.cols, right.rows)));
  const auto in_a = [&](cv::Point2d p) { return cv::Point(p * scale); };
  const auto in_b = [&](cv::Point2d p) { return cv::Point(p * scale) + cv::Point(left.cols, 0); };

  const cv::Scalar detected(200, 160, 40), matched(60, 60, 220), inlier(80, 220, 60);
  for (const cv::Point2d& p : found.points_a) cv::circle(out, in_a(p), 3, detected, 1, cv::LINE_AA);
  for (const cv::Point2d& p : found.points_b) cv::circle(out, in_b(p), 3, detected, 1, cv::LINE_AA);
  const auto line = [&](const PointPair& pair, const cv::Scalar& color) {
    cv::circle(out, in_a(pair.a), 4, color, 1, cv::LINE_AA);
    cv::circle(out, in_b(pair.b), 4, color, 1, cv::LINE_AA);
    cv::line(out, in_a(pair.a), in_b(pair.b), color, 1, cv::LINE_AA);
  };
  for (const PointPair& pair : found.matches) line(pair, matched);
  if (found.fit)
    for (const PointPair& pair : found.fit->inliers) line(pair, inlier);
  return out;
}

}  // namespace watersky
