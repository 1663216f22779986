// SPDX-License-Identifier: MIT
#include "algorithm1_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "ground_error.hpp"
#include "preparations.hpp"
#include "watersky/camera/sea_plane.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky::study {

Result<Canvas> canvas_over(const sim::Simulation& recording, double cell_m) {
  constexpr double kMargin_m = 20.0;  // poses err by less
  WATERSKY_TRY(const Flight exact, with_true_times_and_mount(recording.flight, recording.truth));
  Eigen::AlignedBox2d seen;
  for (const ImageFrame& frame : exact.frames) {
    WATERSKY_TRY(const CameraPose pose, exact.camera_pose(frame, kPoseGap));
    const auto view = SeaView::make(exact.camera, pose.sea_from_camera);
    if (!view) continue;
    const Rigid3<World, Sea> world_from_sea =
        exact.datum.ecef_from_world().inverse() * ecef_from_sea(pose.sea_below);
    for (const Eigen::Vector2d& p : view->footprint_north_east_m())
      seen.extend((world_from_sea * Point<Sea>{{p.x(), p.y(), 0.0}}).v.head<2>().eval());
  }
  if (seen.isEmpty()) return Error{ErrorCode::OutOfRange, "no frame sees the sea"};
  Canvas canvas;
  canvas.cell_m = cell_m;
  canvas.corner_m = seen.min().array() - kMargin_m;
  canvas.sea_down_m = recording.truth.world({0.0, 0.0}).v.z();
  const Eigen::Vector2d size_m = seen.sizes().array() + 2.0 * kMargin_m;
  canvas.width_cells = static_cast<int>(std::ceil(size_m.x() / cell_m));
  canvas.height_cells = static_cast<int>(std::ceil(size_m.y() / cell_m));
  return canvas;
}

cv::Mat true_share(const sim::Truth& truth, const Canvas& canvas) {
  return sim::ice_fraction(truth.sea, {canvas.width_cells, canvas.height_cells},
                           [&](const Eigen::Vector2d& north_east_m) -> Eigen::Vector2d {
                             const Eigen::Vector2d p = truth.world(north_east_m).v.head<2>();
                             // It counts from a cell's corner.
                             return canvas.cell(p).array() + 0.5;
                           });
}

Result<std::vector<cv::Mat>> segmented(const std::vector<const ImageFrame*>& frames) {
  WATERSKY_TRY(const auto segmenter,
               make_segmenter(SegmentationMethod::Otsu, {}, IcePolarity::Brighter));
  const std::size_t observed = std::min<std::size_t>(16, frames.size());  // as map_flight shows it
  for (std::size_t i = 0; i < observed; ++i) {
    WATERSKY_TRY(const cv::Mat image, frames[i * frames.size() / observed]->load({}));
    segmenter->observe(image, {});
  }
  std::vector<cv::Mat> masks;
  for (const ImageFrame* frame : frames) {
    WATERSKY_TRY(const cv::Mat image, frame->load({}));
    WATERSKY_TRY(const cv::Mat p_ice, segmenter->segment(image, {}));
    masks.emplace_back(p_ice > 0.5F);  // NaN: not ice
  }
  return masks;
}

Result<cv::Mat> algorithm1_map(const Flight& prepared, const std::vector<const ImageFrame*>& frames,
                               const std::vector<cv::Mat>& masks, const Canvas& canvas) {
  Algorithm1Parameters parameters;
  parameters.dx_m = parameters.dy_m = canvas.cell_m;
  parameters.width_cells = canvas.width_cells;
  parameters.height_cells = canvas.height_cells;
  const Rigid3<World, Map> world_from_map(
      Eigen::Quaterniond::Identity(),
      Point<World>{{canvas.corner_m.x(), canvas.corner_m.y(), canvas.sea_down_m}});
  WATERSKY_TRY(Algorithm1 algorithm, Algorithm1::make(parameters, prepared.camera, world_from_map));
  std::map<std::string, const cv::Mat*> mask_of;
  for (std::size_t i = 0; i < frames.size(); ++i) mask_of[frames[i]->name] = &masks[i];
  for (const ImageFrame& frame : prepared.frames) {
    const auto mask = mask_of.find(frame.name);
    if (mask == mask_of.end()) continue;
    const auto pose = prepared.camera_pose(frame, kPoseGap);
    if (!pose) continue;  // as map_flight: left out
    WATERSKY_CHECK(algorithm.update_map(*mask->second, pose->world_from_camera));
  }
  cv::Mat probability = algorithm.probability_map();
  // Sums of evidence are never exactly nothing; what nobody saw is.
  probability.setTo(std::numeric_limits<float>::quiet_NaN(), algorithm.map() == 0.0F);
  return probability;
}

}  // namespace watersky::study
