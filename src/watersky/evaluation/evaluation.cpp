// SPDX-License-Identifier: MIT
#include "watersky/evaluation/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace watersky {

namespace {

/// Whether every cell within `radius_m` of a grid position (relative to the raster) was seen.
bool seen_around(const cv::Mat& probability, const Eigen::Vector2d& p, double radius_cells) {
  const int c0 = static_cast<int>(std::floor(p.x() - radius_cells)),
            c1 = static_cast<int>(std::ceil(p.x() + radius_cells));
  const int r0 = static_cast<int>(std::floor(p.y() - radius_cells)),
            r1 = static_cast<int>(std::ceil(p.y() + radius_cells));
  if (c0 < 0 || r0 < 0 || c1 >= probability.cols || r1 >= probability.rows) return false;
  for (int r = r0; r <= r1; ++r)
    for (int c = c0; c <= c1; ++c)
      if (std::isnan(probability.at<float>(r, c))) return false;
  return true;
}

constexpr double kNearEdge_m = 3.0;

/// CV_8U, not 0 within `reach_cells` of where mostly ice meets mostly water.
cv::Mat near_edges(const cv::Mat& share, double reach_cells) {
  cv::Mat ice, edges;
  cv::compare(share, 0.5, ice, cv::CMP_GT);
  cv::morphologyEx(ice, edges, cv::MORPH_GRADIENT, cv::Mat::ones(3, 3, CV_8U));
  cv::Mat distance, away;
  cv::bitwise_not(edges, away);
  cv::distanceTransform(away, distance, cv::DIST_L2, cv::DIST_MASK_5);
  cv::Mat near;
  cv::compare(distance, reach_cells, near, cv::CMP_LE);
  return near;
}

}  // namespace

Calibration calibration(const cv::Mat& probability, const cv::Mat& ice_share, double cell_m) {
  Calibration out;
  const cv::Mat near = near_edges(ice_share, kNearEdge_m / cell_m);
  for (int r = 0; r < ice_share.rows; ++r)
    for (int c = 0; c < ice_share.cols; ++c) {
      const float p = probability.at<float>(r, c);
      if (std::isnan(p)) continue;
      const bool is_ice = ice_share.at<float>(r, c) > 0.5F;
      out.all.add(p, is_ice);
      if (near.at<uchar>(r, c) != 0) out.near_edges.add(p, is_ice);
    }
  return out;
}

double Evaluation::centroid_error_m(double share) const {
  if (centroid_errors_m.empty()) return 0.0;
  const auto last = static_cast<double>(centroid_errors_m.size() - 1);
  return centroid_errors_m[static_cast<std::size_t>(std::ceil(share * last))];
}

Result<Evaluation> evaluate(const MapRun& run, const sim::Truth& truth, double min_length_m) {
  const CellBox box = run.map.seen();
  const cv::Mat probability = run.map.probability(box);
  const double cell_m = run.map.cell_m();
  const Eigen::Vector2d corner(box.first_column, box.first_row);

  // The scene's positions through the ellipsoid and PROJ: none of the mapping's own geometry.
  Status projected;
  const auto grid = [&](const Eigen::Vector2d& north_east_m) -> Eigen::Vector2d {
    const Geodetic place = truth.sea.geodetic(north_east_m);
    const auto en = run.reference.projection.forward(place.latitude, place.longitude);
    if (!en) {
      projected = en.error();
      return Eigen::Vector2d::Zero();
    }
    return run.reference.grid(*en) - corner;
  };

  Evaluation out;
  cv::Mat share = sim::ice_fraction(
      truth.sea, probability.size(), [&](const Eigen::Vector2d& ne) -> Eigen::Vector2d {
        return grid(ne).array() + 0.5;  // ice_fraction counts from a cell's corner
      });
  WATERSKY_CHECK(projected);
  out.raster = ice::compare(probability, share);

  out.evidence = calibration(probability, share, cell_m);
  out.located = calibration(located_probability(run, box), share, cell_m);

  std::vector<ice::TruthObject> all, counted;
  for (const sim::IceObject& object : truth.sea.objects()) {
    const Eigen::Vector2d centre = grid(object.centre_north_east_m);
    const ice::TruthObject entry{centre, object.equivalent_radius_m};
    all.push_back(entry);
    const double reach_cells = 0.5 * object.max_length_m / cell_m + 2;
    if (object.isolated && object.max_length_m >= min_length_m &&
        seen_around(probability, centre, reach_cells))
      counted.push_back(entry);
  }
  const std::vector<ice::IceObject> found =
      ice::find_objects({.probability = probability, .looks = {}, .last_seen_s = {}}, cell_m);
  out.true_objects = counted.size();
  for (const ice::ObjectMatch& match : ice::match_objects(found, counted, cell_m)) {
    ++out.matched_objects;
    out.centroid_errors_m.push_back(match.centroid_error_m);
  }
  std::sort(out.centroid_errors_m.begin(), out.centroid_errors_m.end());

  std::vector<bool> explained(found.size());
  for (const ice::ObjectMatch& match : ice::match_objects(found, all, cell_m))
    explained[match.found] = true;
  for (std::size_t i = 0; i < found.size(); ++i)
    out.false_objects += !explained[i] && !found[i].cut_by_edge &&
                         found[i].length_m >= min_length_m && found[i].gap_m > 2 * cell_m;
  return out;
}

}  // namespace watersky
