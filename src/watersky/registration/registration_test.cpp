// SPDX-License-Identifier: MIT
#include "watersky/registration/registration.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "support/real_data.hpp"
#include "watersky/registration/detail/registrars.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky {
namespace {

const cv::Size kSize(640, 360);

/// Ice of made floes on a larger field, CV_32F, contrast of some 40 levels about 128.
cv::Mat made_ice(std::uint64_t seed, cv::Size size = {1100, 800}) {
  cv::RNG rng(seed);
  cv::Mat field(size, CV_32F, cv::Scalar(90));
  for (int i = 0; i < 400; ++i)
    cv::circle(field, {rng.uniform(0, size.width), rng.uniform(0, size.height)}, rng.uniform(4, 40),
               cv::Scalar(rng.uniform(90.0, 190.0)), -1, cv::LINE_AA);
  for (const int grain : {4, 16}) {
    cv::Mat texture(size.height / grain, size.width / grain, CV_32F);
    rng.fill(texture, cv::RNG::NORMAL, 0.0, 8.0);
    cv::resize(texture, texture, size, 0, 0, cv::INTER_CUBIC);
    field += texture;
  }
  return field;
}

/// Where a frame lies on the field: its middle, turn and zoom.
Eigen::Matrix3d placed(double x, double y, double turn_deg, double zoom = 1.0) {
  const double c = zoom * std::cos(turn_deg * CV_PI / 180),
               s = zoom * std::sin(turn_deg * CV_PI / 180);
  const double cx = (kSize.width - 1) / 2.0, cy = (kSize.height - 1) / 2.0;
  Eigen::Matrix3d m;
  m << c, -s, x - c * cx + s * cy, s, c, y - s * cx - c * cy, 0, 0, 1;
  return m;
}

cv::Mat view(const cv::Mat& field, const Eigen::Matrix3d& field_from_view) {
  cv::Matx33d m;
  for (int i = 0; i < 9; ++i) m.val[i] = field_from_view(i / 3, i % 3);
  cv::Mat out;
  cv::warpPerspective(field, out, m, kSize, cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                      cv::BORDER_REFLECT_101);
  return out;
}

cv::Mat seen(const cv::Mat& level, double contrast, double noise, std::uint64_t seed,
             int type = CV_8U, double gain = 1.0, double offset = 0.0) {
  cv::RNG rng(seed);
  cv::Mat own(level.size(), CV_32F), out;
  rng.fill(own, cv::RNG::NORMAL, 0.0, noise);
  cv::Mat(gain * ((level - 128.0) * contrast + 128.0 + own) + offset).convertTo(out, type);
  return out;
}

Registration align(const cv::Mat& a, const cv::Mat& b,
                   RegistrationMethod method = RegistrationMethod::Klt) {
  const auto registrar = make_registrar(method).value();
  return registrar->align(registrar->prepare(a).value(), registrar->prepare(b).value()).value();
}

TEST(Registration, OfAPictureToItselfIsTheIdentity) {
  const cv::Mat a = seen(view(made_ice(1), placed(550, 400, 0)), 1.0, 2.0, 1);
  for (const RegistrationMethod method : registration_methods()) {
    if (!available(method)) continue;
    const Registration found = align(a, a, method);
    ASSERT_TRUE(found.fit) << name_of(method) << ": " << found.reason;
    EXPECT_LT(corner_error_px(found.fit->b_from_a, Eigen::Matrix3d::Identity(), kSize), 0.05)
        << name_of(method);
  }
}

TEST(Registration, IsTheKnownWarpAtEveryContrastAndSaysHowWell) {
  const cv::Mat field = made_ice(2);
  for (const double contrast : {1.0, 0.25, 0.08})
    for (int k = 0; k < 12; ++k) {
      const Eigen::Matrix3d pa = placed(550, 400, 0), pb = placed(550 + 9 * (k - 6), 400 - 5 * k,
                                                                  1.7 * (k - 6), 1.0 + 0.005 * k);
      const auto s = static_cast<std::uint64_t>(k);
      const Registration found = align(seen(view(field, pa), contrast, 2.0, 100 + s),
                                       seen(view(field, pb), contrast, 2.0, 200 + s));
      ASSERT_TRUE(found.fit) << contrast << " " << k << ": " << found.reason;
      const double error = corner_error_px(found.fit->b_from_a, pb.inverse() * pa, kSize);
      EXPECT_LT(error, contrast < 0.1 ? 2.0 : 0.5) << contrast << " " << k;
      EXPECT_GT(found.fit->corner_sigma_px, 0.0);
      EXPECT_LT(error, 8.0 * found.fit->corner_sigma_px + 0.05) << contrast << " " << k;
      EXPECT_GE(found.fit->inliers.size(), 10u);
    }
}

TEST(Registration, BackwardsIsItsInverseAndThreeClose) {
  const cv::Mat field = made_ice(3);
  const cv::Mat a = seen(view(field, placed(540, 400, 0)), 0.5, 2.0, 1),
                b = seen(view(field, placed(580, 390, 6)), 0.5, 2.0, 2),
                c = seen(view(field, placed(600, 420, -5)), 0.5, 2.0, 3);
  const auto ab = align(a, b), ba = align(b, a), bc = align(b, c), ac = align(a, c);
  ASSERT_TRUE(ab.fit && ba.fit && bc.fit && ac.fit);
  EXPECT_LT(
      corner_error_px(ba.fit->b_from_a * ab.fit->b_from_a, Eigen::Matrix3d::Identity(), kSize),
      0.5);
  EXPECT_LT(corner_error_px(bc.fit->b_from_a * ab.fit->b_from_a, ac.fit->b_from_a, kSize), 0.7);
}

TEST(Registration, ItsCovarianceIsTheScatterOverManyNoises) {
  const cv::Mat field = made_ice(4);
  const Eigen::Matrix3d pa = placed(550, 400, 0), pb = placed(570, 410, 3);
  const cv::Mat a = view(field, pa), b = view(field, pb);
  for (const double contrast : {0.5, 0.1}) {
    double square = 0, predicted = 0;
    int n = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const Registration found =
          align(seen(a, contrast, 2.0, 1000 + seed), seen(b, contrast, 2.0, 2000 + seed));
      ASSERT_TRUE(found.fit) << found.reason;
      for (const cv::Point2d& p : corners_of(kSize))
        square +=
            std::pow(cv::norm(apply(found.fit->b_from_a, p) - apply(pb.inverse() * pa, p)), 2) / 4;
      predicted += std::pow(found.fit->corner_sigma_px, 2);
      ++n;
    }
    const double ratio = std::sqrt(predicted / square);
    EXPECT_GT(ratio, 0.5) << contrast << ": true " << std::sqrt(square / n);
    EXPECT_LT(ratio, 2.0) << contrast << ": true " << std::sqrt(square / n);
  }
}

