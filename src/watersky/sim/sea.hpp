// SPDX-License-Identifier: MIT
#pragma once
/// A virtual sea: where there is ice, exactly.
///
/// The scene is a rectangle around its anchor, a point of the sea surface. Positions are (north,
/// east) metres in the anchor's tangent frame; the surface itself curves away below that frame as
/// the ellipsoid does, so a scene is where it claims to be wherever the mission's datum is. The
/// surface is a paraboloid: within 5 mm of one of constant ellipsoidal height 5 km from the
/// anchor. The ice is flat: no freeboard, no shadows.
#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/geodesy/wgs84.hpp"
#include "watersky/sim/outline.hpp"

namespace watersky::sim {

/// One connected piece of ice.
struct IceObject {
  int id = 0;                                                     ///< its index in Sea::objects()
  Eigen::Vector2d centre_north_east_m = Eigen::Vector2d::Zero();  ///< centroid of its area
  double area_m2 = 0.0;
  double equivalent_radius_m = 0.0;  ///< of the disc of equal area
  double max_length_m = 0.0;         ///< largest caliper
  bool isolated = false;             ///< open water of at least the scene's isolation gap around it
};

/// A long crack through the ice.
struct Lead {
  std::vector<Eigen::Vector2d> centreline_north_east_m;
  double width_m = 0.0;
};

class SeaIndex;

/// Immutable; copies share their geometry.
class Sea {
 public:
  struct Extent {
    double north_m = 0.0;
    double east_m = 0.0;
  };

  /// From outlines that do not overlap, one an object, within the rectangle of `extent` around
  /// (0, 0). `isolated` says which are; empty: none. InvalidInput for an outline of fewer than
  /// three corners, without area, or outside the extent.
  [[nodiscard]] static Result<Sea> from_outlines(std::vector<Outline> outlines,
                                                 const std::vector<bool>& isolated, Extent extent,
                                                 std::vector<Lead> leads = {});

  /// From a drawing in which each character is a square of `cell_m`: '#' ice, '.' water. The
  /// first line is the northernmost. Blanks at the ends of lines and empty lines are skipped.
  /// Squares that share a side or a corner are one object.
  [[nodiscard]] static Result<Sea> from_ascii(std::string_view drawing, double cell_m,
                                              double isolation_gap_m = 0.0);

  /// From a mask (CV_8U, not 0: ice) and, unless empty, the picture it belongs to (8 or 16 bit or
  /// float, one channel, same size), which then is what the camera sees: scaled so that its
  /// mean is 0 over water and 1 over ice. Row 0 is the northernmost, column 0 the westernmost.
  [[nodiscard]] static Result<Sea> from_raster(const cv::Mat& ice, const cv::Mat& picture,
                                               double cell_m, double isolation_gap_m = 0.0);

  /// The same sea at another place; a new sea is at latitude 0, longitude 0, height 0.
  [[nodiscard]] Sea at(const Geodetic& anchor) const;
  [[nodiscard]] const Geodetic& anchor() const { return anchor_; }
  [[nodiscard]] const Extent& extent() const;

  /// The object at a point, or -1 for water. Exact for outlines; a raster's ice is the union of
  /// its squares.
  [[nodiscard]] int object_at(double north_m, double east_m) const;
  [[nodiscard]] bool is_ice(double north_m, double east_m) const {
    return object_at(north_m, east_m) >= 0;
  }

  [[nodiscard]] const std::vector<IceObject>& objects() const;
  /// Non-overlapping outlines whose union is the ice, and the object each belongs to. One an
  /// object, except for rasters.
  [[nodiscard]] const std::vector<Outline>& pieces() const;
  [[nodiscard]] const std::vector<int>& owners() const;
  [[nodiscard]] const std::vector<Lead>& leads() const;
  /// Ice area over the area of the extent.
  [[nodiscard]] double concentration() const;

  /// Whether the sea brought its own picture.
  [[nodiscard]] bool has_picture() const;
  /// The picture, bilinear: 0 as water on average, 1 as ice; at the border its nearest pixel.
  [[nodiscard]] float picture_at(double north_m, double east_m) const;

  /// A point of the sea surface.
  [[nodiscard]] Geodetic geodetic(const Eigen::Vector2d& north_east_m) const;

 private:
  friend class Renderer;
  struct Geometry;
  explicit Sea(std::shared_ptr<const Geometry> geometry) : geometry_(std::move(geometry)) {}
  [[nodiscard]] const SeaIndex* index() const;

  std::shared_ptr<const Geometry> geometry_;
  Geodetic anchor_;
};

/// The exact share of ice in each cell of a grid (CV_32F). `grid` takes a position of the scene to
/// (column, row), cell (0, 0) being [0, 1) x [0, 1); it need not be affine, but edges of outlines
/// are taken as straight after it. Rows may run either way.
template <class Grid>
[[nodiscard]] cv::Mat ice_fraction(const Sea& sea, cv::Size cells, Grid&& grid);

/// Adds outlines given in (column, row) up to exact area shares.
class AreaCoverage {
 public:
  explicit AreaCoverage(cv::Size cells);
  void add(const Outline& column_row);
  /// CV_32F in [0, 1].
  [[nodiscard]] cv::Mat share() const;

 private:
  void add_edge(Eigen::Vector2d a, Eigen::Vector2d b, double sign);
  cv::Mat change_;  ///< CV_64F; the share is its running sum along a row
};

template <class Grid>
cv::Mat ice_fraction(const Sea& sea, cv::Size cells, Grid&& grid) {
  AreaCoverage coverage(cells);
  Outline moved;
  for (const Outline& piece : sea.pieces()) {
    moved.clear();
    for (const Eigen::Vector2d& corner : piece) moved.push_back(grid(corner));
    coverage.add(moved);
  }
  return coverage.share();
}

}  // namespace watersky::sim
