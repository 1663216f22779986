// SPDX-License-Identifier: MIT
#include "watersky/align/detail/known_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "watersky/align/detail/adjustment.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky::align {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kHeight_m = 100.0, kFocal_px = 700.0;
constexpr int kFrames = 40;

Time at_s(double t_s) { return Time(std::chrono::seconds(1000)) + seconds(t_s); }

/// A straight flight north over a sea at the ellipsoid, a frame a second, looking down with a
/// slight sway. The recorded positions are off by `offset`, the same all along.
struct Case {
  explicit Case(const Eigen::Vector3d& recorded_less_true_m) : off_m(recorded_less_true_m) {
    const Datum datum(Geodetic{Angle::degrees(78.9), Angle::degrees(11.9), 30.0});
    Eigen::Matrix3d matrix;
    matrix << kFocal_px, 0, 319.5, 0, kFocal_px, 255.5, 0, 0, 1;
    flight.emplace("straight", datum,
                   CameraModel::make(LensModel::Pinhole, 640, 512, matrix).value());
    flight->mount.rotation = camera_rotation({{}, Angle::degrees(-90), {}});
    flight->sea_level = SeaLevel{[](const Geodetic&) { return Result<double>(0.0); }, "0", 0.0};
    std::vector<StampedPose> poses;
    for (int k = -2; k < kFrames + 2; ++k) {
      StampedPose pose;
      pose.time = at_s(k);
      pose.world_from_body = Rigid3<World, Body>(attitude(k), Point<World>{true_place(k) + off_m});
      poses.push_back(pose);
    }
    flight->trajectory = Trajectory::make(std::move(poses)).value();
    for (int k = 0; k < kFrames; ++k) {
      ImageFrame frame;
      frame.name = "f" + std::to_string(k);
      frame.captured_at = at_s(k);
      flight->frames.push_back(std::move(frame));
      of.push_back(static_cast<std::size_t>(k));
    }
  }

  static Eigen::Vector3d true_place(double t) { return {5.0 * t - 100.0, 2.0, 30.0 - kHeight_m}; }
  static Eigen::Quaterniond attitude(double t) {
    return rotation_from({Angle::degrees(2 * std::sin(t)), Angle::degrees(3 * std::sin(0.7 * t)),
                          Angle::degrees(4 * std::cos(0.9 * t))});
  }

  /// Marks an anchor at a place of World in every `step`th frame that sees it.
  Anchor& mark(const std::string& name, const Eigen::Vector3d& p_world, int step = 1) {
    Anchor anchor;
    anchor.name = name;
    const Geodetic g = flight->datum.geodetic(Point<World>{p_world});
    anchor.place =
        AnchorPlace{g.latitude, g.longitude, g.height_ellipsoid_m, HeightAbove::Ellipsoid};
    anchor.sigma_m = anchor.sigma_height_m = 0.1;
    for (int k = 0; k < kFrames; k += step) {
      const Rigid3<World, Body> body(attitude(k), Point<World>{true_place(k)});
      const Rigid3<Body, Camera> camera(flight->mount.rotation, Point<Body>{{0, 0, 0}});
      const auto px = flight->camera.project((body * camera).inverse() * Point<World>{p_world});
      if (px && flight->camera.contains(*px))
        anchor.sightings.push_back({"f" + std::to_string(k), *px, 0.5});
    }
    flight->anchors.push_back(std::move(anchor));
    return flight->anchors.back();
  }

  void make() {
    local.emplace(flight->datum, *flight->sea_level,
                  flight->datum.geodetic(Point<World>{{0, 0, 0}}));
    navigation.emplace(Navigation::make(*flight, *local, 2.0).value());
    adjustment.emplace(*navigation, flight->mount, kFocal_px, 0.0);
    for (int k = 0; k < kFrames; ++k) {
      AdjustedFrame frame;
      frame.base_s = navigation->since_epoch_s(at_s(k));
      frame.knot = k;
      adjustment->frames.push_back(frame);
      adjustment->knot_times_s.push_back(frame.base_s);
    }
    // Ties would say that frames lie well to each other.
    adjustment->priors.knot << 0.05, 0.05, 0.05, 5e-4, 5e-4, 5e-4;
    adjustment->priors.globals.setZero();
    adjustment->reset();
    const KnownPoints known = known_points_of(*flight, *local, *navigation, of, adjustment->frames);
    points = known.points;
    notes = known.notes;
  }

  Eigen::Vector3d off_m;
  std::optional<Flight> flight;
  std::vector<std::size_t> of;
  std::optional<LocalFrame> local;
  std::optional<Navigation> navigation;
  std::optional<Adjustment> adjustment;
  std::vector<KnownPoint> points;
  std::vector<std::string> notes;
};

