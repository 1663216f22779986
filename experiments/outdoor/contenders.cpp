// SPDX-License-Identifier: MIT
#include "preparations.hpp"
#include "study.hpp"

namespace watersky::study {

namespace {

Result<Flight> with_alignment_by_images_alone(const Flight& flight) {
  Flight images_alone = flight;
  images_alone.anchors.clear();
  return with_alignment(images_alone);
}

}  // namespace

std::vector<Contender> contenders(const sim::Truth& truth) {
  return {
      {"tagged", "latest pose", with_latest_pose},
      {"constant_250ms", "250 ms", [](const Flight& f) { return with_constant_delay(f, 0.25); }},
      {"true_times", "true times", [truth](const Flight& f) { return with_true_times(f, truth); }},
      {"true_times_and_mount", "true times and mount",
       [truth](const Flight& f) { return with_true_times_and_mount(f, truth); }},
      {"ours", "ours: from the images", with_alignment_by_images_alone},
      {"ours_live", "ours, live", with_live_alignment},
      {"ours_one_anchor", "ours, one anchor", with_alignment},
  };
}

}  // namespace watersky::study
