// SPDX-License-Identifier: MIT
/// The thesis's section 4.3.2, step by step.
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#ifdef WATERSKY_HAS_XFEATURES2D
#include <opencv2/xfeatures2d/nonfree.hpp>
#endif

#include "watersky/registration/detail/gray.hpp"
#include "watersky/registration/detail/registrars.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky::detail {

namespace {

/// OpenCV's default for findHomography, which the thesis takes ("standard parameters").
constexpr double kRansacThreshold_px = 3.0;

struct FeatureFrame final : RegistrationFrame::Data {
  const Registrar* made_by = nullptr;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

Result<cv::Ptr<cv::Feature2D>> make_detector(RegistrationMethod method) {
  const Error absent{ErrorCode::Unsupported,
                     "SURF is not in this build's OpenCV (it is in the nonfree part of contrib); "
                     "take another method"};
  try {
    switch (method) {
      case RegistrationMethod::Orb: return cv::Ptr<cv::Feature2D>(cv::ORB::create());
      case RegistrationMethod::Sift: return cv::Ptr<cv::Feature2D>(cv::SIFT::create());
      case RegistrationMethod::Akaze: return cv::Ptr<cv::Feature2D>(cv::AKAZE::create());
      case RegistrationMethod::Surf:
#ifdef WATERSKY_HAS_XFEATURES2D
        return cv::Ptr<cv::Feature2D>(cv::xfeatures2d::SURF::create());
#else
        return absent;
#endif
      case RegistrationMethod::Klt: break;
    }
  } catch (const cv::Exception&) {  // Debian builds contrib without its nonfree part
    return absent;
  }
  return Error{ErrorCode::Usage, "not a method that matches features"};
}

cv::Point2d point(const cv::KeyPoint& keypoint) { return keypoint.pt; }

class FeatureRegistrar final : public Registrar {
 public:
  FeatureRegistrar(RegistrationMethod method, const cv::Ptr<cv::Feature2D>& detector)
      : method_(method), norm_(detector->defaultNorm()) {}

  Result<RegistrationFrame> prepare(const cv::Mat& image, const cv::Mat& valid) const override {
    WATERSKY_CHECK(check_frame(image, valid));
    // A detector of its own for each call: OpenCV's keep state.
    WATERSKY_TRY(const auto detector, make_detector(method_));
    auto frame = std::make_shared<FeatureFrame>();
    frame->made_by = this;
    frame->size = image.size();
    try {
      detector->detectAndCompute(gray_8_bit(image), valid, frame->keypoints, frame->descriptors);
    } catch (const cv::Exception&) {  // a picture too small for its pyramid: nothing found
      frame->keypoints.clear();
      frame->descriptors.release();
    }
    return RegistrationFrame(std::move(frame));
  }

  Result<Registration> align(const RegistrationFrame& a, const RegistrationFrame& b,
                             const std::optional<Eigen::Matrix3d>&) const override {
    const auto* fa = dynamic_cast<const FeatureFrame*>(a.data());
    const auto* fb = dynamic_cast<const FeatureFrame*>(b.data());
    if (!fa || !fb || fa->made_by != this || fb->made_by != this)
      return Error{ErrorCode::Usage, "frames must be prepared by the registrar that aligns them"};
    Registration found;
    for (const cv::KeyPoint& k : fa->keypoints) found.points_a.push_back(point(k));
    for (const cv::KeyPoint& k : fb->keypoints) found.points_b.push_back(point(k));
    if (fa->descriptors.empty() || fb->descriptors.empty()) {
      found.reason = "no feature was found in " + std::string(fa->descriptors.empty() ? "A" : "B");
      return found;
    }
    match(*fa, *fb, found);
    estimate(found, fa->size);
    return found;
  }

