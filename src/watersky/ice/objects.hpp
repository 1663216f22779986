// SPDX-License-Identifier: MIT
#pragma once
/// Floes and iceberg candidates: the connected pieces of ice in a probability raster.
///
/// From above and without the height or the temperature of a piece, an iceberg cannot be told
/// from a floe. What is called an iceberg candidate here is a piece that would be dangerous if
/// it were one: alone in the water, compact, seen whole, of an iceberg's length, and surely ice.
/// In loose pack ice small round floes fulfil this too.
#include <Eigen/Core>
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string_view>
#include <vector>

#include "watersky/base/parameters.hpp"

namespace watersky::ice {

struct ObjectParameters {
  double ice_probability = 0.5;
  int min_cells = 4;
  double isolation_gap_m = 3.0;
  double min_iceberg_length_m = 1.0;
  double max_iceberg_length_m = 500.0;
  double min_iceberg_solidity = 0.8;
  double min_iceberg_aspect = 0.4;
  double min_iceberg_probability = 0.7;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.ice_probability,
          ParameterInfo{"ice_probability", "1", "cells with P(ice) above this are ice", 0.0, 1.0});
    visit(self.min_cells,
          ParameterInfo{"min_cells", "1",
                        "pieces of fewer cells count in the concentration but are not listed", 1,
                        1000000});
    visit(self.isolation_gap_m,
          ParameterInfo{"isolation_gap_m", "m",
                        "a piece with this much water around it is isolated", 0.0, 1e6});
    visit(self.min_iceberg_length_m,
          ParameterInfo{"min_iceberg_length_m", "m", "shortest iceberg candidate", 0.0, 1e6});
    visit(self.max_iceberg_length_m,
          ParameterInfo{"max_iceberg_length_m", "m", "longest iceberg candidate", 0.0, 1e6});
    visit(self.min_iceberg_solidity,
          ParameterInfo{
              "min_iceberg_solidity", "1",
              "area over the area of the convex hull that an iceberg candidate has at least", 0.0,
              1.0});
    visit(self.min_iceberg_aspect,
          ParameterInfo{"min_iceberg_aspect", "1",
                        "width over length that an iceberg candidate has at least", 0.0, 1.0});
    visit(self.min_iceberg_probability,
          ParameterInfo{"min_iceberg_probability", "1",
                        "mean P(ice) that an iceberg candidate has at least", 0.0, 1.0});
  }
};

/// A closed line in continuous grid positions (the centre of cell (c, r) is (c, r), its corners
/// lie half a cell around it), the first point not repeated.
using Ring = std::vector<Eigen::Vector2d>;

/// Along the cells' edges, exactly. Seen from above with north up, `outer` runs
/// counter-clockwise and the holes clockwise. Rings are simple; they touch each other in points
/// only (valid as OGC simple features).
struct Polygon {
  Ring outer;
  std::vector<Ring> holes;
};

enum class ObjectKind { Floe, IcebergCandidate };
[[nodiscard]] std::string_view to_string(ObjectKind kind);  ///< "floe", "iceberg candidate"

struct IceObject {
  int id = 0;  ///< from 1, the largest area first
  ObjectKind kind = ObjectKind::Floe;
  /// More than one where parts hang together by the corners of cells only.
  std::vector<Polygon> outline;
  std::size_t cells = 0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< grid position
  double area_m2 = 0.0;
  /// The largest distance across, and the smallest between two parallel lines that hold the
  /// piece: of the cells' squares, so up to a cell more than of what they show.
  double length_m = 0.0;
  double width_m = 0.0;
  double equivalent_diameter_m = 0.0;  ///< of the circle with the same area
  /// π/4 times the length of the outline's cell edges, holes included: by Crofton's formula
  /// unbiased over all directions, where the edges themselves are 27 % too long.
  double perimeter_m = 0.0;
  double solidity = 0.0;  ///< area over the area of the convex hull
  /// Touches cells never seen, or the raster's border: it may go on there.
  bool cut_by_edge = false;
  /// Water between this piece and the nearest other ice that was seen (pieces too small to be
  /// listed count); infinite when there is none. Within 5 % or one cell.
  double gap_m = 0.0;
  double mean_probability = 0.0;
  double mean_looks = 0.0;   ///< 0 when not known
  double last_seen_s = 0.0;  ///< latest of its cells, seconds UTC; NaN when not known
  /// WMO's words: of icebergs for a candidate, otherwise of floes.
  std::string_view size_class;
};

/// What a map knows, as rasters of one size.
struct Rasters {
  cv::Mat probability;  ///< CV_32F, NaN where never seen
  cv::Mat looks;        ///< CV_16U; may be empty
  cv::Mat last_seen_s;  ///< CV_64F, NaN where never seen; may be empty
};

/// The pieces of ice: cells above the threshold that touch by edge or corner, the largest first.
/// 4000 x 4000 cells with thousands of pieces take about 0.4 s (bench/ice_objects).
[[nodiscard]] std::vector<IceObject> find_objects(const Rasters& rasters, double cell_m,
                                                  const ObjectParameters& parameters = {});

}  // namespace watersky::ice
