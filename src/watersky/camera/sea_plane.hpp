// SPDX-License-Identifier: MIT
#pragma once
/// A camera over the sea plane: what it sees of it, and the homography of (2.32) to (2.36).
#include <Eigen/Core>
#include <vector>

#include "watersky/base/angle.hpp"
#include "watersky/camera/camera_model.hpp"

namespace watersky {

/// X_m^c of (2.35): takes a homogeneous grid position (u, v, 1) to a homogeneous pixel of a
/// camera without distortion, A (R P + [0 0 t]). `plane_from_grid` is P_m^w of (2.34): a
/// homogeneous grid position to a point of the plane's frame. The third coordinate s of the
/// result is the depth along the optical axis; positions with s <= 0 are behind the camera and
/// must be masked.
template <Frame Plane>
[[nodiscard]] Eigen::Matrix3d image_from_grid(const Eigen::Matrix3d& camera_matrix,
                                              const Rigid3<Camera, Plane>& camera_from_plane,
                                              const Eigen::Matrix3d& plane_from_grid) {
  Eigen::Matrix3d x = camera_from_plane.rotation().toRotationMatrix() * plane_from_grid;
  x.col(2) += camera_from_plane.origin().v;
  return camera_matrix * x;
}

/// M of (2.33): cell indices to the metric position of the cell's centre on z = 0.
[[nodiscard]] Eigen::Matrix3d metres_from_cells(double dx_m, double dy_m);

/// (2.36). Degenerate when the camera lies in the plane.
[[nodiscard]] Result<Eigen::Matrix3d> invert_homography(const Eigen::Matrix3d& h);

/// How a camera moves while its shutter rolls. Times are of the middle row.
struct RollingShutter {
  double readout_s = 0.0;  ///< first row to last; 0: all rows at once
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();     ///< axes of Sea
  Eigen::Vector3d turn_rate_rad_s = Eigen::Vector3d::Zero();  ///< axes of Sea
};

struct ViewLimits {
  /// Rays that meet the sea at a flatter angle than this are not used: what they show is far,
  /// small and at the mercy of the pose.
  Angle min_grazing = Angle::degrees(10.0);
};

/// One camera over the sea z = 0 of the Sea frame under it.
class SeaView {
 public:
  /// Degenerate when the camera is in the sea or below it, when it is not a number, or when no
  /// pixel sees the sea above the grazing limit; the message says which, and the height.
  [[nodiscard]] static Result<SeaView> make(const CameraModel& camera,
                                            const Rigid3<Sea, Camera>& sea_from_camera,
                                            const ViewLimits& limits = {});

  [[nodiscard]] const CameraModel& camera() const { return camera_; }
  [[nodiscard]] const Rigid3<Sea, Camera>& sea_from_camera() const { return sea_from_camera_; }
  [[nodiscard]] double height_m() const { return -sea_from_camera_.origin().v.z(); }

  /// The sea position (z = 0) that a pixel sees; nullopt at or above the horizon, beyond the
  /// grazing limit, or beyond the lens's radius.
  [[nodiscard]] std::optional<Point<Sea>> sea_point(const Pixel& pixel) const;
  /// The pixel that sees a point, on or off the image; nullopt behind the camera or outside the
  /// lens's radius. Does not apply the grazing limit.
  [[nodiscard]] std::optional<Pixel> pixel(const Point<Sea>& p_sea) const;

  /// Only sea within this horizontal distance of the point under the camera is used.
  [[nodiscard]] double max_distance_m() const { return max_distance_m_; }
  /// Whether a part of the image is cut off by the grazing limit (or shows sky).
  [[nodiscard]] bool cut_by_grazing_limit() const { return cut_; }

  /// The outline (north, east) of the sea seen within the limit: a closed polygon, clockwise seen
  /// from above, without its last point repeated, its vertices dense enough that lens distortion
  /// shows.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& footprint_north_east_m() const {
    return footprint_;
  }

  /// Metres on the sea for one pixel in the image's middle, along the coarser direction; at nadir
  /// height over focal length. When the middle does not see the sea: at the point of the
  /// footprint nearest to the camera.
  [[nodiscard]] double gsd_m() const { return gsd_m_; }

 private:
  SeaView(const CameraModel& camera, const Rigid3<Sea, Camera>& sea_from_camera)
      : camera_(camera), sea_from_camera_(sea_from_camera) {}

  CameraModel camera_;
  Rigid3<Sea, Camera> sea_from_camera_;
  double max_distance_m_ = 0.0;
  bool cut_ = false;
  double gsd_m_ = 0.0;
  std::vector<Eigen::Vector2d> footprint_;
};

}  // namespace watersky
