// SPDX-License-Identifier: MIT
#include "watersky/ice/objects.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "watersky/base/contract.hpp"
#include "watersky/ice/detail/caliper.hpp"
#include "watersky/ice/detail/gap.hpp"
#include "watersky/ice/detail/outline.hpp"
#include "watersky/ice/size_class.hpp"

namespace watersky::ice {

namespace {

/// Per label, while the rasters are walked.
struct Sums {
  std::size_t cells = 0;
  double column = 0;
  double row = 0;
  double probability = 0;
  double looks = 0;
  double last_seen_s = -std::numeric_limits<double>::infinity();
  bool cut = false;
};

/// Ice as 255 with a border of one cell of no ice around it, so that no neighbour is missing.
cv::Mat padded_ice(const cv::Mat& probability, double threshold) {
  cv::Mat ice(probability.rows + 2, probability.cols + 2, CV_8U, cv::Scalar(0));
  const float limit = static_cast<float>(threshold);
  for (int r = 0; r < probability.rows; ++r) {
    const float* p = probability.ptr<float>(r);
    std::uint8_t* out = ice.ptr<std::uint8_t>(r + 1) + 1;
    for (int c = 0; c < probability.cols; ++c) out[c] = p[c] > limit ? 255 : 0;
  }
  return ice;
}

/// 255 where a cell or one of its eight neighbours was never seen or lies outside.
cv::Mat padded_edge(const cv::Mat& probability) {
  cv::Mat unseen(probability.rows + 2, probability.cols + 2, CV_8U, cv::Scalar(255));
  for (int r = 0; r < probability.rows; ++r) {
    const float* p = probability.ptr<float>(r);
    std::uint8_t* out = unseen.ptr<std::uint8_t>(r + 1) + 1;
    for (int c = 0; c < probability.cols; ++c) out[c] = p[c] == p[c] ? 0 : 255;
  }
  cv::dilate(unseen, unseen, cv::Mat(3, 3, CV_8U, cv::Scalar(1)));
  return unseen;
}

void sum_cells(const Rasters& rasters, const cv::Mat& ice, const cv::Mat& edge,
               const cv::Mat& label, std::vector<Sums>& sums) {
  for (int r = 0; r < rasters.probability.rows; ++r) {
    const float* p = rasters.probability.ptr<float>(r);
    const std::uint8_t* is_ice = ice.ptr<std::uint8_t>(r + 1) + 1;
    const std::uint8_t* at_edge = edge.ptr<std::uint8_t>(r + 1) + 1;
    const int* l = label.ptr<int>(r + 1) + 1;
    const std::uint16_t* looks =
        rasters.looks.empty() ? nullptr : rasters.looks.ptr<std::uint16_t>(r);
    const double* seen = rasters.last_seen_s.empty() ? nullptr : rasters.last_seen_s.ptr<double>(r);
    for (int c = 0; c < rasters.probability.cols; ++c) {
      if (!is_ice[c]) continue;
      Sums& s = sums[static_cast<std::size_t>(l[c])];
      ++s.cells;
      s.column += c;
      s.row += r;
      s.probability += static_cast<double>(p[c]);
      s.cut |= at_edge[c] != 0;
      if (looks) s.looks += looks[c];
      if (seen && seen[c] > s.last_seen_s) s.last_seen_s = seen[c];
    }
  }
}

/// Corners of the padded raster as grid positions: one cell of padding, and half a cell because
/// positions count from the cells' centres.
Ring positions(const std::vector<cv::Point>& corners) {
  Ring ring;
  ring.reserve(corners.size());
  for (const cv::Point& p : corners) ring.emplace_back(p.x - 1.5, p.y - 1.5);
  return ring;
}

bool iceberg_candidate(const IceObject& o, const ObjectParameters& p) {
  return !o.cut_by_edge && o.gap_m >= p.isolation_gap_m && o.length_m >= p.min_iceberg_length_m &&
         o.length_m <= p.max_iceberg_length_m && o.solidity >= p.min_iceberg_solidity &&
         o.width_m >= p.min_iceberg_aspect * o.length_m &&
         o.mean_probability >= p.min_iceberg_probability;
}

/// The outline of one object and what follows from it. `rings` are all lines of the object,
/// those of one 4-connected piece together.
void shape(std::vector<const detail::CornerRing*>& rings, double cell_m, IceObject& object) {
  std::stable_sort(rings.begin(), rings.end(), [](const auto* a, const auto* b) {
    if (a->piece != b->piece) return a->piece < b->piece;
    return a->signed_area_cells > 0 && b->signed_area_cells < 0;
  });
  std::vector<cv::Point> outer_corners;
  double edge_cells = 0;
  for (const detail::CornerRing* ring : rings) {
    edge_cells += ring->edge_cells;
    if (ring->signed_area_cells > 0) {
      object.outline.push_back({positions(ring->corners), {}});
      outer_corners.insert(outer_corners.end(), ring->corners.begin(), ring->corners.end());
    } else {
      object.outline.back().holes.push_back(positions(ring->corners));
    }
  }
  const detail::Caliper caliper = detail::caliper(outer_corners);
  object.length_m = caliper.length * cell_m;
  object.width_m = caliper.width * cell_m;
  object.solidity = static_cast<double>(object.cells) / caliper.hull_area;
  object.perimeter_m = std::numbers::pi / 4 * edge_cells * cell_m;
}

}  // namespace

std::string_view to_string(ObjectKind kind) {
  return kind == ObjectKind::Floe ? "floe" : "iceberg candidate";
}

std::vector<IceObject> find_objects(const Rasters& rasters, double cell_m,
                                    const ObjectParameters& parameters) {
  const cv::Mat& probability = rasters.probability;
  WATERSKY_REQUIRE(probability.empty() || probability.type() == CV_32F);
  WATERSKY_REQUIRE(rasters.looks.empty() || rasters.looks.type() == CV_16U);
  WATERSKY_REQUIRE(rasters.last_seen_s.empty() || rasters.last_seen_s.type() == CV_64F);
  std::vector<IceObject> objects;
  if (probability.empty()) return objects;

  cv::Mat ice = padded_ice(probability, parameters.ice_probability);
  if (cv::countNonZero(ice) == 0) return objects;

  cv::Mat label;
  const int labels = cv::connectedComponents(ice, label, 8, CV_32S);
  std::vector<Sums> sums(static_cast<std::size_t>(labels));
  const std::vector<float> gap_cells = detail::gaps_cells(label, labels);
  sum_cells(rasters, ice, padded_edge(probability), label, sums);

  std::vector<int> object_of_label(sums.size(), -1);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const Sums& s = sums[i];
    if (s.cells == 0 || s.cells < static_cast<std::size_t>(parameters.min_cells)) continue;
    object_of_label[i] = static_cast<int>(objects.size());
    const double n = static_cast<double>(s.cells);
    IceObject& o = objects.emplace_back();
    o.cells = s.cells;
    o.centroid = {s.column / n, s.row / n};
    o.area_m2 = n * cell_m * cell_m;
    o.equivalent_diameter_m = 2 * std::sqrt(o.area_m2 / std::numbers::pi);
    o.cut_by_edge = s.cut;
    o.gap_m = static_cast<double>(gap_cells[i]) * cell_m;
    o.mean_probability = s.probability / n;
    o.mean_looks = s.looks / n;
    o.last_seen_s =
        std::isfinite(s.last_seen_s) ? s.last_seen_s : std::numeric_limits<double>::quiet_NaN();
  }

