// SPDX-License-Identifier: MIT
#include "watersky/align/detail/adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "watersky/geo/rotation.hpp"

namespace watersky::align {
namespace {

/// An aircraft that weaves over a grid of known places, seen without error but for what is asked.
struct Scene {
  double delay_s = 0.2;
  Eigen::Vector3d boresight = Eigen::Vector3d::Zero();
  double jitter_s = 0.0, pixel_sigma = 0.0, readout_s = 0.0;
  double position_error_m = 0.0;
  Eigen::Vector2d drift_m_s = Eigen::Vector2d::Zero();
  unsigned seed = 1;
};

constexpr double kFocal_px = 700.0;

Flight weaving_flight() {
  const Datum datum(Geodetic{Angle::degrees(78.9), Angle::degrees(11.9), 30.0});
  Eigen::Matrix3d matrix;
  matrix << kFocal_px, 0, 319.5, 0, kFocal_px, 255.5, 0, 0, 1;
  Flight flight("weaving", datum, CameraModel::make(LensModel::Pinhole, 640, 512, matrix).value());
  flight.mount.rotation =
      camera_rotation({Angle::degrees(0), Angle::degrees(-90), Angle::degrees(0)});
  flight.sea_level = SeaLevel{[](const Geodetic&) { return Result<double>(0.0); }, "0", 0.0};
  std::vector<StampedPose> poses;
  for (int i = 0; i <= 1500; ++i) {
    const double t = 0.02 * i;
    const Eigen::Quaterniond turn = rotation_from({Angle::radians(0.3 * std::sin(0.7 * t)),
                                                   Angle::radians(0.06 * std::sin(1.1 * t)),
                                                   Angle::radians(0.12 * std::sin(0.9 * t + 1))});
    StampedPose pose;
    pose.time = Time(std::chrono::seconds(1000)) + seconds(t);
    pose.world_from_body = Rigid3<World, Body>(
        turn, Point<World>{{12.0 * t, 15.0 * std::sin(0.4 * t), -70.0 + 4.0 * std::sin(0.5 * t)}});
    poses.push_back(pose);
  }
  flight.trajectory = Trajectory::make(std::move(poses)).value();
  return flight;
}

/// An adjustment of that flight at 5 Hz, each frame tied to the four before it.
struct Case {
  explicit Case(const Scene& scene)
      : flight(weaving_flight()),
        frame(flight.datum, *flight.sea_level, flight.datum.geodetic(Point<World>{{180, 0, 0}})),
        navigation(Navigation::make(flight, frame, 1.0).value()),
        adjustment(navigation, flight.mount, kFocal_px, scene.readout_s) {
    std::mt19937 random(scene.seed);
    std::normal_distribution<double> normal;
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
    std::vector<ModelCamera> cameras;
    std::vector<double> times_s;
    for (int k = 0; k < 120; ++k) {
      const double captured_s = 1.0 + 0.2 * k;
      AdjustedFrame made;
      made.base_s = captured_s + scene.delay_s + scene.jitter_s * normal(random);
      made.delayed = true;
      made.knot = k;
      adjustment.frames.push_back(made);
      adjustment.knot_times_s.push_back(captured_s);
      const NavigationSample nav = navigation.at(captured_s);
      for (int c = 0; c < 3; ++c)
        error[c] =
            0.98 * error[c] + scene.position_error_m * std::sqrt(1 - 0.98 * 0.98) * normal(random);
      ModelCamera camera;
      camera.rotation = nav.reference * flight.mount.rotation * exp_rotation(scene.boresight);
      camera.position_m = nav.position_m - error;
      camera.velocity_m_s = nav.velocity_m_s;
      camera.rate_rad_s = nav.reference_rate_rad_s;
      cameras.push_back(camera);
      times_s.push_back(captured_s);
    }
    adjustment.delay_knot_times_s = {1.0};
    adjustment.delay_start_s = 0.15;
    std::uniform_real_distribution<double> u(-0.42, 0.42), v(-0.34, 0.34);
    for (int f = 1; f < 120; ++f)
      for (int h = std::max(0, f - 4); h < f; ++h) {
        TieGroup group{h, f, false, 1.0, false, {}};
        for (int n = 0; n < 12; ++n) {
          const Eigen::Vector2d host(u(random), v(random));
          const double host_row = host.y() * kFocal_px / 512.0;
          const ModelCamera a =
              cameras[static_cast<std::size_t>(h)].at_row(host_row, scene.readout_s);
          const Eigen::Vector3d ray = a.rotation * host.homogeneous();
          Eigen::Vector3d place = a.position_m - a.position_m.z() / ray.z() * ray;
          place.head<2>() +=
              (times_s[static_cast<std::size_t>(f)] - times_s[static_cast<std::size_t>(h)]) *
              scene.drift_m_s;
          // The row that sees it depends on where it is seen.
          double row = 0.0;
          Eigen::Vector2d seen;
          for (int i = 0; i < 6; ++i) {
            const ModelCamera b = cameras[static_cast<std::size_t>(f)].at_row(row, scene.readout_s);
            const Eigen::Vector3d d = b.rotation.conjugate() * (place - b.position_m);
            seen = d.hnormalized();
            row = seen.y() * kFocal_px / 512.0;
          }
          if (std::abs(seen.x()) > 0.45 || std::abs(seen.y()) > 0.36) continue;
          Tie tie;
          tie.host = host;
          tie.frame = seen + scene.pixel_sigma / kFocal_px *
                                 Eigen::Vector2d(normal(random), normal(random));
          tie.host_row = host_row;
          tie.frame_row = row;
          if (scene.pixel_sigma > 0) tie.whiten /= scene.pixel_sigma;
          group.ties.push_back(tie);
        }
        if (!group.ties.empty()) adjustment.groups.push_back(group);
      }
    auto& p = adjustment.priors;
    p.knot << 0.7, 0.7, 0.7, 0.005, 0.005, 0.005;
    p.globals.setZero();
    p.globals.segment<3>(Globals::kMount).setConstant(0.05);
    p.delay_s = 0.3;
    p.jitter_s = scene.jitter_s;
    adjustment.reset();
  }
  Flight flight;
  LocalFrame frame;
  Navigation navigation;
  Adjustment adjustment;
};

TEST(Adjustment, FindsDelayAndMountOfExactSightings) {
  const Scene scene{.boresight = {0.02, -0.025, 0.015}};
  Case c(scene);
  c.adjustment.priors.knot *= 1e-4;
  const auto summary = c.adjustment.solve({.rounds = 3, .estimate_variances = false});
  ASSERT_TRUE(summary.usable);
  EXPECT_NEAR(c.adjustment.state.delay_s[0], scene.delay_s, 2e-4);
  EXPECT_LT((c.adjustment.state.globals.head<3>() - scene.boresight).norm(), 2e-4);
}

TEST(Adjustment, ARollingShutterIsPartOfTheCamera) {
  const Scene scene{.boresight = {0.02, -0.025, 0.015}, .readout_s = 0.04};
  Case c(scene);
  c.adjustment.priors.knot *= 1e-4;
  ASSERT_TRUE(c.adjustment.solve({.rounds = 3, .estimate_variances = false}).usable);
  EXPECT_NEAR(c.adjustment.state.delay_s[0], scene.delay_s, 5e-4);
  EXPECT_LT((c.adjustment.state.globals.head<3>() - scene.boresight).norm(), 5e-4);
}

TEST(Adjustment, AClockOfAWrongPeriodIsSetRight) {
  const auto worst_s = [](double delay_rate) {
    Case c({.pixel_sigma = 0.3});
    // As if its period had been taken for a little longer than it is.
    for (AdjustedFrame& f : c.adjustment.frames) f.base_s += 2e-3 * (f.base_s - 1.0);
    c.adjustment.delay_knot_times_s = {1.0, 6.0, 11.0, 16.0, 21.0, 26.0};
    c.adjustment.priors.delay_walk_s = 1e-4;
    c.adjustment.priors.delay_rate = delay_rate;
    c.adjustment.priors.knot *= 1e-3;
    c.adjustment.reset();
    EXPECT_TRUE(c.adjustment.solve({.rounds = 4, .estimate_variances = false}).usable);
    double worst = 0.0;
    for (int k = 0; k < 120; ++k)
      worst =
          std::max(worst, std::abs(c.adjustment.time_s(k, c.adjustment.state) - (1.0 + 0.2 * k)));
    return worst;
  };
  EXPECT_LT(worst_s(1e-3), 0.001);
  EXPECT_GT(worst_s(0.0), 0.002) << "a delay that only walks does not follow it";
}

TEST(Adjustment, FindsTheCommonMotionOfTheIceWhereAsked) {
  const Scene scene{.drift_m_s = {0.4, -0.25}};
  Case c(scene);
  c.adjustment.priors.knot *= 1e-3;
  c.adjustment.priors.globals.segment<2>(Globals::kDrift).setConstant(0.5);
  ASSERT_TRUE(c.adjustment.solve({.rounds = 3, .estimate_variances = false}).usable);
  EXPECT_LT((c.adjustment.state.globals.segment<2>(Globals::kDrift) - scene.drift_m_s).norm(),
            0.02);
}

TEST(Adjustment, FindsEachFramesOwnDelay) {
  const Scene scene{.jitter_s = 0.03, .pixel_sigma = 0.1};
  Case c(scene);
  c.adjustment.priors.knot *= 1e-3;
  ASSERT_TRUE(c.adjustment.solve({.rounds = 4, .estimate_variances = false}).usable);
  double square = 0.0;
  for (int k = 0; k < 120; ++k)
    square += std::pow(c.adjustment.time_s(k, c.adjustment.state) - (1.0 + 0.2 * k), 2) / 120;
  EXPECT_LT(std::sqrt(square), 0.002);
}

TEST(Adjustment, SigmasAreHonest) {
  // Over several flights the errors over their sigmas are of order one, neither tiny nor large.
  double sum = 0.0;
  int n = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Scene scene{.boresight = {0.02, -0.025, 0.015},
                      .pixel_sigma = 0.4,
                      .position_error_m = 0.7,
                      .seed = seed};
    Case c(scene);
    // exp(-0.2 / τ) = 0.98
    c.adjustment.priors.position_correlation_s = 9.9;
    c.adjustment.priors.knot.tail<3>().setConstant(1e-6);
    ASSERT_TRUE(c.adjustment.solve({.rounds = 4, .estimate_variances = false}).usable);
    const auto known = c.adjustment.knowledge();
    ASSERT_TRUE(known);
    for (int k = 0; k < 3; ++k, ++n)
      sum += std::pow(
          (c.adjustment.state.globals[k] - scene.boresight[k]) / known->globals_sigma[k], 2);
    sum += std::pow((c.adjustment.state.delay_s[0] - scene.delay_s) / known->delay_sigma_s[0], 2);
    ++n;
  }
  EXPECT_GT(sum / n, 0.3);
  EXPECT_LT(sum / n, 2.5);
}

TEST(Adjustment, TheSizeOfNavigationErrorsComesFromTheResiduals) {
  const Scene scene{.pixel_sigma = 0.3, .position_error_m = 0.7};
  Case c(scene);
  c.adjustment.priors.position_correlation_s = 9.9;
  c.adjustment.priors.knot.head<3>().setConstant(0.15);
  c.adjustment.priors.knot.tail<3>().setConstant(1e-5);
  ASSERT_TRUE(c.adjustment.solve({.rounds = 6, .estimate_variances = true}).usable);
  EXPECT_GT(c.adjustment.priors.knot[0], 0.35);
  EXPECT_LT(c.adjustment.priors.knot[0], 1.4);
}

TEST(Adjustment, WhatIsForgottenStaysAsAPriorOfTheRest) {
  // A chain, each frame tied to the one before it alone: then what the first frames tell of the
  // rest goes through the second, and nothing is lost.
  const Scene scene{.boresight = {0.02, -0.025, 0.015}, .pixel_sigma = 0.3};
  Case whole(scene), cut(scene);
  for (Case* c : {&whole, &cut}) {
    std::erase_if(c->adjustment.groups, [](const TieGroup& g) { return g.frame != g.host + 1; });
    c->adjustment.priors.knot *= 0.1;
    ASSERT_TRUE(c->adjustment.solve({.rounds = 3, .estimate_variances = false}).usable);
  }
  for (int k = 0; k < 40; ++k) cut.adjustment.forget_first(0.0);
  ASSERT_TRUE(cut.adjustment.before_first);
  ASSERT_EQ(cut.adjustment.frames.size(), 80U);
  const auto all = whole.adjustment.knowledge(), rest = cut.adjustment.knowledge();
  ASSERT_TRUE(all && rest);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(rest->globals_sigma[k] / all->globals_sigma[k], 1.0, 0.02);
    EXPECT_NEAR(cut.adjustment.state.globals[k], whole.adjustment.state.globals[k], 1e-9);
  }
  EXPECT_NEAR(rest->delay_sigma_s[0] / all->delay_sigma_s[0], 1.0, 0.02);
  // Solved again from there it stays where it was.
  ASSERT_TRUE(
      cut.adjustment.solve({.rounds = 1, .estimate_variances = false, .warm = true}).usable);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(cut.adjustment.state.globals[k], whole.adjustment.state.globals[k],
                0.2 * all->globals_sigma[k]);
  EXPECT_NEAR(cut.adjustment.state.delay_s[0], whole.adjustment.state.delay_s[0],
              0.2 * all->delay_sigma_s[0]);
}

