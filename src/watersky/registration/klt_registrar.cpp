// SPDX-License-Identifier: MIT
/// Starts, tracking at rising scale, and the judgement of what comes out.
#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/registration/detail/gray.hpp"
#include "watersky/registration/detail/registrars.hpp"
#include "watersky/registration/detail/start.hpp"
#include "watersky/registration/detail/tracking.hpp"
#include "watersky/registration/detail/view.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky::detail {

namespace {

constexpr int kSmallest_px = 48;
constexpr std::string_view kFromFeatures = "features";
constexpr std::size_t kFewestInliers = 14;
constexpr std::size_t kFewestReturned = 10;
constexpr std::size_t kFarCorners = 100;
constexpr int kDenseCorners = 500;
constexpr double kDenseApart_px = 4.0;
constexpr int kFineCorners = 300;           ///< at scales where they are looked for anew
constexpr double kLeastInlierShare = 0.25;  ///< of what was tracked
/// Pictures of different places have correlation peaks of 3 to 5 spreads, of one place 6 to 40.
constexpr double kLeastPeak = 5.0;
constexpr double kLeastOverlap = 0.12;
/// Flat ice correlates to 0.6 and more, trees seen from 40 m, which no homography fits, to 0.3;
/// different places seldom come as far as being asked.
constexpr double kLeastCorrelation = 0.16;
constexpr double kGoodCorrelation = 0.4;
constexpr double kLeastChances = 8.0;
constexpr double kLeastPatches = 0.35;
/// A picture that has not moved is also what a sensor's fixed pattern says.
constexpr double kStill_px = 1.0, kLeastStillCorrelation = 0.5;
/// Predicted error of the worst corner, of the picture's diagonal.
constexpr double kMostCornerSigma = 0.0033;
/// Where noise asks for more blur than this a finer scale tells nothing that the coarser did not.
constexpr double kMostBlur_px = 1.5;
/// A finer scale may move the corners inside the overlap by so much, px of the scale before.
constexpr double kMostMove_px = 2.5;

std::string text(const char* format, double a, double b = 0) {
  char line[160];
  std::snprintf(line, sizeof line, format, a, b);
  return line;
}

/// Between full pictures from between reduced ones, and back.
Eigen::Matrix3d to_full(int a, int b, const Eigen::Matrix3d& h) {
  Eigen::Matrix3d full = full_from_reduced(b) * h * full_from_reduced(a).inverse();
  return full / full(2, 2);
}
Eigen::Matrix3d to_reduced(int a, int b, const Eigen::Matrix3d& full) {
  return full_from_reduced(b).inverse() * full * full_from_reduced(a);
}
std::vector<PointPair> to_full(int a, int b, std::span<const PointPair> pairs) {
  const auto full = [](double s, cv::Point2d p) {
    return cv::Point2d(s * p.x + (s - 1) / 2, s * p.y + (s - 1) / 2);
  };
  std::vector<PointPair> out;
  out.reserve(pairs.size());
  for (const PointPair& pair : pairs)
    out.push_back({full(a, pair.a), full(b, pair.b), pair.covariance * (1.0 * b * b)});
  return out;
}
std::optional<HomographyFit> to_full(int a, int b, const HomographyFit& fit, cv::Size a_size) {
  return fit_homography(to_full(a, b, fit.inliers), to_full(a, b, fit.b_from_a), a_size);
}

double worst_corner_sigma_px(const HomographyFit& fit) {
  double worst = 0.0;
  for (int k = 0; k < 4; ++k)
    worst = std::max(worst, fit.corner_covariance.block<2, 2>(2 * k, 2 * k).trace());
  return std::sqrt(worst);
}

/// How far two homographies differ over what `pairs` cover.
double largest_move(std::span<const PointPair> pairs, const Eigen::Matrix3d& one,
                    const Eigen::Matrix3d& other) {
  double most = 0.0;
  for (const PointPair& pair : pairs)
    most = std::max(most, cv::norm(apply(one, pair.a) - apply(other, pair.a)));
  return most;
}

/// What of A is seen in B, in pixels of A reduced.
std::vector<cv::Point2f> overlap_in(cv::Size a, cv::Size b, const Eigen::Matrix3d& b_from_a,
                                    int reduction) {
  const Eigen::Matrix3d to_here = full_from_reduced(reduction).inverse();
  std::vector<cv::Point2f> of_a, of_b, both;
  for (const cv::Point2d& p : corners_of(a)) of_a.emplace_back(apply(to_here, p));
  const Eigen::Matrix3d a_from_b = b_from_a.inverse();
  for (const cv::Point2d& p : corners_of(b)) {
    const cv::Point2d q = apply(a_from_b, p);
    if (!std::isfinite(q.x)) return of_a;  // B reaches beyond what A can see
    of_b.emplace_back(apply(to_here, q));
  }
  cv::intersectConvexConvex(of_a, of_b, both);
  return both.size() < 3 ? of_a : both;
}

class KltRegistrar final : public Registrar {
 public:
  Result<RegistrationFrame> prepare(const cv::Mat& image, const cv::Mat& valid) const override {
    WATERSKY_CHECK(check_frame(image, valid));
    return RegistrationFrame(std::make_shared<KltFrame>(gray_of(image), valid));
  }