 private:
  /// Each keypoint of the later picture B to its nearest of the earlier one, A.
  void match(const FeatureFrame& a, const FeatureFrame& b, Registration& found) const {
    std::vector<cv::DMatch> nearest;
    cv::BFMatcher(norm_).match(b.descriptors, a.descriptors, nearest);
    std::vector<float> distances;
    distances.reserve(nearest.size());
    for (const cv::DMatch& m : nearest) distances.push_back(m.distance);
    for (const std::size_t i : within_twice_least(distances))
      found.matches.push_back({point(a.keypoints[static_cast<std::size_t>(nearest[i].trainIdx)]),
                               point(b.keypoints[static_cast<std::size_t>(nearest[i].queryIdx)])});
  }

  static void estimate(Registration& found, cv::Size a_size) {
    if (found.matches.size() < kThesisFewestMatches) {
      found.reason = std::to_string(found.matches.size()) + " matches are left, 4 are needed";
      return;
    }
    std::vector<cv::Point2f> from, to;
    for (const PointPair& m : found.matches) {
      from.emplace_back(m.a);
      to.emplace_back(m.b);
    }
    cv::Mat h, mask;
    try {
      h = cv::findHomography(from, to, cv::RANSAC, kRansacThreshold_px, mask);
    } catch (const cv::Exception&) {
      h.release();  // degenerate beyond what it takes
    }
    if (h.empty()) {
      found.reason = "RANSAC found no homography";
      return;
    }
    HomographyFit fit;
    for (int i = 0; i < 9; ++i) fit.b_from_a(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
    for (std::size_t i = 0; i < found.matches.size(); ++i)
      if (mask.at<std::uint8_t>(static_cast<int>(i)) != 0) fit.inliers.push_back(found.matches[i]);
    found.inliers = fit.inliers.size();
    measure_reprojection(found, fit.b_from_a, fit.inliers);
    if (!(found.mean_reprojection_px < kThesisMostMean_px)) {
      found.reason = "the mean reprojection error of the matches is not below 5 px";
      return;
    }
    // The thesis's homography stays as RANSAC gave it; only its covariance is ours.
    if (const auto known = fit_homography(fit.inliers, fit.b_from_a, a_size)) {
      fit.covariance = known->covariance;
      fit.corner_covariance = known->corner_covariance;
      fit.corner_sigma_px = known->corner_sigma_px;
    } else {
      // Four pairs, or a line of them, fit whatever their errors: nothing is known of it.
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      fit.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
      fit.corner_covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
      fit.corner_sigma_px = kInfinity;
    }
    found.fit = std::move(fit);
  }

  RegistrationMethod method_;
  int norm_;
};

}  // namespace

std::vector<std::size_t> within_twice_least(std::span<const float> distances) {
  std::vector<std::size_t> kept;
  if (distances.empty()) return kept;
  float least = distances[0];
  for (const float d : distances) least = std::min(least, d);
  for (std::size_t i = 0; i < distances.size(); ++i)
    if (distances[i] <= kThesisTimesLeast * least) kept.push_back(i);
  return kept;
}

void measure_reprojection(Registration& found, const Eigen::Matrix3d& b_from_a,
                          std::span<const PointPair> inliers) {
  const auto mean = [&](std::span<const PointPair> pairs) {
    double sum = 0.0;
    for (const PointPair& pair : pairs) {
      const double error = cv::norm(watersky::apply(b_from_a, pair.a) - pair.b);
      sum += std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
    }
    return pairs.empty() ? std::numeric_limits<double>::quiet_NaN()
                         : sum / static_cast<double>(pairs.size());
  };
  found.mean_reprojection_px = mean(found.matches);
  found.inlier_mean_px = mean(inliers);
}

Result<std::unique_ptr<Registrar>> make_feature_registrar(RegistrationMethod method) {
  WATERSKY_TRY(const auto detector, make_detector(method));
  return std::unique_ptr<Registrar>(std::make_unique<FeatureRegistrar>(method, detector));
}

}  // namespace watersky::detail
