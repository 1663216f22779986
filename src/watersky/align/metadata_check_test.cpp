// SPDX-License-Identifier: MIT
#include "watersky/align/metadata_check.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "support/matchers.hpp"
#include "support/real_data.hpp"
#include "watersky/align/detail/flight_edit.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky {
namespace {

using ::testing::HasSubstr;

constexpr Duration kGap = std::chrono::milliseconds(500);

/// Three legs to the north-north-east and back with what real flights have: navigation that wanders
/// by a metre and 0.7°, poses late by a quarter of a second.
sim::Scenario usual() {
  sim::Scenario s = sim::scenario_preset("not_easy").value();
  s.sea.extent_north_m = 320.0;
  s.sea.extent_east_m = 300.0;
  s.lens.focal_px *= 240.0 / s.lens.width_px;
  s.lens.width_px = 240;
  s.lens.height_px = 192;
  s.lens.centre_right_px = 1.6;
  s.lens.centre_down_px = -1.1;
  s.sensor.noise_counts = 2.0;
  s.aircraft.legs = 3;
  s.aircraft.leg_length_m = 120.0;
  s.aircraft.leg_spacing_m = 30.0;
  s.aircraft.leg_azimuth_deg = 25.0;
  s.navigation.nav_position_sigma_m = 1.0;
  s.navigation.nav_attitude_sigma_deg = 0.7;
  s.navigation.nav_delay_s = 0.25;
  return s;
}

/// With a mount 2° off from what is said of it.
Flight flown(const sim::Scenario& scenario) {
  Flight flight = sim::simulate(scenario).value().flight;
  flight.mount.rotation =
      flight.mount.rotation *
      quaternion(Angle::degrees(2.0), Eigen::Vector3d(1.0, 0.5, -0.7).normalized());
  return flight;
}

using PoseFault = std::function<void(YawPitchRoll&, Point<World>&)>;

/// As a recording with the fault would have it: with no word of its sigmas.
void record_wrongly(Flight& flight, const PoseFault& fault) {
  std::vector<StampedPose> poses = flight.trajectory.poses();
  for (StampedPose& pose : poses) {
    YawPitchRoll angles = yaw_pitch_roll(pose.world_from_body.rotation());
    Point<World> at = pose.world_from_body.origin();
    fault(angles, at);
    pose = {pose.time, {rotation_from(angles), at}, std::nullopt};
  }
  flight.trajectory = Trajectory::make(std::move(poses)).value();
}

void store_turned(Flight& flight, std::size_t first, std::size_t last, int quarter_turns) {
  for (std::size_t i = first; i <= last; ++i)
    flight.frames.at(i).load = [load = flight.frames.at(i).load,
                                quarter_turns](const ImageRequest& request) -> Result<cv::Mat> {
      WATERSKY_TRY(const cv::Mat image, load(request));
      cv::Mat stored;
      cv::rotate(image, stored,
                 quarter_turns == 1   ? cv::ROTATE_90_CLOCKWISE
                 : quarter_turns == 2 ? cv::ROTATE_180
                                      : cv::ROTATE_90_COUNTERCLOCKWISE);
      return stored;
    };
}

/// How far two flights put the middle of a frame apart on the sea, m; the larger of all frames.
double apart_m(const Flight& a, const Flight& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const auto middle = [&](const Flight& flight) {
      const CameraPose pose = flight.camera_pose(flight.frames[i], kGap).value();
      const Eigen::Vector3d d = pose.sea_from_camera.rotation() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d c = pose.sea_from_camera.origin().v;
      return (pose.world_from_camera *
              (pose.sea_from_camera.inverse() * Point<Sea>{c - (c.z() / d.z()) * d}))
          .v;
    };
    most = std::max(most, (middle(a) - middle(b)).norm());
  }
  return most;
}

std::string report_of(const MetadataCheck& check) {
  std::string out = check.summary;
  for (const MetadataFinding& finding : check.findings) out += "\n  " + finding.sentence;
  return out;
}

struct PoseFaultCase {
  const char* name;
  MetadataFault fault;
  const char* words;
  PoseFault record;
  double restored_m = 0.5;  ///< how near the mended flight must come to the one without the fault
};