TEST(Adjustment, TheDelayMayWanderOnceItIsAPrior) {
  const Scene scene{.pixel_sigma = 0.3};
  Case still(scene), wandering(scene);
  for (Case* c : {&still, &wandering}) {
    ASSERT_TRUE(c->adjustment.solve({.rounds = 3, .estimate_variances = false}).usable);
    for (int k = 0; k < 100; ++k) c->adjustment.forget_first(c == &still ? 0.0 : 0.01);
  }
  EXPECT_GT(wandering.adjustment.knowledge()->delay_sigma_s[0],
            1.2 * still.adjustment.knowledge()->delay_sigma_s[0]);
}

TEST(Adjustment, OneFrameAloneFindsItsPlaceAndItsTime) {
  const Scene scene{.pixel_sigma = 0.1};
  Case c(scene);
  c.adjustment.priors.knot *= 1e-3;
  ASSERT_TRUE(c.adjustment.solve({.rounds = 3, .estimate_variances = false}).usable);
  auto& a = c.adjustment;
  constexpr int kFrame = 60;
  // It came 40 ms late, and its pose is off by half a metre.
  a.frames[kFrame].base_s += 0.04;
  a.state.extra[kFrame] = {0.5, -0.3, 0.1, 0.001, 0.002, -0.001};
  std::vector<const TieGroup*> groups;
  for (const TieGroup& g : a.groups)
    if (g.frame == kFrame) groups.push_back(&g);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << 1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 1e-5;
  const auto covariance = a.solve_frame(kFrame, groups, sigma, 0.05, true);
  EXPECT_NEAR(a.time_s(kFrame, a.state), 1.0 + 0.2 * kFrame, 0.002);
  const Eigen::Map<Eigen::Matrix<double, 6, 1>> extra(a.state.extra[kFrame].data());
  EXPECT_LT(extra.norm(), 0.01);
  EXPECT_GT(covariance.trace(), 0.0);
  const double spread_m2 = covariance.topLeftCorner(3, 3).trace();
  EXPECT_LT(spread_m2, 1.0);
}