  cv::Mat piece;
  cv::connectedComponents(ice, piece, 4, CV_32S);
  const std::vector<detail::CornerRing> rings = detail::trace_outlines(ice, piece);
  std::vector<std::vector<const detail::CornerRing*>> rings_of(objects.size());
  for (const detail::CornerRing& ring : rings) {
    // Walking with ice on the left, the cell there belongs to the ring's object.
    const cv::Point a = ring.corners[0];
    const cv::Point b = ring.corners[1];
    const cv::Point cell(std::min(a.x, b.x) - (b.y < a.y ? 1 : 0),
                         std::min(a.y, b.y) - (b.x > a.x ? 1 : 0));
    const int object = object_of_label[static_cast<std::size_t>(label.at<int>(cell))];
    if (object >= 0) rings_of[static_cast<std::size_t>(object)].push_back(&ring);
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    shape(rings_of[i], cell_m, objects[i]);
    IceObject& o = objects[i];
    o.kind = iceberg_candidate(o, parameters) ? ObjectKind::IcebergCandidate : ObjectKind::Floe;
    o.size_class =
        o.kind == ObjectKind::Floe ? floe_size_class(o.length_m) : iceberg_size_class(o.length_m);
  }
  std::stable_sort(objects.begin(), objects.end(),
                   [](const IceObject& a, const IceObject& b) { return a.cells > b.cells; });
  for (std::size_t i = 0; i < objects.size(); ++i) objects[i].id = static_cast<int>(i) + 1;
  return objects;
}

}  // namespace watersky::ice