TEST(Registration, AFixedPatternDoesNotHoldThePictureStill) {
  const cv::Mat field = made_ice(5);
  cv::RNG rng(9);
  cv::Mat pattern(kSize, CV_32F), columns(1, kSize.width, CV_32F);
  rng.fill(pattern, cv::RNG::NORMAL, 0.0, 1.0);
  rng.fill(columns, cv::RNG::NORMAL, 0.0, 0.5);
  pattern += cv::repeat(columns, kSize.height, 1);
  for (const double shift : {1.5, 4.0, 9.0}) {
    const Eigen::Matrix3d pa = placed(550, 400, 0), pb = placed(550 + shift, 400 - shift, 0.5);
    const cv::Mat a = (view(field, pa) - 128.0) * 0.08 + 128.0 + pattern,
                  b = (view(field, pb) - 128.0) * 0.08 + 128.0 + pattern;
    const Registration found = align(seen(a, 1.0, 2.0, 1), seen(b, 1.0, 2.0, 2));
    ASSERT_TRUE(found.fit) << shift << ": " << found.reason;
    EXPECT_LT(corner_error_px(found.fit->b_from_a, pb.inverse() * pa, kSize), 2.0) << shift;
  }
  // The pattern alone is not a scene.
  const cv::Mat empty = pattern + 128.0;
  EXPECT_FALSE(align(seen(empty, 1.0, 2.0, 1), seen(empty, 1.0, 2.0, 2)).fit);
}