void use(Adjustment& a, std::vector<KnownPoint> points, double sigma_m) {
  a.known_points = std::move(points);
  whiten(a, a.known_points);
  a.priors.globals.segment<2>(Globals::kOffset).setConstant(sigma_m);
  a.solve({.rounds = 3, .estimate_variances = false});
}

// The law: what the navigation is off by is what the anchor shows, on the sea or above it.
TEST(KnownPoints, ShowTheOffsetThatAllFramesShare) {
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> metre(-3, 3);
  for (int trial = 0; trial < 6; ++trial) {
    Case c({metre(rng), metre(rng), 0.0});
    c.mark("cairn", {metre(rng), 10 * metre(rng), 30.0 - (trial % 2 == 0 ? 0.0 : 12.0)},
           trial < 3 ? 1 : 7);
    c.make();
    ASSERT_FALSE(c.points.empty());
    ASSERT_THAT(c.notes, IsEmpty());
    const auto before = anchor_error_m(*c.adjustment, c.points.front());
    ASSERT_TRUE(before);
    // Local's axes are north and east at its origin to 1e-5 here.
    EXPECT_LT((*before - c.off_m.head<2>()).norm(), 0.02);
    const AnchorChoice choice = choose_anchors(*c.adjustment, c.points, 2.0);
    EXPECT_EQ(choice.used.size(), c.points.size());
    EXPECT_THAT(choice.rejected, IsEmpty());
    EXPECT_LT((choice.offset_m - c.off_m.head<2>()).norm(), 0.05);
    use(*c.adjustment, choice.used, 2.0);
    EXPECT_LT((c.adjustment->state.globals.segment<2>(Globals::kOffset) + c.off_m.head<2>()).norm(),
              0.05);
    // One anchor of 0.1 m cannot tell more than that of the whole, however often it is seen.
    const auto known = c.adjustment->knowledge();
    ASSERT_TRUE(known);
    EXPECT_GT(std::sqrt(known->shared_m2(0, 0)), 0.09);
    EXPECT_LT(std::sqrt(known->shared_m2(0, 0)), 0.13);
  }
}

TEST(KnownPoints, AWrongPixelIsFoundAmongRightOnes) {
  Case c({0.5, -0.7, 0.0});
  Anchor& cairn = c.mark("cairn", {0, 5, 30}, 2);
  ASSERT_GE(cairn.sightings.size(), 5u);
  cairn.sightings[2].px.u += 40.0;  // 5.7 m
  c.make();
  const AnchorChoice choice = choose_anchors(*c.adjustment, c.points, 2.0);
  ASSERT_THAT(choice.rejected, SizeIs(1));
  EXPECT_EQ(choice.rejected[0].point.sighting, 2u);
  EXPECT_NEAR(choice.rejected[0].off_m, 5.7, 0.2);
  EXPECT_NEAR(choice.rejected[0].off_px, 40.0, 2.0);
  EXPECT_FALSE(choice.undecided);
  EXPECT_LT((choice.offset_m - c.off_m.head<2>()).norm(), 0.1);
}