  Result<Registration> align(const RegistrationFrame& a, const RegistrationFrame& b,
                             const std::optional<Eigen::Matrix3d>& start) const override {
    const auto* fa = dynamic_cast<const KltFrame*>(a.data());
    const auto* fb = dynamic_cast<const KltFrame*>(b.data());
    if (!fa || !fb)
      return Error{ErrorCode::Usage, "frames must be prepared by the registrar that aligns them"};
    Registration found;
    for (const auto* f : {fa, fb})
      if (std::min(f->size.width, f->size.height) < kSmallest_px) {
        found.reason = std::string(f == fa ? "A" : "B") + " is smaller than 48 pixels one way";
        return found;
      }
    const double rounding = 0.2;  // gray levels: what a constant picture shows at most
    for (const auto* f : {fa, fb})
      if (f->coarse().texture * f->coarse().reduction < rounding) {
        found.reason = std::string(f == fa ? "A" : "B") + " has too little texture";
        return found;
      }
    if (start && start->allFinite()) {
      found.start = "given";
      if (attempt(*fa, *fb, to_reduced(fa->coarse().reduction, fb->coarse().reduction, *start),
                  found))
        return found;
    }
    for (const Start& s : correlation_starts(*fa, *fb)) {
      if (s.peak < kLeastPeak) break;
      found.start = "correlation";
      if (attempt(*fa, *fb, s.b_from_a, found) || found.ill_determined) return found;
    }
    if (const auto s = feature_start(*fa, *fb)) {
      Registration other;
      other.start = kFromFeatures;
      if (attempt(*fa, *fb, s->b_from_a, other)) return other;
      if (found.reason.empty() || other.correlation > found.correlation) found = std::move(other);
    }
    if (found.reason.empty()) found.reason = "the pictures have nothing in common that was found";
    return found;
  }

 private:
  /// True with a fit; else false with the reason, and what was measured on the way.
  static bool attempt(const KltFrame& a, const KltFrame& b, const Eigen::Matrix3d& start,
                      Registration& found) {
    const std::string_view began = found.start;
    Registration now;
    now.start = began;
    const bool good = judge_coarse(a, b, start, now) && refine(a, b, now);
    // Of several failures the one that came farthest tells most.
    const auto came = [](const Registration& r) {
      return std::isfinite(r.correlation) ? r.correlation : -1.0;
    };
    if (good || found.reason.empty() || came(now) >= came(found)) found = std::move(now);
    return good;
  }

  static bool refuse(Registration& found, std::string reason) {
    found.reason = std::move(reason);
    found.fit.reset();
    return false;
  }

  static bool judge_coarse(const KltFrame& a, const KltFrame& b, const Eigen::Matrix3d& start,
                           Registration& found) {
    const View &va = a.coarse(), &vb = b.coarse();
    const int ra = va.reduction, rb = vb.reduction;
    // The strongest come first; for a rough homography they are enough. Where only features found
    // a start, little may be shared: then every place counts.
    std::vector<cv::Point2f> dense;
    if (found.start == kFromFeatures) dense = corners_in(va, kDenseCorners, kDenseApart_px);
    const std::span<const cv::Point2f> strongest = a.coarse_corners();
    const auto corners =
        dense.empty() ? strongest.first(std::min(strongest.size(), kFarCorners)) : dense;
    const Tracked tracked = track_far(va, vb, corners, start, options(a, b, ra, rb, 1.5));
    for (const cv::Point2f& p : a.coarse_corners())
      found.points_a.push_back(apply(va.full_from_view(), p));
    found.matches = to_full(ra, rb, tracked.matches);
    if (!tracked.fit)
      return refuse(found, text("%.0f of %.0f corners were tracked, to no common homography",
                                static_cast<double>(tracked.matches.size()),
                                static_cast<double>(tracked.tried)));
    found.inliers = tracked.fit->inliers.size();
    measure_reprojection(found, to_full(ra, rb, tracked.fit->b_from_a),
                         to_full(ra, rb, tracked.fit->inliers));
    if (found.inliers < kFewestInliers ||
        static_cast<double>(found.inliers) <
            kLeastInlierShare * static_cast<double>(tracked.matches.size()))
      return refuse(found, text("%.0f of %.0f tracks agree on one homography",
                                static_cast<double>(found.inliers),
                                static_cast<double>(tracked.matches.size())));
    // Views of one field are of one size, whatever the pictures' are.
    if (!is_plausible(to_full(ra, rb, tracked.fit->b_from_a), a.size, static_cast<double>(rb) / ra))
      return refuse(found, "the homography is none of a camera that looks down");
    const Agreement agree = agreement(va, vb, tracked.fit->b_from_a);
    found.correlation = agree.correlation;
    found.overlap = agree.overlap;
    if (agree.overlap < kLeastOverlap)
      return refuse(found, text("the pictures would overlap by %.0f %% only", 100 * agree.overlap));
    if (agree.correlation < std::max(kLeastCorrelation, kLeastChances * agree.chance))
      return refuse(found,
                    text("the pictures correlate to %.2f, which chance may do", agree.correlation));
    if (agree.patches_agreeing < kLeastPatches)
      return refuse(found, text("the pictures agree in %.0f %% of their overlap only",
                                100 * agree.patches_agreeing));
    if (corner_error_px(tracked.fit->b_from_a, Eigen::Matrix3d::Identity(), va.size()) <
            kStill_px &&
        agree.correlation < kLeastStillCorrelation)
      return refuse(found, "what agrees may be the sensor's fixed pattern");
    found.fit = to_full(ra, rb, *tracked.fit, a.size);
    if (!found.fit) return refuse(found, "the corners do not determine a homography");
    return true;
  }

