// SPDX-License-Identifier: MIT
#include "watersky/align/frame_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <random>
#include <set>

#include "support/matchers.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/registration/homography.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky {
namespace {

using ::testing::HasSubstr;

/// Two legs side by side, there and back; the frames along a leg share 80 %.
sim::Scenario quick() {
  sim::Scenario s = sim::scenario_preset("not_easy").value();
  s.sea.extent_north_m = 300.0;
  s.sea.extent_east_m = 260.0;
  s.lens.focal_px *= 240.0 / s.lens.width_px;
  s.lens.width_px = 240;
  s.lens.height_px = 192;
  s.lens.centre_right_px = 1.6;
  s.lens.centre_down_px = -1.1;
  s.sensor.noise_counts = 2.0;
  s.aircraft.legs = 2;
  s.aircraft.leg_length_m = 100.0;
  s.aircraft.leg_spacing_m = 30.0;
  return s;
}

/// A level frame that looks straight down from `north`, `east`, 100 m up, heading `heading_deg`.
Flight drawn_flight(const std::vector<std::array<double, 3>>& north_east_heading) {
  Eigen::Matrix3d matrix;
  matrix << 100, 0, 49.5, 0, 100, 39.5, 0, 0, 1;
  Flight flight("drawn", Datum({Angle::degrees(60), Angle::degrees(5), 0}),
                CameraModel::make(LensModel::Pinhole, 100, 80, matrix).value());
  flight.mount.rotation = camera_rotation({{}, Angle::degrees(-90), {}});
  flight.sea_level = SeaLevel{[](const Geodetic&) { return Result<double>(-100.0); }, "drawn", 0.0};
  double t = 0.0;
  for (const auto& [north, east, heading_deg] : north_east_heading) {
    ImageFrame frame;
    frame.name = "frame " + std::to_string(flight.frames.size());
    frame.own_pose =
        StampedPose{*time_from_seconds(t += 1.0),
                    {heading(Angle::degrees(heading_deg)), Point<World>{{north, east, 0}}},
                    std::nullopt};
    flight.frames.push_back(std::move(frame));
  }
  return flight;
}

TEST(Overlap, IsTheShareOfTheSmallerFootprint) {
  // 100 m across by 80 m along.
  const Flight flight = drawn_flight({{0, 0, 0}, {40, 0, 0}, {0, 25, 180}, {0, 0, 90}, {81, 0, 0}});
  const auto placed = place_frames(flight).frames;
  ASSERT_EQ(placed.size(), 5u);
  EXPECT_NEAR(placed[0].height_m(), 100.0, 1e-6);
  EXPECT_NEAR(overlap_share(placed[0], placed[0]), 1.0, 1e-4);
  EXPECT_NEAR(overlap_share(placed[0], placed[1]), 0.5, 1e-3);
  EXPECT_NEAR(overlap_share(placed[0], placed[2]), 0.75, 1e-3);
  EXPECT_NEAR(overlap_share(placed[0], placed[3]), 0.8, 1e-3);
  EXPECT_EQ(overlap_share(placed[0], placed[4]), 0.0);
}

TEST(Overlap, FramesWithoutAPoseOrASightOfTheSeaAreLeftOutWithTheReason) {
  Flight flight = drawn_flight({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  flight.frames[0].own_pose.reset();
  flight.frames[1].own_pose->world_from_body = {
      rotation_from({{}, {}, Angle::degrees(180)}),
      flight.frames[1].own_pose->world_from_body.origin()};
  const PlacedFrames placed = place_frames(flight);
  ASSERT_EQ(placed.frames.size(), 1u);
  EXPECT_EQ(placed.frames[0].frame, 2u);
  ASSERT_EQ(placed.left_out.size(), 2u);
  EXPECT_THAT(placed.left_out[0].reason, HasSubstr("capture time"));
  EXPECT_THAT(placed.left_out[1].reason, HasSubstr("no part of the image sees the sea"));
}

TEST(ChoosePairs, TakesNeighboursAndRevisitsSpreadOverTime) {
  // Ten frames north, ten back 20 m to the side.
  std::vector<std::array<double, 3>> places;
  places.reserve(3000);
  for (int i = 0; i < 10; ++i) places.push_back({20.0 * i, 0, 0});
  for (int i = 0; i < 10; ++i) places.push_back({180 - 20.0 * i, 20, 180});
  const auto placed = place_frames(drawn_flight(places)).frames;
  const auto pairs = choose_pairs(placed);
  std::map<std::size_t, int> revisits;
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (const FrameOverlap& pair : pairs) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_EQ(pair.consecutive, pair.a + 1 == pair.b);
    EXPECT_NEAR(pair.share, overlap_share(placed[pair.a], placed[pair.b]), 1e-12);
    EXPECT_GE(pair.share, FramePairParameters().min_overlap);
    EXPECT_TRUE(seen.insert({pair.a, pair.b}).second);
    if (!pair.consecutive) ++revisits[pair.b];
  }
  for (const auto& [frame, count] : revisits) EXPECT_LE(count, 3) << frame;
  for (std::size_t i = 0; i + 1 < placed.size(); ++i) EXPECT_TRUE(seen.contains({i, i + 1})) << i;
  // The last frame lies beside the first.
  EXPECT_TRUE(seen.contains({0, 19}));
  EXPECT_TRUE(seen.contains({4, 15}));
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end(), [](const auto& x, const auto& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  }));
}