TEST(Adjustment, EvidencePrefersWhatIsSo) {
  const Scene scene{.pixel_sigma = 0.3};  // exact poses
  double of_exact = 0.0, of_loose = 0.0;
  for (const double scale : {1e-3, 1.0}) {
    Case c(scene);
    c.adjustment.priors.knot *= scale;
    ASSERT_TRUE(c.adjustment.solve({.rounds = 4, .estimate_variances = false}).usable);
    (scale < 1 ? of_exact : of_loose) = c.adjustment.log_evidence();
  }
  EXPECT_GT(of_exact, of_loose);
}

TEST(LocalFrame, UndoesItselfAndIsFlat) {
  const Datum datum(Geodetic{Angle::degrees(78.9), Angle::degrees(11.9), 42.0},
                    Angle::degrees(33.0));
  const LocalFrame frame(datum, {[](const Geodetic&) { return Result<double>(30.0); }, "", 0.0},
                         datum.origin());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20000, 20000), angle(-3, 3);
  for (int i = 0; i < 50; ++i) {
    const Rigid3<World, Body> pose(
        rotation_from({Angle::radians(angle(random)), Angle::radians(0.4 * angle(random)),
                       Angle::radians(angle(random))}),
        Point<World>{{place(random), place(random), -100.0}});
    const auto local = frame.local(pose);
    ASSERT_TRUE(local);
    const auto back = frame.world(*local);
    ASSERT_TRUE(back);
    EXPECT_LT((back->origin().v - pose.origin().v).norm(), 1e-6);
    EXPECT_LT(angle_between(back->rotation(), pose.rotation()).radians(), 1e-9);
    Geodetic on_sea = datum.geodetic(pose.origin());
    on_sea.height_ellipsoid_m = 30.0;
    EXPECT_NEAR(frame.local(on_sea).value().z(), 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace watersky::align