TEST(Registration, ThermalCountsAreAsGoodAsTheirPicture) {
  const cv::Mat field = made_ice(6);
  const Eigen::Matrix3d pa = placed(550, 400, 0), pb = placed(590, 380, 5);
  const cv::Mat a = view(field, pa), b = view(field, pb);
  const Registration eight = align(seen(a, 0.5, 2.0, 1), seen(b, 0.5, 2.0, 2));
  const Registration sixteen =
      align(seen(a, 0.5, 2.0, 1, CV_16U, 37.0, 7000.0), seen(b, 0.5, 2.0, 2, CV_16U, 37.0, 7000.0));
  // Another gain and offset for B: the camera chose its own range.
  const Registration mixed =
      align(seen(a, 0.5, 2.0, 1, CV_16U, 37.0, 7000.0), seen(b, 0.5, 2.0, 2, CV_16U, 15.0, 9000.0));
  ASSERT_TRUE(eight.fit && sixteen.fit && mixed.fit);
  EXPECT_LT(corner_error_px(eight.fit->b_from_a, sixteen.fit->b_from_a, kSize), 0.2);
  EXPECT_LT(corner_error_px(mixed.fit->b_from_a, sixteen.fit->b_from_a, kSize), 0.2);
  cv::Mat color;
  cv::cvtColor(seen(a, 0.5, 2.0, 1), color, cv::COLOR_GRAY2BGR);
  EXPECT_TRUE(align(color, seen(b, 0.5, 2.0, 2)).fit);
}

TEST(Registration, TurnedAroundOrOfAnotherSizeItStillFits) {
  const cv::Mat field = made_ice(7);
  const Eigen::Matrix3d pa = placed(550, 400, 0);
  const cv::Mat a = seen(view(field, pa), 1.0, 2.0, 1);
  for (const double turn : {90.0, 180.0, -45.0}) {
    const Eigen::Matrix3d pb = placed(560, 390, turn);
    const Registration found = align(a, seen(view(field, pb), 1.0, 2.0, 2));
    ASSERT_TRUE(found.fit) << turn << ": " << found.reason;
    EXPECT_LT(corner_error_px(found.fit->b_from_a, pb.inverse() * pa, kSize), 0.5) << turn;
  }
  cv::Mat half;
  cv::resize(a, half, {}, 0.5, 0.5, cv::INTER_AREA);
  const Registration found = align(a, half);
  ASSERT_TRUE(found.fit) << found.reason;
  Eigen::Matrix3d truth;
  truth << 0.5, 0, -0.25, 0, 0.5, -0.25, 0, 0, 1;
  EXPECT_LT(corner_error_px(found.fit->b_from_a, truth, kSize), 0.5);
}

TEST(Registration, HalfAnOverlapIsEitherRightOrRefused) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const cv::Mat field = made_ice(100 + seed);
    const Eigen::Matrix3d pa = placed(390, 400, 0), pb = placed(390 + 320, 400 + 20, 2);
    const Registration found =
        align(seen(view(field, pa), 0.3, 2.0, 1), seen(view(field, pb), 0.3, 2.0, 2));
    if (found.fit) {
      EXPECT_LT(corner_error_px(found.fit->b_from_a, pb.inverse() * pa, kSize), 5.0) << seed;
    } else {
      EXPECT_FALSE(found.reason.empty());
    }
  }
}

TEST(Registration, DifferentPlacesNoiseAndNothingAreRefusedWithAReason) {
  const auto refused = [](const cv::Mat& a, const cv::Mat& b, const std::string& what) {
    const Registration found = align(a, b);
    EXPECT_FALSE(found.fit) << what;
    EXPECT_FALSE(found.reason.empty()) << what;
  };
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    refused(seen(view(made_ice(10 + seed), placed(550, 400, 0)), 0.5, 2.0, 1),
            seen(view(made_ice(50 + seed), placed(550, 400, 0)), 0.5, 2.0, 2), "other place");
  const cv::Mat flat(kSize, CV_32F, cv::Scalar(128));
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    refused(seen(flat, 1.0, 3.0, seed), seen(flat, 1.0, 3.0, 100 + seed), "noise");
  const cv::Mat ice = seen(view(made_ice(1), placed(550, 400, 0)), 1.0, 2.0, 1);
  for (const int level : {0, 128, 255}) {
    const cv::Mat constant(kSize, CV_8U, cv::Scalar(level));
    refused(constant, constant, "constant");
    refused(ice, constant, "constant B");
    refused(constant, ice, "constant A");
  }
  const cv::Mat counts(kSize, CV_16U, cv::Scalar(7000));
  refused(counts, counts, "constant counts");
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(640, 1), cv::Size(3, 500), cv::Size(47, 47)}) {
    const cv::Mat tiny = ice(cv::Rect(0, 0, std::min(640, size.width), std::min(360, size.height)));
    refused(tiny, tiny, "tiny");
    refused(ice, tiny, "tiny B");
  }
}

