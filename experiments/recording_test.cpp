// SPDX-License-Identifier: MIT
#include "recording.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace watersky::study {
namespace {

sim::Scenario three_frames() {
  sim::Scenario s = sim::scenario_preset("visible").value();
  s.sea.concentration = 0.0;
  s.sea.isolated_count = 5;
  s.sea.lead_count = 0;
  s.aircraft.legs = 1;
  s.aircraft.leg_length_m = 50.0;
  s.lens.width_px = 101;  // of no whole blocks
  s.lens.height_px = 67;
  s.lens.focal_px = 90.0;
  return s;
}

TEST(Recording, KeepsTheImagesThatTheSimulatorMakes) {
  const sim::Simulation kept = record(three_frames()).value();
  const sim::Simulation made = sim::simulate(three_frames()).value();
  ASSERT_TRUE(render(kept.flight));
  ASSERT_GE(kept.flight.frames.size(), 2u);
  for (const ImageRequest& request :
       {ImageRequest{}, ImageRequest{.color = false}, ImageRequest{.color = true, .reduction = 4},
        ImageRequest{.color = false, .reduction = 2}})
    for (std::size_t i = 0; i < kept.flight.frames.size(); ++i) {
      const cv::Mat a = kept.flight.frames[i].load(request).value();
      const cv::Mat b = made.flight.frames[i].load(request).value();
      ASSERT_EQ(a.size(), b.size());
      ASSERT_EQ(a.type(), b.type());
      EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
    }
}

TEST(Recording, WhoeverDrawsIntoAnImageSpoilsItForNobody) {
  const sim::Simulation kept = record(three_frames()).value();
  const ImageLoader& load = kept.flight.frames[0].load;
  const cv::Mat before = load({}).value();
  load({}).value().setTo(cv::Scalar::all(0));
  EXPECT_EQ(cv::norm(load({}).value(), before, cv::NORM_INF), 0.0);
}

TEST(Recording, EveryThirdFrameStartsWithTheFirst) {
  const sim::Simulation kept = record(three_frames()).value();
  const auto frames = every(kept.flight, 2);
  ASSERT_EQ(frames.size(), (kept.flight.frames.size() + 1) / 2);
  EXPECT_EQ(frames[0], &kept.flight.frames[0]);
}

}  // namespace
}  // namespace watersky::study
