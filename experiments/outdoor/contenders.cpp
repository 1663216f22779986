// SPDX-License-Identifier: MIT
#include "preparations.hpp"
#include "study.hpp"

namespace watersky::study {

std::vector<Contender> contenders(const sim::Truth& truth) {
  return {
      {"tagged", "latest pose", with_latest_pose},
      {"constant_250ms", "250 ms", [](const Flight& f) { return with_constant_delay(f, 0.25); }},
      {"true_times", "true times", [truth](const Flight& f) { return with_true_times(f, truth); }},
      {"true_times_and_mount", "true times and mount",
       [truth](const Flight& f) { return with_true_times_and_mount(f, truth); }},
      {"ours", "ours: from the images", with_alignment},
  };
}

}  // namespace watersky::study