  static TrackingOptions options(const KltFrame& a, const KltFrame& b, int ra, int rb,
                                 double threshold_px) {
    TrackingOptions o{.threshold_px = threshold_px, .still = {}};
    if (a.size == b.size) o.still = to_reduced(ra, rb, Eigen::Matrix3d::Identity());
    return o;
  }

  /// Tracks both ways at one scale from what is known; true where that is believed instead.
  static bool track_at(const KltFrame& a, const KltFrame& b, const Scale& sa, const Scale& sb,
                       std::span<const cv::Point2f> corners, int before, Registration& found) {
    const int ra = sa.reduction, rb = sb.reduction;
    const Tracked tracked =
        track_near(sa.pixels, sb.pixels, corners, to_reduced(ra, rb, found.fit->b_from_a),
                   options(a, b, ra, rb, 1.5));
    if (!tracked.fit || tracked.fit->inliers.size() < kFewestReturned) return false;
    const auto fit = to_full(ra, rb, *tracked.fit, a.size);
    if (!fit || fit->corner_sigma_px > 2.0 * found.fit->corner_sigma_px ||
        largest_move(fit->inliers, fit->b_from_a, found.fit->b_from_a) > kMostMove_px * before)
      return false;
    found.fit = fit;
    found.matches = to_full(ra, rb, tracked.matches);
    found.inliers = fit->inliers.size();
    measure_reprojection(found, fit->b_from_a, fit->inliers);
    return true;
  }

  /// Finer scales, as far as they agree with what is known; then the last judgement.
  static bool refine(const KltFrame& a, const KltFrame& b, Registration& found) {
    std::vector<cv::Point2f> corners = a.coarse_corners();
    int corners_of = a.coarse().reduction, before = corners_of;
    bool both_ways = false;
    const std::size_t scales = std::max(a.finer_scales(), b.finer_scales());
    for (std::size_t i = 0; i < scales; ++i) {
      if (a.finer_scales() > i && a.finer_blur_px(i) > kMostBlur_px) break;
      const auto at = [i](const KltFrame& f) {
        return f.finer_scales() == 0 ? f.coarse_scale()
                                     : f.finer(std::min(i, f.finer_scales() - 1));
      };
      const Scale sa = at(a), sb = at(b);
      if (corners_of > 3 * sa.reduction ||
          (corners_of > 2 * sa.reduction && corners_of == a.coarse().reduction)) {
        corners =
            sa.corners(kFineCorners, overlap_in(a.size, b.size, found.fit->b_from_a, sa.reduction));
        corners_of = sa.reduction;
      }
      const Eigen::Matrix3d here_from_corners =
          full_from_reduced(sa.reduction).inverse() * full_from_reduced(corners_of);
      std::vector<cv::Point2f> here;
      here.reserve(corners.size());
      for (const cv::Point2f& p : corners) here.emplace_back(apply(here_from_corners, p));
      if (!track_at(a, b, sa, sb, here, before, found)) break;  // what is known stands
      both_ways = true;
      before = sa.reduction;
    }
    // Without a finer scale the coarse one must stand being tracked back.
    if (!both_ways &&
        !track_at(a, b, a.coarse_scale(), b.coarse_scale(), a.coarse_corners(), before, found))
      return refuse(found, "the tracks do not come back to where they began");
    // Pictures that agree little must be known the better: trees seen from low are no plane.
    const double diagonal = std::hypot(a.size.width, a.size.height);
    const double b_over_a = static_cast<double>(b.coarse().reduction) / a.coarse().reduction;
    const double most = kMostCornerSigma * diagonal * b_over_a *
                        std::min(1.0, found.correlation / kGoodCorrelation);
    if (!(worst_corner_sigma_px(*found.fit) <= most)) {
      // Where only a part shows anything, every place there counts.
      const auto dense = corners_in(a.coarse(), kDenseCorners, kDenseApart_px);
      track_at(a, b, a.coarse_scale(), b.coarse_scale(), dense, a.coarse().reduction, found);
    }
    const double worst = worst_corner_sigma_px(*found.fit);
    found.ill_determined = !(worst <= most);
    if (found.ill_determined)
      return refuse(found, text("a corner would be known to %.1f px only", worst));
    return true;
  }
};

}  // namespace

std::unique_ptr<Registrar> make_klt_registrar() { return std::make_unique<KltRegistrar>(); }

}  // namespace watersky::detail
