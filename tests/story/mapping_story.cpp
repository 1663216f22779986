// SPDX-License-Identifier: MIT
// One character is a square of ice '#' or water '.'; north is up.
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>

#include "story.hpp"

namespace watersky {
namespace {

// Neither square nor symmetric: a mirror image or a transpose anywhere on the way fails.
constexpr const char* kHook = R"(
    ..........
    .####.....
    .#........
    .#....##..
    ..........
    ......#...
    ..........)";
constexpr double kCell_m = 10.0;
constexpr int kRows = 7, kColumns = 10;

/// What the map says of the middle of each square, drawn as the sea was. '?' where it did not see,
/// or where its five points in the square do not agree.
std::string drawn(const MapRun& run, const sim::Truth& truth) {
  std::string picture;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double north = (0.5 * kRows - r - 0.5) * kCell_m,
                   east = (c + 0.5 - 0.5 * kColumns) * kCell_m;
      int ice = 0, water = 0;
      for (const auto& [dn, de] :
           {std::pair{0.0, 0.0}, {3.5, 3.5}, {3.5, -3.5}, {-3.5, 3.5}, {-3.5, -3.5}}) {
        const double p = story::p_ice(run, truth, north + dn, east + de);
        ice += p > 0.7;
        water += p < 0.3;
      }
      picture += ice == 5 ? '#' : water == 5 ? '.' : '?';
    }
    picture += '\n';
  }
  return picture;
}

std::string expected() {
  std::string picture;
  for (const char* c = kHook; *c; ++c)
    if (*c == '#' || *c == '.' || (*c == '\n' && !picture.empty())) picture += *c;
  return picture + '\n';
}

struct Told {
  std::string name;
  story::Survey survey;
};

void PrintTo(const Told& told, std::ostream* out) { *out << told.name; }

class AMappedSea : public ::testing::TestWithParam<Told> {};

TEST_P(AMappedSea, LooksAsItWasDrawn) {
  const auto simulation =
      story::simulation(story::sea(kHook, {.cell_m = kCell_m}), GetParam().survey);
  const auto run = story::map(simulation.flight);
  ASSERT_TRUE(run.ok()) << run.error().message;
  EXPECT_TRUE(run->left_out.empty());
  EXPECT_EQ(drawn(*run, simulation.truth), expected());
}

INSTANTIATE_TEST_SUITE_P(
    Story, AMappedSea,
    ::testing::Values(Told{"FromAbove", {}},
                      Told{"FromAboveOnAnotherCourse", {.azimuth_deg = 127.0, .seed = 2}},
                      Told{"Obliquely", {.tilt_deg = 30.0, .seed = 3}},
                      Told{"FortyKilometresFromTheDatum",
                           {.scene_north_m = -24000.0, .scene_east_m = 32000.0, .seed = 4}},
                      Told{"WithIceColderThanWater",
                           {.tilt_deg = 15.0, .ice_darker = true, .seed = 5}}),
    [](const auto& told) { return told.param.name; });

TEST(AMappedFloe, KeepsItsAreaAndPlace) {
  const auto sea = story::sea(R"(
      ........
      ..###...
      ..###...
      ........)",
                              {.cell_m = 10.0});
  const auto simulation = story::simulation(sea, {.height_m = 80.0, .seed = 1});
  const auto run = story::map(simulation.flight);
  ASSERT_TRUE(run.ok()) << run.error().message;

  double area_m2 = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  constexpr double kStep_m = 0.5;
  for (double north = -19.75; north < 20.0; north += kStep_m)
    for (double east = -39.75; east < 40.0; east += kStep_m)
      if (story::p_ice(*run, simulation.truth, north, east) > 0.5) {
        area_m2 += kStep_m * kStep_m;
        moment += kStep_m * kStep_m * Eigen::Vector2d(north, east);
      }
  EXPECT_NEAR(area_m2, 600.0, 30.0);  // 6 squares of 100 m², 5 %
  EXPECT_NEAR(moment.x() / area_m2, 0.0, 0.25);
  EXPECT_NEAR(moment.y() / area_m2, -5.0, 0.25);
}

TEST(AFlightWithoutASeaLevel, IsNotMapped) {
  Flight flight = story::survey(story::sea("#.\n.."));
  flight.sea_level.reset();
  const auto run = story::map(flight);
  ASSERT_FALSE(run.ok());
  EXPECT_EQ(run.error().code, ErrorCode::NotFound);
}

TEST(AFrameOutsideTheLog, IsLeftOutWithItsReasonAndTheRestMapped) {
  Flight flight = story::survey(story::sea("#...\n...."));
  flight.frames[1].captured_at = *flight.frames.back().captured_at + std::chrono::hours(1);
  const auto run = story::map(flight);
  ASSERT_TRUE(run.ok()) << run.error().message;
  ASSERT_EQ(run->left_out.size(), 1u);
  EXPECT_EQ(run->left_out[0].file, flight.frames[1].name);
  EXPECT_EQ(run->used.size() + 1, run->frames_total);
}

}  // namespace
}  // namespace watersky
