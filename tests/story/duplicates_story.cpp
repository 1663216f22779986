// SPDX-License-Identifier: MIT
// What map makes of frames that were recorded twice, and of flights that only look like it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "story.hpp"

namespace watersky {
namespace {

constexpr const char* kFloes = R"(
    ..........
    .####.....
    .#........
    .#....##..
    ..........
    ......#...
    ..........)";
constexpr const char* kIceOnly = R"(
    ##########
    ##########
    ##########
    ##########)";

/// Each frame a second time, 20 ms later, as a recorder that is faster than its camera does.
Flight recorded_twice(const Flight& flight) {
  Flight twice = flight;
  twice.frames.clear();
  for (const ImageFrame& frame : flight.frames) {
    twice.frames.push_back(frame);
    ImageFrame again = frame;
    again.name += " again";
    if (again.captured_at) *again.captured_at += std::chrono::milliseconds(20);
    twice.frames.push_back(again);
  }
  return twice;
}

TEST(AFlightRecordedTwice, IsMappedOnceWhateverTheThreads) {
  const Flight flight = story::survey(story::sea(kFloes), {.seed = 21});
  const Flight twice = recorded_twice(flight);
  const auto once = story::map(flight);
  ASSERT_TRUE(once.ok()) << once.error().message;
  for (const int threads : {1, 3}) {
    MappingOptions options = story::usual_options();
    options.threads = threads;
    const auto run = story::map(twice, options);
    ASSERT_TRUE(run.ok()) << run.error().message;
    EXPECT_EQ(run->used.size(), once->used.size());
    EXPECT_EQ(run->left_out.size(), flight.frames.size());
    for (const LeftOut& left_out : run->left_out) {
      EXPECT_THAT(left_out.file, testing::EndsWith(" again"));
      EXPECT_THAT(left_out.reason, testing::HasSubstr("repeats the pixels of"));
    }
  }
}

TEST(AFlightRecordedTwice, IsMappedTwiceWhenAskedTo) {
  const Flight flight = story::survey(story::sea(kFloes), {.seed = 21});
  MappingOptions options = story::usual_options();
  options.parameters.skip_duplicates = false;
  const auto run = story::map(recorded_twice(flight), options);
  ASSERT_TRUE(run.ok()) << run.error().message;
  EXPECT_TRUE(run->left_out.empty());
  EXPECT_EQ(run->used.size(), 2 * flight.frames.size());
}

TEST(AFlightOverUniformIce, LosesNoFrame) {
  for (const bool ice_darker : {false, true}) {
    const Flight flight = story::survey(story::sea(kIceOnly, {.cell_m = 40.0}),
                                        {.ice_darker = ice_darker, .seed = 22});
    const auto run = story::map(flight);
    ASSERT_TRUE(run.ok()) << run.error().message;
    EXPECT_THAT(run->left_out, testing::IsEmpty());
    EXPECT_GT(run->used.size(), 10U);
  }
}

}  // namespace
}  // namespace watersky
