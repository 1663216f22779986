// SPDX-License-Identifier: MIT
#include "watersky/ice/floe_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace watersky::ice {

FloeStatistics floe_statistics(const std::vector<IceObject>& objects) {
  FloeStatistics s;
  const auto bin_of = [](const IceObject& o) {
    return static_cast<int>(std::floor(2 * std::log2(o.equivalent_diameter_m)));
  };
  int first = 0;
  int last = -1;
  for (const IceObject& o : objects) {
    if (o.cut_by_edge) {
      ++s.cut_by_edge;
      continue;
    }
    const int bin = bin_of(o);
    first = s.count == 0 ? bin : std::min(first, bin);
    last = s.count == 0 ? bin : std::max(last, bin);
    ++s.count;
    s.area_m2 += o.area_m2;
    s.mean_diameter_m += o.equivalent_diameter_m;
    s.area_weighted_mean_diameter_m += o.equivalent_diameter_m * o.area_m2;
    s.mean_length_m += o.length_m;
    s.area_weighted_mean_length_m += o.length_m * o.area_m2;
    s.largest_length_m = std::max(s.largest_length_m, o.length_m);
  }
  const double n = static_cast<double>(s.count);
  s.mean_diameter_m /= n;
  s.mean_length_m /= n;
  s.area_weighted_mean_diameter_m /= s.area_m2;
  s.area_weighted_mean_length_m /= s.area_m2;
  for (int bin = first; bin <= last; ++bin)
    s.bins.push_back({std::exp2(bin / 2.0), std::exp2((bin + 1) / 2.0), 0, 0.0});
  for (const IceObject& o : objects) {
    if (o.cut_by_edge) continue;
    SizeBin& bin = s.bins[static_cast<std::size_t>(bin_of(o) - first)];
    ++bin.count;
    bin.area_m2 += o.area_m2;
  }
  return s;
}

}  // namespace watersky::ice
