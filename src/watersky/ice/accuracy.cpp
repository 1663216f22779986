// SPDX-License-Identifier: MIT
#include "watersky/ice/accuracy.hpp"

#include <algorithm>
#include <cmath>

namespace watersky::ice {

RasterAccuracy compare(const cv::Mat& probability, const cv::Mat& truth_share) {
  std::size_t both = 0, either = 0, agree = 0, cells = 0, called = 0, truly = 0;
  for (int r = 0; r < probability.rows; ++r)
    for (int c = 0; c < probability.cols; ++c) {
      const float p = probability.at<float>(r, c), share = truth_share.at<float>(r, c);
      if (std::isnan(p) || std::isnan(share)) continue;
      const bool ice = p > 0.5F, truth = share >= 0.5F;
      ++cells;
      both += ice && truth;
      either += ice || truth;
      agree += ice == truth;
      called += ice;
      truly += truth;
    }
  RasterAccuracy out;
  out.cells = cells;
  if (cells == 0) return out;
  const auto of = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  out.iou = of(both, either);
  out.accuracy = of(agree, cells);
  out.concentration_error = of(called, cells) - of(truly, cells);
  return out;
}

std::vector<ObjectMatch> match_objects(const std::vector<IceObject>& found,
                                       const std::vector<TruthObject>& truth, double cell_m) {
  std::vector<ObjectMatch> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t)
    for (std::size_t f = 0; f < found.size(); ++f) {
      const double distance_m = cell_m * (found[f].centroid - truth[t].centroid).norm();
      if (distance_m <= std::max(truth[t].equivalent_radius_m, cell_m))
        pairs.push_back({t, f, distance_m});
    }
  std::sort(pairs.begin(), pairs.end(), [](const ObjectMatch& a, const ObjectMatch& b) {
    return a.centroid_error_m < b.centroid_error_m;
  });
  std::vector<bool> truth_used(truth.size()), found_used(found.size());
  std::vector<ObjectMatch> matches;
  for (const ObjectMatch& pair : pairs) {
    if (truth_used[pair.truth] || found_used[pair.found]) continue;
    truth_used[pair.truth] = found_used[pair.found] = true;
    matches.push_back(pair);
  }
  return matches;
}

}  // namespace watersky::ice