TEST(Registration, WhatAMaskHidesIsNotUsed) {
  const cv::Mat field = made_ice(8);
  const Eigen::Matrix3d pa = placed(550, 400, 0), pb = placed(575, 405, 2);
  cv::Mat a = seen(view(field, pa), 1.0, 2.0, 1), b = seen(view(field, pb), 1.0, 2.0, 2);
  // A caption burnt into both.
  const cv::Rect band(0, 0, 640, 90);
  cv::Mat caption(band.size(), CV_8U);
  cv::RNG(3).fill(caption, cv::RNG::UNIFORM, 0, 255);
  caption.copyTo(a(band));
  caption.copyTo(b(band));
  cv::Mat valid(kSize, CV_8U, cv::Scalar(255));
  valid(band).setTo(0);
  const auto registrar = make_registrar(RegistrationMethod::Klt).value();
  const Registration found =
      registrar->align(registrar->prepare(a, valid).value(), registrar->prepare(b, valid).value())
          .value();
  ASSERT_TRUE(found.fit) << found.reason;
  EXPECT_LT(corner_error_px(found.fit->b_from_a, pb.inverse() * pa, kSize), 1.0);
  for (const PointPair& pair : found.fit->inliers) EXPECT_GT(pair.a.y, 85.0);
}

TEST(Registration, AStartIsTakenWhereNothingElseWouldFindIt) {
  const cv::Mat field = made_ice(9);
  const Eigen::Matrix3d pa = placed(550, 400, 0), pb = placed(560, 410, 40);
  const cv::Mat a = seen(view(field, pa), 0.15, 2.0, 1), b = seen(view(field, pb), 0.15, 2.0, 2);
  const auto registrar = make_registrar(RegistrationMethod::Klt).value();
  const auto fa = registrar->prepare(a).value(), fb = registrar->prepare(b).value();
  const Eigen::Matrix3d rough = placed(566, 404, 41).inverse() * pa;
  const Registration found = registrar->align(fa, fb, rough).value();
  ASSERT_TRUE(found.fit) << found.reason;
  EXPECT_EQ(found.start, "given");
  EXPECT_LT(corner_error_px(found.fit->b_from_a, pb.inverse() * pa, kSize), 1.0);
  // A wrong one does no harm.
  const Eigen::Matrix3d wrong = placed(700, 300, 180).inverse() * pa;
  const Registration despite = registrar->align(fa, fa, wrong).value();
  ASSERT_TRUE(despite.fit) << despite.reason;
  EXPECT_LT(corner_error_px(despite.fit->b_from_a, Eigen::Matrix3d::Identity(), kSize), 0.1);
}

TEST(Registration, WrongCallsAreErrors) {
  const auto klt = make_registrar(RegistrationMethod::Klt).value();
  const auto orb = make_registrar(RegistrationMethod::Orb).value();
  EXPECT_EQ(klt->prepare(cv::Mat()).error().code, ErrorCode::InvalidInput);
  EXPECT_EQ(klt->prepare(cv::Mat(kSize, CV_32F, cv::Scalar(1))).error().code,
            ErrorCode::Unsupported);
  const cv::Mat a = seen(view(made_ice(1), placed(550, 400, 0)), 1.0, 2.0, 1);
  EXPECT_EQ(klt->prepare(a, cv::Mat(3, 3, CV_8U)).error().code, ErrorCode::InvalidInput);
  const auto frame = orb->prepare(a).value();
  EXPECT_EQ(klt->align(frame, frame).error().code, ErrorCode::Usage);
  EXPECT_EQ(orb->align(RegistrationFrame(), frame).error().code, ErrorCode::Usage);
}

