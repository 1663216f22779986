// SPDX-License-Identifier: MIT
#include "algorithm1_map.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include "ground_error.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky::study {

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
