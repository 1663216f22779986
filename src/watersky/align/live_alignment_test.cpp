// SPDX-License-Identifier: MIT
#include "watersky/align/live_alignment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "watersky/align/detail/test_flight.hpp"

namespace watersky {
namespace {

/// Ten pictures a second, also in the turn.
const sim::Simulation& flown() {
  static const sim::Simulation simulation = [] {
    sim::Scenario s = test::small_flight();
    s.aircraft.leg_length_m = 60;
    s.camera.frame_rate_hz = 10;
    s.camera.images_in_turns = true;
    return test::simulated(s);
  }();
  return simulation;
}

/// In order of arrival, as a receiver would; `each` sees every frame that comes out.
template <class Each>
LiveAligner fly(const Flight& flight, const Each& each) {
  LiveAligner aligner = LiveAligner::make(flight, {}).value();
  std::size_t pose = 0;
  const auto& poses = flight.trajectory.poses();
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const ImageFrame& f = flight.frames[i];
    for (; pose < poses.size() && poses[pose].time <= *f.received_at; ++pose)
      EXPECT_TRUE(aligner.add_pose(poses[pose]).ok());
    aligner.add_frame(i, {f.captured_at, f.received_at, f.counter}, f.load({}).value());
    for (const LiveFrame& out : aligner.take()) each(out);
  }
  for (const LiveFrame& out : aligner.finish()) each(out);
  return aligner;
}

TEST(LiveAligner, EveryFrameComesOutOnceAndInOrder) {
  std::vector<std::size_t> ids;
  fly(flown().flight, [&](const LiveFrame& f) { ids.push_back(f.id); });
  ASSERT_EQ(ids.size(), flown().flight.frames.size());
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
}

TEST(LiveAligner, FindsTheTimesWhileFlying) {
  double square_s = 0.0;
  int n = 0;
  const LiveAligner aligner = fly(flown().flight, [&](const LiveFrame& f) {
    if (f.method != AlignMethod::Full || !f.aligned) return;
    square_s +=
        std::pow(to_seconds(f.aligned->captured - flown().truth.frames[f.id].captured_at), 2);
    ++n;
  });
  const LiveStatus status = aligner.status();
  EXPECT_TRUE(status.started);
  ASSERT_TRUE(flown().flight.frames.front().counter);
  EXPECT_THAT(status.notes, ::testing::Contains(::testing::HasSubstr("counted")));
  ASSERT_GT(n, static_cast<int>(flown().flight.frames.size()) / 2);
  EXPECT_LT(std::sqrt(square_s / n), 0.05);
  EXPECT_LT(status.after.median_m, 0.5 * status.constant_delay.median_m);
}

TEST(LiveAligner, PosesMayComeInBundles) {
  const Flight& flight = flown().flight;
  LiveAligner aligner = LiveAligner::make(flight, {}).value();
  std::size_t pose = 0, out_of = 0;
  double square_s = 0.0;
  int n = 0;
  const auto count = [&](const std::vector<LiveFrame>& frames) {
    for (const LiveFrame& f : frames) {
      if (!f.aligned) continue;
      ++out_of;
      if (f.method != AlignMethod::Full) continue;
      square_s +=
          std::pow(to_seconds(f.aligned->captured - flown().truth.frames[f.id].captured_at), 2);
      ++n;
    }
  };
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const ImageFrame& f = flight.frames[i];
    const auto& poses = flight.trajectory.poses();
    for (; (i == 0 || i % 7 == 6) && pose < poses.size() && poses[pose].time <= *f.received_at;
         ++pose)
      EXPECT_TRUE(aligner.add_pose(poses[pose]).ok());
    aligner.add_frame(i, {f.captured_at, f.received_at, f.counter}, f.load({}).value());
    count(aligner.take());
  }
  count(aligner.finish());
  // The last ones may have no pose after them.
  EXPECT_GT(out_of + 8, flight.frames.size());
  ASSERT_GT(n, 0);
  EXPECT_LT(std::sqrt(square_s / n), 0.05);
}