TEST(ChoosePairs, TheGridFindsEveryRevisitThatThereIs) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-400, 400), turn(0, 360);
  for (int run = 0; run < 5; ++run) {
    std::vector<std::array<double, 3>> places;
    places.reserve(3000);
    for (int i = 0; i < 60; ++i) places.push_back({place(random), place(random), turn(random)});
    const auto placed = place_frames(drawn_flight(places)).frames;
    FramePairParameters all;
    all.most_revisits = 1000;
    all.min_overlap = 0.3;
    std::set<std::size_t> with, brute;
    for (const FrameOverlap& pair : choose_pairs(placed, all)) with.insert(pair.b);
    for (std::size_t b = 0; b < placed.size(); ++b)
      for (std::size_t a = 0; a < b; ++a)
        if (overlap_share(placed[a], placed[b]) >= all.min_overlap) brute.insert(b);
    EXPECT_EQ(with, brute);
  }
}

TEST(ChoosePairs, ThousandsOfFramesOverOnePlaceAreNoTrouble) {
  std::vector<std::array<double, 3>> places;
  places.reserve(3000);
  for (int i = 0; i < 3000; ++i)
    places.push_back({3.0 * (i % 600), 40.0 * std::floor(i / 600.0), i % 2 == 0 ? 0.0 : 1.0});
  const auto placed = place_frames(drawn_flight(places)).frames;
  const auto pairs = choose_pairs(placed);
  EXPECT_LE(pairs.size(), 4 * placed.size());
  EXPECT_GE(pairs.size(), 3 * placed.size());
}

TEST(PredictedHomography, GoesThroughTheSeaAndTheLens) {
  const auto run = sim::simulate(quick()).value();
  const auto placed = place_frames(run.flight).frames;
  const CameraModel plain = run.flight.camera.without_distortion();
  int tried = 0;
  for (const FrameOverlap& pair : choose_pairs(placed)) {
    const PlacedFrame &a = placed[pair.a], &b = placed[pair.b];
    // Without distortion it is a homography exactly.
    const auto exact = predicted_homography(plain, a, b, Angle::degrees(10));
    const auto lens = predicted_homography(run.flight.camera, a, b, Angle::degrees(10));
    ASSERT_TRUE(exact && lens);
    for (double u = 20; u < 240; u += 50)
      for (double v = 20; v < 192; v += 50) {
        const auto through = [&](const CameraModel& camera) -> std::optional<cv::Point2d> {
          const Vector<Camera> ray = camera.direction({u, v}).value();
          const Eigen::Vector3d d = (a.pose.sea_from_camera * ray).v;
          const Eigen::Vector3d c = a.pose.sea_from_camera.origin().v;
          const Point<World> sea = a.world_from_sea * Point<Sea>{c - (c.z() / d.z()) * d};
          const auto q = camera.project(b.pose.world_from_camera.inverse() * sea);
          if (!q || !camera.contains(*q)) return std::nullopt;
          return cv::Point2d(q->u, q->v);
        };
        if (const auto q = through(plain)) {
          EXPECT_LT(cv::norm(apply(*exact, {u, v}) - *q), 0.01);
        }
        // The lens of this flight bends by some pixels in the corners.
        if (const auto q = through(run.flight.camera)) {
          EXPECT_LT(cv::norm(apply(*lens, {u, v}) - *q), 4.0);
        }
      }
    if (++tried == 12) break;
  }
  EXPECT_GE(tried, 8);
}