// The thesis, 4.3.2, step 5: "Remove matches that have a distance higher than 2*minDist".
TEST(ThesisRule, KeepsUpToTwiceTheLeastDistanceAndOnlyZerosWhereThatIsZero) {
  using Kept = std::vector<std::size_t>;
  const auto kept = [](std::vector<float> d) { return detail::within_twice_least(d); };
  EXPECT_EQ(kept({10, 20, 20.5F, 15}), (Kept{0, 1, 3}));
  EXPECT_EQ(kept({0, 1, 0, 30}), (Kept{0, 2}));
  EXPECT_EQ(kept({7}), (Kept{0}));
  EXPECT_EQ(kept({}), Kept{});
}

// Errata 12: over the RANSAC inliers the error is below 5 px by construction.
TEST(ThesisRule, TheMeanIsOverAllMatchesThatAreLeft) {
  Registration found;
  for (int i = 0; i < 3; ++i) found.matches.push_back({cv::Point2d(i, 0), cv::Point2d(i + 1, 0)});
  found.matches.push_back({cv::Point2d(0, 0), cv::Point2d(9, 0)});
  detail::measure_reprojection(found, Eigen::Matrix3d::Identity(),
                               std::span(found.matches).first(3));
  EXPECT_DOUBLE_EQ(found.mean_reprojection_px, 3.0);
  EXPECT_DOUBLE_EQ(found.inlier_mean_px, 1.0);
}

TEST(ThesisRule, FewerThanFourMatchesAndEmptyPicturesAreNoRegistration) {
  const cv::Mat blank(kSize, CV_8U, cv::Scalar(90));
  for (const RegistrationMethod method : registration_methods()) {
    if (method == RegistrationMethod::Klt || !available(method)) continue;
    const Registration found = align(blank, blank, method);
    EXPECT_FALSE(found.fit) << name_of(method);
    EXPECT_FALSE(found.reason.empty());
    const cv::Mat pixel(1, 1, CV_8U, cv::Scalar(3));
    EXPECT_FALSE(align(pixel, pixel, method).fit) << name_of(method);
  }
}

TEST(RegistrationMethods, AreKnownByName) {
  for (const RegistrationMethod method : registration_methods())
    EXPECT_EQ(registration_method(name_of(method)), method);
  EXPECT_FALSE(registration_method("magic"));
  const Status surf = available(RegistrationMethod::Surf);
  if (!surf) {
    EXPECT_EQ(surf.error().code, ErrorCode::Unsupported);
  }
}

TEST(RegistrationReal, OfPackIceOnlyTheThreePairsThatOverlapAndTheyClose) {
  const auto data = test::real_data("hotrax_pack_ice");
  if (!data) GTEST_SKIP() << "the pack ice photographs are not here";
  const auto registrar = make_registrar(RegistrationMethod::Klt).value();
  std::vector<RegistrationFrame> frames;
  for (int i = 1; i <= 12; ++i) {
    const cv::Mat image = cv::imread(
        (*data / "images" / ("ice" + std::to_string(i) + ".png")).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty());
    frames.push_back(registrar->prepare(image).value());
  }
  std::map<std::pair<int, int>, Eigen::Matrix3d> known;
  for (int i = 1; i <= 12; ++i)
    for (int k = i + 1; k <= 12; ++k) {
      const Registration found = registrar
                                     ->align(frames[static_cast<std::size_t>(i - 1)],
                                             frames[static_cast<std::size_t>(k - 1)])
                                     .value();
      EXPECT_EQ(found.fit.has_value(), i >= 10) << i << " " << k << ": " << found.reason;
      if (found.fit) known[{i, k}] = found.fit->b_from_a;
    }
  ASSERT_EQ(known.size(), 3u);
  std::vector<double> closure;
  for (int y = 0; y < 2000; y += 20)
    for (int x = 0; x < 3008; x += 20) {
      const cv::Point2d b = apply(known[{10, 11}], cv::Point2d(x, y)),
                        c = apply(known[{11, 12}], b);
      const cv::Rect2d inside(0, 0, 3008, 2000);
      if (inside.contains(b) && inside.contains(c))
        closure.push_back(cv::norm(c - apply(known[{10, 12}], cv::Point2d(x, y))));
    }
  ASSERT_GT(closure.size(), 100u);
  std::nth_element(closure.begin(),
                   closure.begin() + static_cast<std::ptrdiff_t>(closure.size() / 2),
                   closure.end());
  EXPECT_LT(closure[closure.size() / 2], 2.0);
}

}  // namespace
}  // namespace watersky
