// SPDX-License-Identifier: MIT
// What is neither water nor ice, and what the camera adds of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "story.hpp"

namespace watersky {
namespace {

constexpr const char* kSea = R"(
    ..........
    .####.....
    .####.....
    .####.##..
    ..........
    ......###.
    ..........)";

/// The same flight with each frame's pixels changed.
template <class Change>
Flight changed(const Flight& flight, const Change& change) {
  Flight other = flight;
  for (std::size_t i = 0; i < other.frames.size(); ++i)
    other.frames[i].load = [load = flight.frames[i].load, change,
                            i](const ImageRequest& request) -> Result<cv::Mat> {
      auto image = load(request);
      if (image) {
        *image = image->clone();
        change(i, *image);
      }
      return image;
    };
  return other;
}

/// 16 bit, as a thermal camera's counts: 40 counts a level, from 6000.
Flight in_counts(const Flight& flight) {
  return changed(flight, [](std::size_t, cv::Mat& image) {
    cv::Mat counts;
    image.convertTo(counts, CV_16U, 40.0, 6000.0);
    image = counts;
  });
}

Eigen::Vector2d lon_lat(const sim::Truth& truth, double north_m, double east_m) {
  const Geodetic place = truth.datum.geodetic(truth.world({north_m, east_m}));
  return {place.longitude.degrees(), place.latitude.degrees()};
}

TEST(APolygon, IsNeitherWaterNorIceToThePixel) {
  const auto simulation = story::simulation(story::sea(kSea), {.tilt_deg = 20.0, .seed = 31});
  MappingOptions options = story::usual_options();
  // The eastern half of the sea but for a hole in it.
  const auto point = [&](double n, double e) { return lon_lat(simulation.truth, n, e); };
  options.excluded.push_back({{{point(-500, 5), point(500, 5), point(500, 500), point(-500, 500)},
                               {point(-20, 25), point(-5, 25), point(-5, 40), point(-20, 40)}}});
  const auto run = story::map(simulation.flight, options);
  ASSERT_TRUE(run.ok()) << run.error().message;
  const auto p = [&](double n, double e) { return story::p_ice(*run, simulation.truth, n, e); };
  for (double north = -25; north <= 25; north += 2.5) {
    EXPECT_TRUE(std::isfinite(p(north, 3.0))) << north;
    EXPECT_TRUE(std::isnan(p(north, 7.0))) << north;
    EXPECT_TRUE(std::isnan(p(north, 20.0))) << north;
  }
  EXPECT_TRUE(std::isfinite(p(-12.0, 32.0)));
  EXPECT_TRUE(std::isnan(p(-12.0, 42.5)));
}

TEST(AMaskOfTheCamera, AddsNoEvidence) {
  const auto simulation = story::simulation(story::sea(kSea), {.seed = 32});
  const auto& camera = simulation.flight.camera;
  MappingOptions options = story::usual_options();
  const auto all = story::map(simulation.flight, options);
  options.camera_mask = cv::Mat(camera.height_px(), camera.width_px(), CV_8U, cv::Scalar(255));
  options.camera_mask.rowRange(0, camera.height_px() / 2) = 0;
  const auto half = story::map(simulation.flight, options);
  ASSERT_TRUE(all.ok() && half.ok());
  const auto looks = [](const MapRun& run) { return cv::sum(run.map.looks(run.map.seen()))[0]; };
  EXPECT_NEAR(looks(*half) / looks(*all), 0.5, 0.08);

  options.camera_mask = cv::Mat(10, 10, CV_8U, cv::Scalar(255));
  EXPECT_THAT(story::map(simulation.flight, options).error().message,
              testing::HasSubstr("mask is 10x10"));
}

TEST(AClosedShutter, IsLeftOutAndNoted) {
  const auto simulation = story::simulation(story::sea(kSea), {.seed = 33});
  const Flight counts = in_counts(simulation.flight);
  const Flight flight = changed(counts, [](std::size_t i, cv::Mat& image) {
    if (i % 7 == 3) cv::randn(image, 19000.0, 60.0);
  });
  const auto run = story::map(flight);
  ASSERT_TRUE(run.ok()) << run.error().message;
  std::size_t expected = 0;
  for (std::size_t i = 0; i < flight.frames.size(); ++i) expected += i % 7 == 3;
  EXPECT_EQ(run->left_out.size(), expected);
  for (const LeftOut& l : run->left_out)
    EXPECT_THAT(l.reason, testing::HasSubstr("closed shutter"));
  EXPECT_THAT(run->notes, testing::Contains(testing::HasSubstr("shutter was closed")));
  // And a flight without one has none.
  const auto clean = story::map(counts);
  ASSERT_TRUE(clean.ok()) << clean.error().message;
  EXPECT_THAT(clean->left_out, testing::IsEmpty());
  EXPECT_THAT(clean->sensor_events, testing::IsEmpty());
}

TEST(AJumpOfTheGain, IsNoted) {
  const auto simulation = story::simulation(story::sea(kSea), {.seed = 34});
  const std::size_t at = simulation.flight.frames.size() / 2;
  const Flight flight = changed(in_counts(simulation.flight), [at](std::size_t i, cv::Mat& image) {
    if (i >= at) image += 900.0;
  });
  const auto run = story::map(flight);
  ASSERT_TRUE(run.ok()) << run.error().message;
  ASSERT_EQ(run->sensor_events.size(), 1U);
  const SensorEvent& event = run->sensor_events.front();
  EXPECT_EQ(event.kind, SensorEvent::Kind::GainJump);
  EXPECT_EQ(event.file, flight.frames[at].name);
  EXPECT_NEAR(event.size, 900.0, 90.0);
  EXPECT_TRUE(run->left_out.empty());
}

TEST(APictureThatStandsStill, IsNotedAsAFreeze) {
  const auto simulation = story::simulation(story::sea(kSea), {.seed = 35});
  Flight flight = simulation.flight;
  const std::size_t at = flight.frames.size() / 2;
  flight.frames[at + 1].load = flight.frames[at].load;
  const auto run = story::map(flight);
  ASSERT_TRUE(run.ok()) << run.error().message;
  ASSERT_EQ(run->sensor_events.size(), 1U);
  EXPECT_EQ(run->sensor_events[0].kind, SensorEvent::Kind::Freeze);
  EXPECT_EQ(run->sensor_events[0].file, flight.frames[at].name);
  EXPECT_EQ(run->left_out.size(), 1U);
}

TEST(AFaultyCamera, IsMappedAsAGoodOneIs) {
  const auto simulation = story::simulation(story::sea(kSea), {.seed = 36});
  const Flight good = in_counts(simulation.flight);
  const Flight faulty = changed(good, [](std::size_t, cv::Mat& image) {
    cv::RNG rng(5);
    cv::Mat columns(1, image.cols, CV_32F), pattern(image.size(), CV_32F);
    rng.fill(columns, cv::RNG::NORMAL, 0.0, 300.0);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const double dx = 2.0 * x / image.cols - 1.0, dy = 2.0 * y / image.rows - 1.0;
        pattern.at<float>(y, x) =
            static_cast<float>(columns.at<float>(x) - 2800.0 * (dx * dx + dy * dy) / 2.0);
      }
    cv::add(image, pattern, image, cv::noArray(), image.depth());
  });
  MappingOptions options = story::usual_options();
  const auto reference = story::map(good, options);
  const auto corrected = story::map(faulty, options);
  options.parameters.correct_sensor = false;
  const auto raw = story::map(faulty, options);
  ASSERT_TRUE(reference.ok() && corrected.ok() && raw.ok());
  const auto wrong = [&](const MapRun& run) {
    int count = 0, seen = 0;
    for (double n = -33; n <= 33; n += 1.5)
      for (double e = -48; e <= 48; e += 1.5) {
        const double p = story::p_ice(run, simulation.truth, n, e),
                     q = story::p_ice(*reference, simulation.truth, n, e);
        if (std::isnan(p) || std::isnan(q)) continue;
        ++seen;
        count += (p > 0.5) != (q > 0.5);
      }
    return static_cast<double>(count) / seen;
  };
  EXPECT_LT(wrong(*corrected), 0.2 * wrong(*raw));
  EXPECT_GT(wrong(*raw), 0.002);
  EXPECT_THAT(corrected->notes, testing::Contains(testing::HasSubstr("Fixed-pattern noise")));
  EXPECT_THAT(corrected->notes,
              testing::Contains(testing::HasSubstr("Shading around the picture")));
  RecordProperty("raw", std::to_string(wrong(*raw)));
  RecordProperty("corrected", std::to_string(wrong(*corrected)));
}

}  // namespace
}  // namespace watersky
