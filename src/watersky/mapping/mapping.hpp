// SPDX-License-Identifier: MIT
#pragma once
/// The main job: a flight in, a map of its ice and an account of every frame out.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/geodesy/geo_polygon.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/map/ice_map.hpp"
#include "watersky/map/mosaic.hpp"
#include "watersky/map/position_uncertainty.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky {

/// How the Map frame lies in a projection: cell (0, 0)'s north-west corner is at the anchor,
/// columns run east, rows south.
struct MapReference {
  Projection projection;
  double anchor_easting_m = 0.0;  ///< whole multiples of the cell
  double anchor_northing_m = 0.0;
  double cell_m = 0.5;

  /// Easting and northing of a continuous grid position (cell centres at whole numbers).
  [[nodiscard]] Eigen::Vector2d easting_northing_m(double column, double row) const;
  /// The inverse of easting_northing_m.
  [[nodiscard]] Eigen::Vector2d grid(const Eigen::Vector2d& easting_northing_m) const;
  /// GDAL's geotransform for a raster of `box`.
  [[nodiscard]] std::array<double, 6> geotransform(const CellBox& box) const;
  /// (c, r, 1) to (north, east, 1) in the tangent plane of the sea at `on_sea`, with the
  /// projection's convergence and scale there.
  [[nodiscard]] Result<Eigen::Matrix3d> sea_from_grid(const Geodetic& on_sea) const;
};

struct MappingParameters {
  MapParameters map;
  SegmentationParameters segmentation;
  double sigma_m = 0.0;
  double min_grazing_deg = 10.0;
  double max_pose_gap_s = 0.5;
  bool soften_by_pose = true;
  bool mosaic = true;
  bool skip_duplicates = true;
  bool correct_sensor = true;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    MapParameters::describe(self.map, visit);
    SegmentationParameters::describe(self.segmentation, visit);
    visit(self.sigma_m,
          ParameterInfo{"sigma_m", "m",
                        "Gaussian softening on the sea for where the pose may be wrong", 0, 1000});
    visit(self.soften_by_pose,
          ParameterInfo{"soften_by_pose", "1",
                        "soften the probabilities by how uncertain the poses leave the place"});
    visit(self.min_grazing_deg, ParameterInfo{"min_grazing_deg", "deg",
                                              "sea seen at a flatter angle is not used", 1, 89});
    visit(self.max_pose_gap_s,
          ParameterInfo{"max_pose_gap_s", "s", "longest gap between poses that is interpolated", 0,
                        3600});
    visit(self.mosaic,
          ParameterInfo{"mosaic", "1", "lay the pictures themselves onto the sea as well"});
    visit(self.skip_duplicates,
          ParameterInfo{"skip_duplicates", "1",
                        "leave out frames that repeat the pixels of the one before"});
    visit(self.correct_sensor,
          ParameterInfo{"correct_sensor", "1",
                        "take out defective pixels, fixed-pattern noise and vignetting as the "
                        "flight shows them, and leave out frames of a closed shutter"});
  }
};

struct MappingOptions {
  MappingParameters parameters;
  SegmentationMethod method = kDefaultSegmentationMethod;
  IcePolarity ice = IcePolarity::Auto;
  std::optional<std::string> projection;  ///< nullopt: chosen from the flight
  int threads = 1;
  /// 0 where the camera's pictures are not to be used, in its full size; empty: all are.
  cv::Mat camera_mask{};
  std::vector<GeoPolygon> excluded{};  ///< land, a ship: neither water nor ice
};

/// One frame that went into the map. An hour has a hundred thousand of them: no more than is told
/// of each.
struct UsedFrame {
  std::string file;
  Time time;
  Geodetic camera;
  Eigen::Vector3d optical_axis = Eigen::Vector3d::UnitZ();      ///< Sea: north, east, down
  std::vector<Eigen::Vector2d> footprint_easting_northing_m{};  ///< closed, last point not repeated
  double gsd_m = 0.0;
  double height_above_sea_m = 0.0;
  double ice_fraction = 0.0;  ///< of the pixels that were known, before the map
  bool cut_by_grazing_limit = false;
};

/// What a camera did during a flight besides taking pictures.
struct SensorEvent {
  enum class Kind {
    Freeze,   ///< the same picture again for a while; size: seconds
    Shutter,  ///< a picture of the closed shutter (flat-field correction); size: levels off
    GainJump  ///< the same sea in other levels than in the frame before; size: levels
  };
  std::string file;
  Time time;
  Kind kind = Kind::Freeze;
  double size = 0.0;
};

/// What came of a flight.
struct MapRun {
  std::string flight_name;
  MapReference reference;
  IceMap map;
  Mosaic mosaic{};
  PositionUncertainty uncertainty{};  ///< of where the map's evidence lies
  std::vector<UsedFrame> used{};
  std::vector<LeftOut> left_out{};
  std::vector<SensorEvent> sensor_events{};
  std::size_t frames_total = 0;
  std::vector<std::string> notes{};  ///< what was assumed, chosen or noticed, one sentence each
  MappingOptions options;
  IcePolarity ice = IcePolarity::Brighter;  ///< given, or found; Auto: the method needs none
  std::string calibration;                  ///< where the intrinsics come from
  std::string mount;                        ///< how the camera sits
  std::string sea_level;                    ///< how the sea level was given
  Datum datum;
  bool times_are_utc = true;
  double wall_s = 0.0;
  /// Which flight this is, the same however often it is mapped (source_id_of): its evidence counts
  /// once where maps are merged. Empty: not said.
  std::string source_id{};
};

/// P(ice) of a run's cells (CV_32F, NaN unseen), softened by where they may be.
[[nodiscard]] cv::Mat located_probability(const MapRun& run, const CellBox& box);

/// Maps a flight. A frame that cannot be used is left out with its reason; OutOfRange when that
/// leaves none, with the commonest reason in the message. Fails with NotFound when the flight
/// has no sea level.
[[nodiscard]] Result<MapRun> map_flight(const Flight& flight, const MappingOptions& options,
                                        const Progress& progress = {});

}  // namespace watersky
