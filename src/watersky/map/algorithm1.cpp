// SPDX-License-Identifier: MIT
#include "watersky/map/algorithm1.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "watersky/camera/sea_plane.hpp"
#include "watersky/map/log_odds.hpp"

namespace watersky {

Algorithm1::Algorithm1(const Algorithm1Parameters& parameters, const CameraModel& camera,
                       const Rigid3<World, Map>& world_from_map)
    : parameters_(parameters),
      camera_(camera),
      undistorter_(camera),
      map_from_world_(world_from_map.inverse()),
      map_(parameters.height_cells, parameters.width_cells, CV_32F,
           cv::Scalar(log_odds(parameters.prior))) {}

Result<Algorithm1> Algorithm1::make(const Algorithm1Parameters& p, const CameraModel& camera,
                                    const Rigid3<World, Map>& world_from_map) {
  const auto bad = [](const char* message) { return Error{ErrorCode::InvalidInput, message}; };
  if (p.width_cells <= 0 || p.height_cells <= 0) return bad("the map needs at least one cell");
  if (!(p.dx_m > 0) || !(p.dy_m > 0)) return bad("a cell's edges must be longer than 0 m");
  for (const double probability : {p.p1, p.p2, p.prior})
    if (!(probability > 0 && probability < 1))
      return bad("P1, P2 and the prior must lie between 0 and 1");
  if (!(p.sigma_px >= 0)) return bad("sigma must not be negative");
  return Algorithm1(p, camera, world_from_map);
}

Eigen::Matrix3d Algorithm1::perspective_transform(
    const Rigid3<World, Camera>& world_from_camera) const {
  const Rigid3<Camera, Map> camera_from_map = (map_from_world_ * world_from_camera).inverse();
  return image_from_grid(camera_.camera_matrix(), camera_from_map,
                         metres_from_cells(parameters_.dx_m, parameters_.dy_m));
}

Result<cv::Mat> Algorithm1::project_image_to_map(
    const cv::Mat& image, const Rigid3<World, Camera>& world_from_camera) const {
  if (image.cols != camera_.width_px() || image.rows != camera_.height_px())
    return Error{ErrorCode::InvalidInput, "the image's size contradicts the camera"};
  // Map z points down, so a camera over the plane has a negative z.
  if (!((map_from_world_ * world_from_camera).origin().v.z() < 0))
    return Error{ErrorCode::Degenerate, "the camera lies in the map plane or below it"};
  const Eigen::Matrix3d x = perspective_transform(world_from_camera);
  if (const auto invertible = invert_homography(x); !invertible) return invertible.error();

  cv::Mat plain, valid, warped;
  if (camera_.distorts()) {
    undistorter_.undistort(image, plain, valid);
  } else {
    plain = image;
  }
  // warpPerspective wants the map-to-image transform when told that it is the inverse.
  const cv::Matx33d m(x(0, 0), x(0, 1), x(0, 2), x(1, 0), x(1, 1), x(1, 2), x(2, 0), x(2, 1),
                      x(2, 2));
  cv::warpPerspective(plain, warped, m, map_.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                      cv::BORDER_CONSTANT, cv::Scalar::all(0));
  for (int v = 0; v < warped.rows; ++v)
    for (int u = 0; u < warped.cols; ++u)
      if (x(2, 0) * u + x(2, 1) * v + x(2, 2) <= 0)
        std::fill_n(warped.ptr(v, u), warped.elemSize(), std::uint8_t{0});  // behind the camera
  return warped;
}

Status Algorithm1::update_map_log_odds(const cv::Mat& image,
                                       const Rigid3<World, Camera>& world_from_camera) {
  if (image.type() != CV_32F) return Error{ErrorCode::InvalidInput, "log-odds must be CV_32F"};
  cv::Mat n = image - log_odds(parameters_.prior);
  if (parameters_.sigma_px > 0) cv::GaussianBlur(n, n, {}, parameters_.sigma_px);
  WATERSKY_TRY(const cv::Mat warped, project_image_to_map(n, world_from_camera));
  map_ += warped;
  return {};
}

Status Algorithm1::update_map(const cv::Mat& segmented,
                              const Rigid3<World, Camera>& world_from_camera) {
  if (segmented.type() != CV_8U)
    return Error{ErrorCode::InvalidInput, "a segmented image must be CV_8U"};
  cv::Mat n(segmented.size(), CV_32F, cv::Scalar(log_odds(parameters_.p2)));
  n.setTo(log_odds(parameters_.p1), segmented);
  return update_map_log_odds(n, world_from_camera);
}

cv::Mat Algorithm1::probability_map() const {
  cv::Mat p;
  cv::exp(-map_, p);
  p = 1.0 / (1.0 + p);
  return p;
}

cv::Point Algorithm1::to_map_coordinates(const Point<Map>& p) const {
  return {static_cast<int>(std::floor(p.v.x() / parameters_.dx_m)),
          static_cast<int>(std::floor(p.v.y() / parameters_.dy_m))};
}

Point<Map> Algorithm1::to_map_frame(const Point<World>& p_world) const {
  return map_from_world_ * p_world;
}

void Algorithm1::draw_features_on_map(const std::vector<IceFeature>& features,
                                      cv::Mat& output) const {
  const cv::Scalar color = output.channels() == 3 ? cv::Scalar(0, 114, 213) : cv::Scalar(255);
  int number = 0;
  for (const IceFeature& feature : features) {
    ++number;
    const Eigen::Vector3d p = to_map_frame(feature.center).v;
    // Cell (c, r) covers [c, c+1) in p / d, while drawing counts from the pixel's centre.
    const cv::Point center(static_cast<int>(std::lround(p.x() / parameters_.dx_m - 0.5)),
                           static_cast<int>(std::lround(p.y() / parameters_.dy_m - 0.5)));
    const cv::Size axes(
        std::max(1, static_cast<int>(std::lround(feature.radius_m / parameters_.dx_m))),
        std::max(1, static_cast<int>(std::lround(feature.radius_m / parameters_.dy_m))));
    cv::ellipse(output, center, axes, 0, 0, 360, color, 1, cv::LINE_AA);
    cv::putText(output, std::to_string(number), center + cv::Point(axes.width + 2, 4),
                cv::FONT_HERSHEY_SIMPLEX, 0.4, color, 1, cv::LINE_AA);
  }
}

}  // namespace watersky
