// SPDX-License-Identifier: MIT
#pragma once
/// Areas of the world as a frame sees them.
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/geodesy/geo_polygon.hpp"
#include "watersky/map/grid_view.hpp"
#include "watersky/mapping/mapping.hpp"

namespace watersky::detail {

/// Polygons in grid positions, made once a flight.
class ExcludedAreas {
 public:
  /// Degenerate when a polygon has no place in the map's projection.
  [[nodiscard]] static Result<ExcludedAreas> make(const std::vector<GeoPolygon>& polygons,
                                                  const MapReference& reference);

  /// CV_8U of the size of `camera`'s image, 0 where a pixel sees one of the areas; empty when the
  /// frame sees none of them. `camera` is the view's, or that scaled.
  [[nodiscard]] cv::Mat valid(const SeaView& view, const GridView& grid,
                              const CameraModel& camera) const;

 private:
  struct Area {
    std::vector<std::vector<Eigen::Vector2d>> rings;
    Eigen::Vector2d least, most;
  };
  std::vector<Area> areas_;
};

}  // namespace watersky::detail
