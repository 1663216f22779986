// SPDX-License-Identifier: MIT
/// How a DUNE task or a ROS node embeds the map core, which needs OpenCV and Eigen only.
/// The operations are those of the thesis's module (appendix A.2.3).
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "watersky/geo/rotation.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/map/ice_map.hpp"

using namespace watersky;

/// Owns a map of a fixed area and adds segmented images to it as they arrive. A framework calls
/// on_pose() and on_segmented_image() from its callbacks; nothing here knows which one it is.
class IceMappingTask {
 public:
  IceMappingTask(const CameraModel& camera, const Algorithm1Parameters& area, IceMap map,
                 Algorithm1 projector, const Rigid3<World, Map>& world_from_map)
      : camera_(camera),
        area_(area),
        map_(std::move(map)),
        projector_(std::move(projector)),
        world_from_map_(world_from_map) {}

  static Result<IceMappingTask> make(const CameraModel& camera, const Algorithm1Parameters& area,
                                     const Rigid3<World, Map>& world_from_map) {
    WATERSKY_TRY(IceMap map, IceMap::make({.cell_m = area.dx_m, .prior = area.prior}));
    WATERSKY_TRY(Algorithm1 projector, Algorithm1::make(area, camera, world_from_map));
    return IceMappingTask(camera, area, std::move(map), std::move(projector), world_from_map);
  }

  void on_pose(const Rigid3<World, Camera>& world_from_camera) {
    world_from_camera_ = world_from_camera;
  }

  /// updateMap: `segmented` is CV_8U, not 0 where there is ice.
  Status on_segmented_image(const cv::Mat& segmented, Time captured_at) {
    // World is flat here, as in a laboratory: Sea and World are one frame.
    const Rigid3<Sea, Camera> sea_from_camera(world_from_camera_.rotation(),
                                              Point<Sea>{world_from_camera_.origin().v});
    Eigen::Matrix3d sea_from_grid =
        world_from_map_.rotation().toRotationMatrix() * metres_from_cells(area_.dx_m, area_.dy_m);
    sea_from_grid.col(2) += world_from_map_.origin().v;
    sea_from_grid.row(2) << 0, 0, 1;
    WATERSKY_TRY(const SeaView view, SeaView::make(camera_, sea_from_camera));
    WATERSKY_TRY(const GridView grid, make_grid_view(view, sea_from_grid));
    cv::Mat evidence(segmented.size(), CV_32F,
                     cv::Scalar(log_odds(area_.p2) - log_odds(area_.prior)));
    evidence.setTo(log_odds(area_.p1) - log_odds(area_.prior), segmented);
    WATERSKY_CHECK(map_.update(grid, evidence, captured_at));
    return {};
  }

  /// projectImageToMap
  Result<cv::Mat> project_image_to_map(const cv::Mat& image) const {
    return projector_.project_image_to_map(image, world_from_camera_);
  }
  /// getProbMap: CV_32F, the prior where nobody has looked.
  cv::Mat probability_map() const {
    cv::Mat p = map_.probability({0, 0, area_.width_cells, area_.height_cells});
    cv::patchNaNs(p, area_.prior);
    return p;
  }
  /// drawFeaturesOnMap
  void draw_features_on_map(const std::vector<IceFeature>& features, cv::Mat& output) const {
    projector_.draw_features_on_map(features, output);
  }
  /// toMapCoordinates
  cv::Point to_map_coordinates(const Point<World>& p_world) const {
    return projector_.to_map_coordinates(projector_.to_map_frame(p_world));
  }

 private:
  CameraModel camera_;
  Algorithm1Parameters area_;
  IceMap map_;
  Algorithm1 projector_;
  Rigid3<World, Map> world_from_map_;
  Rigid3<World, Camera> world_from_camera_{Eigen::Quaterniond::Identity(), Point<World>{}};
};

int main(int argc, char** argv) {
  Eigen::Matrix3d intrinsics;
  intrinsics << 700, 0, 319.5, 0, 700, 179.5, 0, 0, 1;
  const auto camera = CameraModel::make(LensModel::Pinhole, 640, 360, intrinsics);
  // A room of 4 m by 3 m in cells of 1 cm; map x runs east, y south, z down.
  Eigen::Matrix3d axes;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Rigid3<World, Map> world_from_map(Eigen::Quaterniond(axes), Point<World>{{1.5, -2.0, 0.0}});
  auto task = IceMappingTask::make(
      *camera, {.width_cells = 400, .height_cells = 300, .dx_m = 0.01, .dy_m = 0.01},
      world_from_map);
  if (!task) {
    std::fprintf(stderr, "%s\n", task.error().message.c_str());
    return 1;
  }

  // A white patch in the image's upper left quarter, seen from 1.5 m, image top north.
  cv::Mat segmented(360, 640, CV_8U, cv::Scalar(0));
  segmented(cv::Rect(140, 80, 60, 40)).setTo(255);
  task->on_pose({camera_rotation({0_deg, -90_deg, 0_deg}), Point<World>{{0.0, 0.0, -1.5}}});
  for (int k = 0; k < 5; ++k) {
    if (const Status s = task->on_segmented_image(segmented, Time(seconds(k / 30.0))); !s) {
      std::fprintf(stderr, "%s\n", s.error().message.c_str());
      return 1;
    }
  }

  // The patch's centre: pixel (169.5, 99.5) is 150 px left and 80 px above the middle, so
  // 0.321 m west and 0.171 m north.
  const cv::Point cell =
      task->to_map_coordinates(Point<World>{{80 * 1.5 / 700, -150 * 1.5 / 700, 0.0}});
  const float p = task->probability_map().at<float>(cell);
  std::printf("P(ice) at the patch %.3f, beside it %.3f, unseen %.3f\n", static_cast<double>(p),
              static_cast<double>(task->probability_map().at<float>(cell + cv::Point(40, 0))),
              static_cast<double>(task->probability_map().at<float>(0, 0)));
  if (argc > 1) {
    cv::Mat picture;
    task->probability_map().convertTo(picture, CV_8U, 255);
    task->draw_features_on_map({{Point<World>{{80 * 1.5 / 700, -150 * 1.5 / 700, 0.0}}, 0.06}},
                               picture);
    cv::imwrite(argv[1], picture);
  }
  return p > 0.95F ? 0 : 1;
}