TEST(RegisterPairs, TiePointsLieOnOnePlaceOfTheSea) {
  const auto run = sim::simulate(quick()).value();
  const auto placed = place_frames(run.flight).frames;
  const auto chosen = choose_pairs(placed);
  const auto pairs = register_pairs(run.flight, placed, chosen);
  ASSERT_TRUE(pairs.ok()) << pairs.error().message;
  ASSERT_EQ(pairs->size(), chosen.size());
  std::map<std::size_t, const PlacedFrame*> by_frame;
  for (const PlacedFrame& frame : placed) by_frame[frame.frame] = &frame;
  std::size_t registered = 0, revisits = 0;
  std::vector<double> off_m;
  for (const RegisteredPair& pair : *pairs) {
    if (!pair.registered()) {
      EXPECT_FALSE(pair.reason.empty());
      EXPECT_TRUE(pair.points.empty());
      continue;
    }
    ++registered;
    if (!pair.consecutive) ++revisits;
    EXPECT_LE(pair.points.size(), 40u);
    EXPECT_GE(pair.points.size(), 10u);
    for (const PointPair& p : pair.points) {
      const auto on_sea = [&](std::size_t frame, cv::Point2d at) {
        const PlacedFrame& placed_frame = *by_frame[frame];
        const Eigen::Vector3d d =
            (placed_frame.pose.sea_from_camera * run.flight.camera.direction({at.x, at.y}).value())
                .v;
        const Eigen::Vector3d c = placed_frame.pose.sea_from_camera.origin().v;
        return (placed_frame.world_from_sea * Point<Sea>{c - (c.z() / d.z()) * d}).v;
      };
      off_m.push_back((on_sea(pair.a, p.a) - on_sea(pair.b, p.b)).norm());
    }
  }
  EXPECT_GE(registered, chosen.size() / 2);  // little of 240 pixels is refused, as it should be
  EXPECT_GE(revisits, 4u);
  std::nth_element(off_m.begin(), off_m.begin() + static_cast<std::ptrdiff_t>(off_m.size() / 2),
                   off_m.end());
  EXPECT_LT(off_m[off_m.size() / 2], 0.3);  // a pixel is 0.35 m
}

TEST(RegisterPairs, PointsAreThoseOfTheFullImage) {
  const auto run = sim::simulate(quick()).value();
  const auto placed = place_frames(run.flight).frames;
  std::vector<FrameOverlap> chosen = choose_pairs(placed);
  chosen.resize(2);
  FramePairParameters half;
  half.longer_side_px = 120;
  const auto full_pairs = register_pairs(run.flight, placed, chosen).value();
  const auto half_pairs = register_pairs(run.flight, placed, chosen, half).value();
  int compared = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (!full_pairs[i].fit || !half_pairs[i].fit) continue;
    EXPECT_LT(corner_error_px(full_pairs[i].fit->b_from_a, half_pairs[i].fit->b_from_a, {240, 192}),
              3.0);
    ++compared;
  }
  EXPECT_GE(compared, 1);
}

TEST(RegisterPairs, EachImageIsLoadedOnceAndOneThatCannotBeIsAReason) {
  auto run = sim::simulate(quick()).value();
  auto loads = std::make_shared<std::map<std::string, int>>();
  for (ImageFrame& frame : run.flight.frames) {
    const bool broken = frame.name == run.flight.frames[1].name;
    frame.load = [load = frame.load, loads, name = frame.name,
                  broken](const ImageRequest& request) -> Result<cv::Mat> {
      ++(*loads)[name];
      if (broken) return Error{ErrorCode::Io, "the disk is gone"};
      return load(request);
    };
  }
  const auto placed = place_frames(run.flight).frames;
  const auto chosen = choose_pairs(placed);
  const auto pairs = register_pairs(run.flight, placed, chosen).value();
  for (const auto& [name, count] : *loads) EXPECT_EQ(count, 1) << name;
  for (const RegisteredPair& pair : pairs)
    if (pair.a == 1 || pair.b == 1) {
      EXPECT_THAT(pair.reason, HasSubstr("the disk is gone"));
    }
  // With room for three only, some are loaded again and the result is the same.
  FramePairParameters few;
  few.most_prepared = 3;
  const auto again = register_pairs(run.flight, placed, chosen, few).value();
  for (std::size_t i = 0; i < pairs.size(); ++i)
    EXPECT_EQ(pairs[i].points.size(), again[i].points.size());
}

TEST(RegisterPairs, NoPairsAreNoTroubleAndBadParametersAreRefused) {
  const Flight flight = drawn_flight({{0, 0, 0}});
  EXPECT_TRUE(choose_pairs({}).empty());
  EXPECT_TRUE(register_pairs(flight, {}, {}).value().empty());
  FramePairParameters bad;
  bad.most_points = 0;
  EXPECT_TRUE(test::fails_with(register_pairs(flight, {}, {}, bad), ErrorCode::Usage,
                               {"most_points must be from 5"}));
}

}  // namespace
}  // namespace watersky