TEST(LiveAligner, FramesThatNoPoseFollowsAreNamedNotLost) {
  const Flight& flight = flown().flight;
  LiveAligner aligner = LiveAligner::make(flight, {}).value();
  const auto& poses = flight.trajectory.poses();
  const Time until = poses[poses.size() / 2].time;
  std::size_t pose = 0, with = 0, without = 0;
  const auto count = [&](const std::vector<LiveFrame>& frames) {
    for (const LiveFrame& f : frames) {
      if (f.aligned) {
        ++with;
      } else {
        ++without;
        EXPECT_FALSE(f.aligned.error().message.empty());
      }
    }
  };
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const ImageFrame& f = flight.frames[i];
    for (; pose < poses.size() && poses[pose].time <= *f.received_at && poses[pose].time <= until;
         ++pose)
      EXPECT_TRUE(aligner.add_pose(poses[pose]).ok());
    aligner.add_frame(i, {f.captured_at, f.received_at, f.counter}, f.load({}).value());
    count(aligner.take());
    EXPECT_LE(aligner.status().pending, 90U);
  }
  count(aligner.finish());
  EXPECT_EQ(with + without, flight.frames.size());
  EXPECT_GT(with, 0U);
  EXPECT_GT(without, 0U);
  EXPECT_EQ(aligner.status().pending, 0U);
}

TEST(LiveAligner, TellsWhatItCannotUse) {
  Flight setup = flown().flight;
  setup.sea_level.reset();
  const auto no_sea = LiveAligner::make(setup, {});
  ASSERT_FALSE(no_sea);
  EXPECT_EQ(no_sea.error().code, ErrorCode::NotFound);
  LiveAligner aligner = LiveAligner::make(flown().flight, {}).value();
  const auto& poses = flown().flight.trajectory.poses();
  aligner.add_frame(3, {}, cv::Mat(192, 240, CV_8UC1, cv::Scalar(7)));  // before any pose
  const auto early = aligner.take();
  ASSERT_EQ(early.size(), 1U);
  EXPECT_FALSE(early[0].aligned);
  EXPECT_TRUE(aligner.add_pose(poses[5]).ok());
  const Status backwards = aligner.add_pose(poses[4]);
  ASSERT_FALSE(backwards.ok());
  EXPECT_EQ(backwards.error().code, ErrorCode::OutOfRange);
}

TEST(LiveAligner, NothingToHoldOnToLeavesPosesAsGiven) {
  Flight flight = flown().flight;
  for (ImageFrame& f : flight.frames) {
    cv::Mat flat(192, 240, CV_8UC1, cv::Scalar(90));
    f.load = [flat](const ImageRequest&) { return Result<cv::Mat>(flat); };
  }
  const auto alignment = align_flight_causally(flight, {});
  ASSERT_TRUE(alignment) << alignment.error().message;
  EXPECT_EQ(alignment->method, AlignMethod::AsGiven);
  EXPECT_FALSE(alignment->method_reason.empty());
  // Their uncertainty is that of an unknown delay.
  for (const AlignedFrame& f : alignment->frames) {
    ASSERT_TRUE(f.pose.sigma);
    EXPECT_GT(f.pose.sigma->position_north_east_down_m.head<2>().norm(), 2.0);
  }
}

TEST(AlignFlightCausally, PutsTheSeaTogetherInAFlightThatCanBeMapped) {
  const auto alignment = align_flight_causally(flown().flight, {});
  ASSERT_TRUE(alignment) << alignment.error().message;
  EXPECT_EQ(alignment->method, AlignMethod::Full) << alignment->method_reason;
  EXPECT_EQ(alignment->mount.rotation.coeffs(), flown().flight.mount.rotation.coeffs());
  EXPECT_FALSE(alignment->delay.empty());
  const auto corrected = aligned(flown().flight, *alignment);
  ASSERT_TRUE(corrected) << corrected.error().message;
  EXPECT_EQ(corrected->frames.size(), alignment->frames.size());
  // Until the delay was known no frame had a time.
  EXPECT_EQ(alignment->frames.size() + alignment->left_out.size(), flown().flight.frames.size());
  EXPECT_GT(alignment->frames.size(), flown().flight.frames.size() / 2);
  // The same through the parameter.
  AlignOptions options;
  options.parameters.causal = true;
  const auto same = align_flight(flown().flight, options);
  ASSERT_TRUE(same);
  ASSERT_EQ(same->frames.size(), alignment->frames.size());
  EXPECT_EQ(same->frames.back().captured, alignment->frames.back().captured);
}

}  // namespace
}  // namespace watersky