class PoseFaults : public ::testing::TestWithParam<PoseFaultCase> {};

TEST_P(PoseFaults, AreFoundNamedAndMended) {
  const Flight right = flown(usual());
  Flight wrong = right;
  record_wrongly(wrong, GetParam().record);
  const MetadataCheck check = check_metadata(wrong).value();
  ASSERT_EQ(check.findings.size(), 1u) << report_of(check);
  const MetadataFinding& finding = check.findings[0];
  EXPECT_EQ(finding.fault, GetParam().fault) << report_of(check);
  EXPECT_TRUE(finding.certain) << report_of(check);
  EXPECT_TRUE(finding.frames.empty());
  EXPECT_THAT(finding.sentence, HasSubstr(GetParam().words));
  EXPECT_LT(finding.after_m, 0.45 * finding.before_m);
  EXPECT_LT(check.mended_disagreement_m, 1.5);
  EXPECT_FALSE(check.contradiction);
  const Flight better = mended(wrong, check.findings).value();
  EXPECT_LT(apart_m(better, right), GetParam().restored_m) << report_of(check);
  ASSERT_EQ(better.notes.size(), right.notes.size() + 1);
  EXPECT_EQ(better.notes.back(), finding.sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Metadata, PoseFaults,
    ::testing::Values(
        PoseFaultCase{"YawSign", MetadataFault::YawSign, "the yaw angles have the wrong sign",
                      [](YawPitchRoll& a, Point<World>&) { a.yaw = -a.yaw; }},
        PoseFaultCase{"YawFromEast", MetadataFault::YawFromEast, "counter-clockwise from east",
                      [](YawPitchRoll& a, Point<World>&) { a.yaw = Angle::degrees(90) - a.yaw; }},
        PoseFaultCase{"YawOffByAQuarter", MetadataFault::YawOffset, "all headings are off by 90°",
                      [](YawPitchRoll& a, Point<World>&) { a.yaw = a.yaw + Angle::degrees(90); }},
        PoseFaultCase{"RollSign", MetadataFault::RollSign, "the roll angles have the wrong sign",
                      [](YawPitchRoll& a, Point<World>&) { a.roll = -a.roll; }},
        PoseFaultCase{"PitchSign", MetadataFault::PitchSign, "the pitch angles have the wrong sign",
                      [](YawPitchRoll& a, Point<World>&) { a.pitch = -a.pitch; }},
        PoseFaultCase{"RollPitchSwapped", MetadataFault::RollPitchSwapped, "each other's place",
                      [](YawPitchRoll& a, Point<World>&) { std::swap(a.roll, a.pitch); }},
        PoseFaultCase{"AllSigns", MetadataFault::AllSigns, "yaw, pitch and roll",
                      [](YawPitchRoll& a, Point<World>&) {
                        a = {-a.yaw, -a.pitch, -a.roll};
                      }},
        PoseFaultCase{"EastNorthUp", MetadataFault::EastNorthUp, "against east, north, up",
                      [](YawPitchRoll& a, Point<World>&) {
                        a.yaw = Angle::degrees(90) - a.yaw;
                        a.pitch = -a.pitch;
                      }},
        // The sea lies 12 m below the datum, which pictures alone can hardly tell from 100 m.
        PoseFaultCase{"HeightsInFeet", MetadataFault::HeightsInFeet, "heights are feet above",
                      [](YawPitchRoll&, Point<World>& at) { at.v.z() /= 0.3048; }, 5.0},
        PoseFaultCase{"PositionsInFeet", MetadataFault::PositionsInFeet, "north and east are feet",
                      [](YawPitchRoll&, Point<World>& at) { at.v.head<2>() /= 0.3048; }},
        PoseFaultCase{
            "GeoidForEllipsoid", MetadataFault::HeightReference,
            "above the geoid and above the ellipsoid, 36.6 m apart here",
            [](YawPitchRoll&, Point<World>& at) {
              at.v.z() +=
                  egm96_above_ellipsoid_m(Angle::degrees(78.9), Angle::degrees(11.9)).value();
            }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Metadata, ACameraMountedTheOtherWayRoundIsFoundAndMended) {
  const Flight right = flown(usual());
  Flight wrong = right;
  wrong.mount.rotation =
      right.mount.rotation * quaternion(Angle::degrees(180), Eigen::Vector3d::UnitZ());
  const MetadataCheck check = check_metadata(wrong).value();
  ASSERT_EQ(check.findings.size(), 1u) << report_of(check);
  EXPECT_EQ(check.findings[0].fault, MetadataFault::CameraTurned) << report_of(check);
  EXPECT_TRUE(check.findings[0].certain);
  EXPECT_LT(apart_m(mended(wrong, check.findings).value(), right), 1e-6);
}

TEST(Metadata, AnOffsetOfTheCompassIsSuspectedAndLeft) {
  Flight wrong = flown(usual());
  record_wrongly(wrong, [](YawPitchRoll& a, Point<World>&) { a.yaw = a.yaw + Angle::degrees(25); });
  const MetadataCheck check = check_metadata(wrong).value();
  ASSERT_EQ(check.findings.size(), 1u) << report_of(check);
  EXPECT_EQ(check.findings[0].fault, MetadataFault::YawOffset);
  EXPECT_FALSE(check.findings[0].certain);
  EXPECT_NEAR(check.findings[0].turn.degrees(), -25.0, 6.0);
  EXPECT_THAT(check.findings[0].sentence, HasSubstr("left as recorded"));
  EXPECT_EQ(apart_m(mended(wrong, check.findings).value(), wrong), 0.0);
}

TEST(Metadata, AHeightOffByAQuarterIsSuspectedWithTheHeightThatIsShown) {
  Flight wrong = flown(usual());
  record_wrongly(wrong, [](YawPitchRoll&, Point<World>& at) {
    at.v.z() = 12.0 - 0.75 * (12.0 - at.v.z());  // the sea is 12 m below the datum
  });
  const MetadataCheck check = check_metadata(wrong).value();
  ASSERT_EQ(check.findings.size(), 1u) << report_of(check);
  EXPECT_EQ(check.findings[0].fault, MetadataFault::HeightScale) << report_of(check);
  EXPECT_FALSE(check.findings[0].certain);
  EXPECT_THAT(check.findings[0].sentence, HasSubstr("the metadata 7"));
}

struct CleanCase {
  const char* name;
  std::function<void(sim::Scenario&)> set;
};

class CleanFlights : public ::testing::TestWithParam<CleanCase> {};

TEST_P(CleanFlights, AreLeftAlone) {
  sim::Scenario scenario = usual();
  GetParam().set(scenario);
  const MetadataCheck check = check_metadata(flown(scenario)).value();
  EXPECT_TRUE(check.checked) << report_of(check);
  EXPECT_TRUE(check.findings.empty()) << report_of(check);
  EXPECT_FALSE(check.contradiction) << report_of(check);
  EXPECT_THAT(check.summary, HasSubstr("agree with the pictures"));
}

INSTANTIATE_TEST_SUITE_P(
    Metadata, CleanFlights,
    ::testing::Values(
        CleanCase{"Nadir", [](sim::Scenario&) {}},
        CleanCase{"Oblique", [](sim::Scenario& s) { s.camera.mount_pitch_deg = -60; }},
        CleanCase{"Gimbal",
                  [](sim::Scenario& s) {
                    s.camera.gimbal = 2;
                    s.camera.mount_pitch_deg = -70;
                  }},
        CleanCase{"GimbalOnTheBody", [](sim::Scenario& s) { s.camera.gimbal = 1; }},
        CleanCase{"GimbalStraightDown", [](sim::Scenario& s) { s.camera.gimbal = 2; }},
        CleanCase{"OneLeg",
                  [](sim::Scenario& s) {
                    s.aircraft.legs = 1;
                    s.aircraft.leg_length_m = 240;
                  }},
        CleanCase{"EastAndWest", [](sim::Scenario& s) { s.aircraft.leg_azimuth_deg = 90; }},
        CleanCase{"PoorGnssAndHalfASecond",
                  [](sim::Scenario& s) {
                    s.navigation.nav_position_sigma_m = 2;
                    s.navigation.nav_delay_s = 0.5;
                  }},
        CleanCase{"NoiseAnewInEachPose",
                  [](sim::Scenario& s) { s.navigation.nav_correlation_s = 0; }},
        CleanCase{"DriftingIce", [](sim::Scenario& s) { s.drift_north_m_s = 0.5; }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Metadata, TurnedImagesAreNamedAndTurnedBackToThePixel) {
  const Flight right = flown(usual());
  Flight wrong = right;
  store_turned(wrong, 7, 10, 2);
  const MetadataCheck check = check_metadata(wrong).value();
  ASSERT_EQ(check.findings.size(), 1u) << report_of(check);
  const MetadataFinding& finding = check.findings[0];
  EXPECT_EQ(finding.fault, MetadataFault::TurnedImages);
  EXPECT_TRUE(finding.certain);
  EXPECT_EQ(finding.frames, (std::vector<std::size_t>{7, 8, 9, 10}));
  EXPECT_EQ(finding.quarter_turns, 2);
  EXPECT_THAT(finding.sentence,
              HasSubstr(right.frames[7].name + " to " + right.frames[10].name +
                        " are stored turned by half a turn against their recorded heading"));
  EXPECT_THAT(finding.sentence, HasSubstr("; turned back"));
  const Flight better = mended(wrong, check.findings).value();
  for (const std::size_t i : {std::size_t{6}, std::size_t{8}})
    for (const int reduction : {1, 4})
      EXPECT_EQ(cv::norm(*better.frames[i].load({.reduction = reduction}),
                         *right.frames[i].load({.reduction = reduction}), cv::NORM_INF),
                0.0);
}

TEST(Metadata, ImagesStoredByAQuarterTurnAreFoundWhereTheyAreSquare) {
  sim::Scenario scenario = usual();
  scenario.lens.width_px = scenario.lens.height_px = 216;
  Flight wrong = flown(scenario);
  store_turned(wrong, 7, 10, 3);
  const MetadataCheck check = check_metadata(wrong).value();
  ASSERT_EQ(check.findings.size(), 1u) << report_of(check);
  EXPECT_TRUE(check.findings[0].certain);
  EXPECT_EQ(check.findings[0].frames, (std::vector<std::size_t>{7, 8, 9, 10}));
  EXPECT_EQ(check.findings[0].quarter_turns, 3);
  EXPECT_THAT(check.findings[0].sentence, HasSubstr("a quarter turn counter-clockwise"));
}

TEST(Metadata, OfManyFramesASampleIsCheckedAndTurnedOnesAreThenAllFound) {
  sim::Scenario scenario = usual();
  scenario.camera.frame_rate_hz = 3.0;
  scenario.aircraft.legs = 2;
  MetadataCheckParameters few;
  few.most_pairs = 16;
  few.most_pairs_if_suspicious = 200;
  Flight flight = flown(scenario);
  const std::size_t count = flight.frames.size();
  ASSERT_GT(count, 36u);
  const MetadataCheck clean = check_metadata(flight, few).value();
  EXPECT_TRUE(clean.findings.empty()) << report_of(clean);
  EXPECT_LE(clean.pairs_tried, 2u * 16u);
  store_turned(flight, count / 2 + 2, count - 1, 2);
  const MetadataCheck check = check_metadata(flight, few).value();
  ASSERT_FALSE(check.findings.empty()) << report_of(check);
  EXPECT_TRUE(check.findings[0].certain);
  EXPECT_GE(check.findings[0].frames.size(), (count - 1) - (count / 2 + 2) - 1);
  for (const std::size_t i : check.findings[0].frames) EXPECT_GE(i, count / 2 + 2);
}

TEST(Metadata, ThousandsOfFramesCostNoMoreThanTheSample) {
  sim::Scenario scenario = usual();
  scenario.camera.frame_rate_hz = 100.0;
  scenario.navigation.pose_rate_hz = 10.0;
  Flight flight = flown(scenario);
  ASSERT_GT(flight.frames.size(), 1500u);
  auto loads = std::make_shared<int>(0);
  for (ImageFrame& frame : flight.frames)
    frame.load = [loads](const ImageRequest&) -> Result<cv::Mat> {
      ++*loads;
      return Error{ErrorCode::Io, "the disk is gone"};
    };
  const MetadataCheck check = check_metadata(flight).value();
  EXPECT_FALSE(check.checked);
  EXPECT_THAT(check.summary, HasSubstr("the disk is gone"));
  // Each pair is tried again half as far apart, down to neighbours.
  EXPECT_LE(check.pairs_tried, 60u * 10u);
  EXPECT_LE(*loads, 60 * 11);
}

TEST(Metadata, WhatCannotBeCheckedSaysWhy) {
  sim::Scenario water = usual();
  water.sea.concentration = 0.0;
  water.sea.isolated_count = 0;
  water.sea.lead_count = 0;
  water.sensor.water_texture = 0.0;
  const MetadataCheck featureless = check_metadata(flown(water)).value();
  EXPECT_FALSE(featureless.checked);
  EXPECT_TRUE(featureless.findings.empty());
  EXPECT_THAT(featureless.summary, HasSubstr("could not be checked"));
  EXPECT_THAT(featureless.summary, HasSubstr("pairs of frames could be registered"));

  Flight one = flown(usual());
  one.frames.resize(1);
  EXPECT_THAT(check_metadata(one).value().summary, HasSubstr("only one frame has a pose"));

  Flight timeless = flown(usual());
  for (ImageFrame& frame : timeless.frames) frame.captured_at.reset();
  timeless.delay_s.reset();
  EXPECT_THAT(check_metadata(timeless).value().summary, HasSubstr("give the delay"));

  Flight nowhere = flown(usual());
  nowhere.sea_level.reset();
  EXPECT_THAT(check_metadata(nowhere).value().summary, HasSubstr("the height of the sea"));

  Flight empty = flown(usual());
  empty.frames.clear();
  EXPECT_FALSE(check_metadata(empty).value().checked);

  MetadataCheckParameters bad;
  bad.most_pairs = 1;
  EXPECT_TRUE(test::fails_with(check_metadata(one, bad), ErrorCode::Usage, {"most_pairs"}));
}

TEST(Mended, LeavesWhatIsOnlySuspectedAndRefusesFindingsOfAnotherFlight) {
  Flight flight = flown(usual());
  MetadataFinding finding;
  finding.frames = {flight.frames.size()};
  finding.quarter_turns = 2;
  EXPECT_TRUE(mended(flight, std::vector{finding}).ok());
  finding.certain = true;
  EXPECT_TRUE(
      test::fails_with(mended(flight, std::vector{finding}), ErrorCode::Usage, {"another flight"}));
}

// The marks of anchors stay on what they mark.
TEST(Mended, TurnsTheMarksOfAnchorsWithTheirImages) {
  for (const int turns : {1, 2, 3}) {
    Flight flight = flown(usual());
    const cv::Size size(flight.camera.width_px(), flight.camera.height_px());
    cv::Mat stored = turns == 2 ? cv::Mat(size, CV_8U, cv::Scalar(0))
                                : cv::Mat(size.width, size.height, CV_8U, cv::Scalar(0));
    stored.at<uchar>(40, 70) = 255;
    flight.frames[1].load = [stored](const ImageRequest&) { return Result<cv::Mat>(stored); };
    Anchor anchor;
    anchor.sightings = {{flight.frames[0].name, {70, 40}, 1}, {flight.frames[1].name, {70, 40}, 1}};
    flight.anchors = {anchor};
    MetadataFinding finding;
    finding.frames = {1};
    finding.quarter_turns = turns;
    finding.certain = true;
    const Flight better = mended(flight, std::vector{finding}).value();
    const cv::Mat image = better.frames[1].load({}).value();
    const Pixel at = better.anchors[0].sightings[1].px;
    EXPECT_EQ(image.at<uchar>(static_cast<int>(at.v), static_cast<int>(at.u)), 255) << turns;
    EXPECT_EQ(better.anchors[0].sightings[0].px.u, 70);
  }
}

TEST(TurnedBack, GivesTheVeryPixelsAtEachReductionAlsoWhereBlocksDoNotTile) {
  cv::RNG random(3);
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(37, 50), cv::Size(33, 33)}) {
    cv::Mat native(size, CV_8UC3);
    random.fill(native, cv::RNG::UNIFORM, 0, 256);
    const auto reduced = [](const cv::Mat& image, int n) {
      const cv::Size small((image.cols + n - 1) / n, (image.rows + n - 1) / n);
      cv::Mat out;
      cv::copyMakeBorder(image, out, 0, small.height * n - image.rows, 0,
                         small.width * n - image.cols, cv::BORDER_REPLICATE);
      cv::resize(out, out, small, 0, 0, cv::INTER_AREA);
      return out;
    };
    for (const int turns : {0, 1, 2, 3, -1}) {
      cv::Mat stored = native.clone();
      for (int k = 0; k < (turns + 4) % 4; ++k) cv::rotate(stored, stored, cv::ROTATE_90_CLOCKWISE);
      for (const bool reduces : {true, false}) {
        const ImageLoader load = turned_back(
            [&](const ImageRequest& request) -> Result<cv::Mat> {
              return reduces ? reduced(stored, request.reduction) : stored.clone();
            },
            turns, size.width, size.height);
        for (const int n : {1, 2, 4, 8}) {
          const cv::Mat got = load({.reduction = n}).value();
          const cv::Mat want =
              got.size() == native.size() && !reduces ? native : reduced(native, n);
          ASSERT_EQ(got.size(), want.size());
          EXPECT_LE(cv::norm(got, want, cv::NORM_INF), 1.0);  // a mean of means rounds twice
        }
      }
    }
  }
}

TEST(TurnedBack, PutsEachPixelWhereNativePixelSays) {
  const cv::Size size(7, 5);
  cv::Mat native(size, CV_8U);
  for (int i = 0; i < 35; ++i) native.at<std::uint8_t>(i / 7, i % 7) = static_cast<std::uint8_t>(i);
  cv::Mat stored = native.clone();
  for (int turns = 0; turns < 4; ++turns) {
    for (int v = 0; v < stored.rows; ++v)
      for (int u = 0; u < stored.cols; ++u) {
        const Pixel p = detail::native_pixel({1.0 * u, 1.0 * v}, turns, size.width, size.height);
        EXPECT_EQ(stored.at<std::uint8_t>(v, u),
                  native.at<std::uint8_t>(static_cast<int>(p.v), static_cast<int>(p.u)));
      }
    cv::rotate(stored, stored, cv::ROTATE_90_CLOCKWISE);
  }
}

MetadataCheck check_real(const char* name, const char* sea_level) {
  ReadOptions options;
  options.sea_level = parse_sea_level_option(sea_level).value();
  const Flight flight = read_flight(*test::real_data(name), options).value();
  MetadataCheckParameters parameters;
  parameters.pairs.longer_side_px = 500;  // half of the usual time
  MetadataCheck check = check_metadata(flight, parameters).value();
  std::printf("%s\n", report_of(check).c_str());
  for (const MetadataFinding& finding : check.findings)
    for (const std::size_t i : finding.frames) std::printf("  %s\n", flight.frames[i].name.c_str());
  return check;
}

TEST(RealMetadata, SixFramesOfBrightonBeachAreStoredTurned) {
  if (!test::real_data("brighton_beach")) GTEST_SKIP() << "brighton_beach is not here";
  const MetadataCheck check = check_real("brighton_beach", "takeoff:-2");
  ASSERT_EQ(check.findings.size(), 1u);
  const MetadataFinding& finding = check.findings[0];
  EXPECT_TRUE(finding.certain);
  EXPECT_EQ(finding.fault, MetadataFault::TurnedImages);
  EXPECT_EQ(finding.quarter_turns, 2);
  EXPECT_THAT(finding.sentence, HasSubstr("DJI_0024.JPG to DJI_0029.JPG are stored turned"));
  EXPECT_GT(finding.before_m, 20.0);
  EXPECT_LT(finding.after_m, 2.5);
  EXPECT_LT(check.mended_disagreement_m, 2.0);
}

TEST(RealMetadata, TheCuavFlightIsLeftAlone) {
  if (!test::real_data("cuav_flight")) GTEST_SKIP() << "cuav_flight is not here";
  const MetadataCheck check = check_real("cuav_flight", "takeoff:0");
  EXPECT_TRUE(check.checked);
  EXPECT_TRUE(check.findings.empty());
  EXPECT_LT(check.disagreement_m, 2.0);
}

}  // namespace
}  // namespace watersky