TEST(KnownPoints, AWrongPlaceIsFoundByTheOtherAnchors) {
  Case c({0.5, -0.7, 0.0});
  c.mark("cairn", {0, 5, 30});
  c.mark("hut", {30, -10, 25}, 4);
  c.mark("moved", {-30, 8, 30});
  Anchor& moved = c.flight->anchors.back();
  moved.place->latitude = Angle::degrees(moved.place->latitude.degrees() + 4.0 / 111'660.0);
  c.make();
  const AnchorChoice choice = choose_anchors(*c.adjustment, c.points, 2.0);
  EXPECT_EQ(choice.rejected.size(), moved.sightings.size());
  for (const auto& r : choice.rejected) {
    EXPECT_EQ(r.point.anchor, 2u);
    EXPECT_NEAR(r.off_m, 4.0, 0.3);
  }
}

TEST(KnownPoints, OneAloneMustBeWithinWhatTheNavigationCanBeOffBy) {
  Case c({0, 0, 0});
  c.mark("cairn", {0, 5, 30});
  c.flight->anchors[0].place->longitude =
      Angle::degrees(c.flight->anchors[0].place->longitude.degrees() + 0.001);  // 21 m
  c.make();
  const AnchorChoice choice = choose_anchors(*c.adjustment, c.points, 2.0);
  EXPECT_TRUE(choice.against_navigation);
  EXPECT_THAT(choice.used, IsEmpty());
  EXPECT_NEAR(choice.rejected.at(0).off_m, 21.5, 0.5);
  // Two that agree are believed against it.
  Case two({-15, 14, 0});
  two.mark("cairn", {0, 5, 30});
  two.mark("hut", {30, -10, 25}, 3);
  two.make();
  EXPECT_THAT(choose_anchors(*two.adjustment, two.points, 2.0).rejected, IsEmpty());
}

TEST(KnownPoints, TwoThatContradictEachOtherAreBothLeftOut) {
  Case c({0, 0, 0});
  c.mark("cairn", {0, 5, 30});
  c.mark("hut", {30, -10, 30});
  c.flight->anchors[1].place->latitude =
      Angle::degrees(c.flight->anchors[1].place->latitude.degrees() + 3.0 / 111'660.0);
  c.make();
  const AnchorChoice choice = choose_anchors(*c.adjustment, c.points, 2.0);
  EXPECT_TRUE(choice.undecided);
  EXPECT_THAT(choice.used, IsEmpty());
  EXPECT_EQ(choice.rejected.size(), c.points.size());
}

TEST(KnownPoints, SightingsThatCannotBeUsedAreNamed) {
  Case c({0, 0, 0});
  Anchor& ship = c.mark("ship", {0, 5, 30});
  ship.sightings.push_back({"elsewhere.jpg", {1, 1}, 1.0});
  ship.track = {{at_s(18), *ship.place}, {at_s(22), *ship.place}};
  ship.place.reset();
  c.make();
  EXPECT_THAT(c.notes, Contains(HasSubstr("ship: its sighting in elsewhere.jpg was left out")));
  EXPECT_THAT(c.notes, Contains(HasSubstr("its positions do not reach to that time")));
  EXPECT_THAT(c.notes, SizeIs(2));  // not one for each frame
  EXPECT_FALSE(c.points.empty());
  for (const KnownPoint& p : c.points) EXPECT_NEAR(p.frame, 20, 2);
}

/// Ranges of a flight whose recorded heights are `too_high_m` too large.
void range(Case& c, double wrong_every = 0.0) {
  int k = 0;
  for (double t = 0.0; t < kFrames - 1; t += 0.1, ++k) {
    const auto pose = c.flight->trajectory.at(at_s(t), std::chrono::seconds(2)).value();
    const double cosine = (pose.world_from_body.rotation() * Eigen::Vector3d::UnitZ()).z();
    double range_m = kHeight_m / cosine;
    if (wrong_every > 0 && std::fmod(t, wrong_every) < 0.3 * wrong_every) range_m -= 6.0;
    c.flight->ranges.push_back({at_s(t), range_m, 0.05});
  }
}

KnownHeights heights_of(const Case& c, double most_m = 30.0) {
  return known_heights_of(*c.flight, *c.local, *c.navigation, std::chrono::seconds(2), 0.3, most_m);
}

TEST(KnownHeights, AreTheSlantRangesMadeUprightLessTheRecordedHeights) {
  // Down is positive: 8 m too high is -8.
  Case c({0, 0, -8.0});
  range(c);
  c.make();
  const KnownHeights known = heights_of(c);
  EXPECT_THAT(known.notes, IsEmpty());
  EXPECT_GE(known.heights.size(), 7u);
  for (const KnownHeight& h : known.heights) EXPECT_NEAR(h.error_m, -8.0, 0.01);
  c.adjustment->known_heights = known.heights;
  c.adjustment->priors.globals[Globals::kHeight] = 10.0;
  c.adjustment->solve({.rounds = 3, .estimate_variances = false});
  EXPECT_NEAR(c.adjustment->state.globals[Globals::kHeight], -8.0, 0.05);
  EXPECT_NEAR(-c.adjustment->camera(20).position_m.z(), kHeight_m, 0.05);
  const auto sigma = c.adjustment->knowledge();
  ASSERT_TRUE(sigma);
  EXPECT_NEAR(sigma->globals_sigma[Globals::kHeight], 0.3 / std::sqrt(8.0), 0.03);
}

TEST(KnownHeights, MastsAndBirdsDoNotDrawThemDown) {
  Case c({0, 0, -8.0});
  range(c, 20.0);  // 6 s of every 20 measure something 6 m above the sea
  c.make();
  c.adjustment->known_heights = heights_of(c).heights;
  c.adjustment->priors.globals[Globals::kHeight] = 10.0;
  c.adjustment->solve({.rounds = 4, .estimate_variances = false});
  EXPECT_NEAR(c.adjustment->state.globals[Globals::kHeight], -8.0, 0.25);
}

TEST(KnownHeights, ContradictionsAreNamedAndNotUsed) {
  Case c({0, 0, 0});
  range(c);
  for (RangeSample& r : c.flight->ranges) r.range_m *= 0.01;  // centimetres taken for metres
  c.make();
  const KnownHeights known = heights_of(c);
  EXPECT_THAT(known.heights, IsEmpty());
  EXPECT_THAT(known.notes, Contains(HasSubstr("99.0 m lower")));
}

}  // namespace
}  // namespace watersky::align
