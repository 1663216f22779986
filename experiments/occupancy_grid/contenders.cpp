// SPDX-License-Identifier: MIT
#include <string_view>

#include "preparations.hpp"
#include "study.hpp"

namespace watersky::study {

std::vector<Contender> contenders(const sim::Truth& truth) {
  const auto constant = [](const Flight& f) { return with_constant_delay(f, 0.25); };
  const auto times = [truth](const Flight& f) { return with_true_times(f, truth); };
  const auto all = [truth](const Flight& f) { return with_true_times_and_mount(f, truth); };
  return {
      {"algorithm1", "Algorithm 1, latest pose", Mapper::Algorithm1, with_latest_pose},
      {"algorithm1_250ms", "Algorithm 1, 250 ms", Mapper::Algorithm1, constant},
      {"algorithm1_oracle", "Algorithm 1, true times and mount", Mapper::Algorithm1, all},
      {"tagged", "our map, latest pose", Mapper::IceMap, with_latest_pose},
      {"constant_250ms", "our map, 250 ms", Mapper::IceMap, constant},
      {"true_times", "our map, true times", Mapper::IceMap, times},
      {"ours", "ours: our map, aligned by the images", Mapper::IceMap, with_alignment},
      {"oracle", "our map, true times and mount", Mapper::IceMap, all},
  };
}

const Contender& drawn(const std::vector<Contender>& contenders) {
  for (const std::string_view name : {"ours", "oracle"})
    for (const Contender& contender : contenders)
      if (contender.name == name) return contender;
  return contenders.back();
}

}  // namespace watersky::study
