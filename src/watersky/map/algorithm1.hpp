// SPDX-License-Identifier: MIT
#pragma once
/// Algorithm 1 of the thesis to the letter, on plain OpenCV: the oracle in tests and the
/// yardstick in benchmarks. Every frame warps the whole canvas; IceMap is what to use in flight.
/// The operations are those of the thesis's module (A.2.3), with the slips of its printed
/// formulas and code mended (docs/decisions/0007).
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/camera/camera_model.hpp"

namespace watersky {

struct Algorithm1Parameters {
  int width_cells = 0;   ///< N, along map x
  int height_cells = 0;  ///< M, along map y
  double dx_m = 0.5;
  double dy_m = 0.5;
  double p1 = 0.7;  ///< P(ice | pixel classed ice)
  double p2 = 0.4;  ///< P(ice | pixel classed not ice)
  double prior = 0.5;
  double sigma_px = 0.0;  ///< Gaussian blur in image pixels; 0 for none
};

/// A known feature, to draw over a map (A.2.3): a disc in the World frame.
struct IceFeature {
  Point<World> center;
  double radius_m = 0.0;
};

class Algorithm1 {
 public:
  /// InvalidInput for a size, cell or probability that makes no sense.
  [[nodiscard]] static Result<Algorithm1> make(const Algorithm1Parameters& parameters,
                                               const CameraModel& camera,
                                               const Rigid3<World, Map>& world_from_map);

  /// Adds one segmented image (CV_8U, not 0 is ice; of the camera's size). Degenerate when the
  /// camera lies in the map plane or below it; then nothing is added.
  Status update_map(const cv::Mat& segmented, const Rigid3<World, Camera>& world_from_camera);

  /// The same with a log-odds image (CV_32F, the prior not yet subtracted) in place of (2.31).
  Status update_map_log_odds(const cv::Mat& log_odds,
                             const Rigid3<World, Camera>& world_from_camera);

  /// Any image, undistorted and warped onto the map; border 0, cells behind the camera 0.
  [[nodiscard]] Result<cv::Mat> project_image_to_map(
      const cv::Mat& image, const Rigid3<World, Camera>& world_from_camera) const;

  /// Log-odds, CV_32F, height_cells x width_cells: rows along map y.
  [[nodiscard]] const cv::Mat& map() const { return map_; }
  /// (2.28), CV_32F.
  [[nodiscard]] cv::Mat probability_map() const;

  /// The cell that holds a position in the map plane (metres); may lie outside the map.
  [[nodiscard]] cv::Point to_map_coordinates(const Point<Map>& p_map) const;
  [[nodiscard]] Point<Map> to_map_frame(const Point<World>& p_world) const;

  /// Circles and numbers over `output` (8 bit, 1 or 3 channels, the map's size).
  void draw_features_on_map(const std::vector<IceFeature>& features, cv::Mat& output) const;

  /// X_m^c of (2.35).
  [[nodiscard]] Eigen::Matrix3d perspective_transform(
      const Rigid3<World, Camera>& world_from_camera) const;

 private:
  Algorithm1(const Algorithm1Parameters& parameters, const CameraModel& camera,
             const Rigid3<World, Map>& world_from_map);

  Algorithm1Parameters parameters_;
  CameraModel camera_;
  Undistorter undistorter_;
  Rigid3<Map, World> map_from_world_;
  cv::Mat map_;
};

}  // namespace watersky
