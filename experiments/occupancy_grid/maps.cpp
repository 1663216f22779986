// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <set>

#include "algorithm1_map.hpp"
#include "study.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/sim/laboratory.hpp"

namespace watersky::study {

namespace {

constexpr SegmentationMethod kMethod = SegmentationMethod::Otsu;
/// Algorithm 1's canvas around the middle of the patches: all that is seen falls within.
constexpr double kHalfWidth_m = 2.2, kHalfHeight_m = 2.4;

/// The prepared flight with the mapped frames only.
Flight only(const Flight& prepared, const std::vector<const ImageFrame*>& frames) {
  std::set<std::string> names;
  for (const ImageFrame* frame : frames) names.insert(frame->name);
  Flight out = prepared;
  std::erase_if(out.frames, [&](const ImageFrame& f) { return !names.contains(f.name); });
  return out;
}

Result<RoomMap> run_ice_map(const Flight& flight) {
  MappingOptions options;
  options.parameters.map.cell_m = kCell_m;
  options.parameters.mosaic = false;
  options.method = kMethod;
  options.ice = IcePolarity::Brighter;
  options.threads = 2;
  WATERSKY_TRY(const MapRun run, map_flight(flight, options));
  const CellBox box = run.map.seen();
  const Eigen::Vector2d corner(box.first_column, box.first_row);
  return RoomMap{run.map.probability(box),
                 [reference = run.reference, datum = flight.datum,
                  corner](const Eigen::Vector2d& north_east_m) -> Eigen::Vector2d {
                   const Eigen::Vector2d p = room_from_scene(datum, north_east_m);
                   const Geodetic place = datum.geodetic(Point<World>{{p.x(), -p.y(), 0.0}});
                   const auto en = reference.projection.forward(place.latitude, place.longitude);
                   if (!en) return Eigen::Vector2d::Constant(std::nan(""));
                   return reference.grid(*en) - corner;
                 }};
}

}  // namespace

Result<RoomMap> run_algorithm1(const Flight& prepared, const std::vector<const ImageFrame*>& frames,
                               const std::vector<cv::Mat>& masks) {
  // World's axes are the map's: columns along x, rows along -y of the motion capture.
  Canvas canvas;
  canvas.cell_m = kCell_m;
  canvas.corner_m = {sim::kPaperMiddle_m[0] - kHalfWidth_m, sim::kPaperMiddle_m[1] - kHalfHeight_m};
  canvas.width_cells = static_cast<int>(std::lround(2.0 * kHalfWidth_m / kCell_m));
  canvas.height_cells = static_cast<int>(std::lround(2.0 * kHalfHeight_m / kCell_m));
  WATERSKY_TRY(const cv::Mat probability, algorithm1_map(prepared, frames, masks, canvas));
  return RoomMap{probability,
                 [canvas, datum = prepared.datum](const Eigen::Vector2d& north_east_m) {
                   const Eigen::Vector2d p = room_from_scene(datum, north_east_m);
                   return canvas.cell({p.x(), -p.y()});
                 }};
}

Result<RoomMap> make_map(const Flight& prepared, Mapper mapper,
                         const std::vector<const ImageFrame*>& frames) {
  if (mapper == Mapper::IceMap) return run_ice_map(only(prepared, frames));
  WATERSKY_TRY(const std::vector<cv::Mat> masks, segmented(frames));
  return run_algorithm1(prepared, frames, masks);
}

cv::Size RoomView::size() const {
  return {static_cast<int>(std::lround((x_to_m - x_from_m) * pixels_per_m)),
          static_cast<int>(std::lround((y_to_m - y_from_m) * pixels_per_m))};
}

Eigen::Vector2d RoomView::pixel(double x_m, double y_m) const {
  return {(x_m - x_from_m) * pixels_per_m - 0.5, (y_to_m - y_m) * pixels_per_m - 0.5};
}

cv::Mat in_room(const RoomMap& map, const Datum& datum, const RoomView& view) {
  // Over a room the projection is affine to far below a cell.
  const auto at = [&](double x, double y) { return map.grid(scene_from_room(datum, x, y)); };
  const Eigen::Vector2d origin = at(0, 0), per_x = at(1, 0) - origin, per_y = at(0, 1) - origin;
  cv::Mat out(view.size(), CV_32F);
  for (int v = 0; v < out.rows; ++v)
    for (int u = 0; u < out.cols; ++u) {
      const double x = view.x_from_m + (u + 0.5) / view.pixels_per_m;
      const double y = view.y_to_m - (v + 0.5) / view.pixels_per_m;
      const Eigen::Vector2d g = origin + x * per_x + y * per_y;
      const auto c = static_cast<int>(std::lround(g.x())), r = static_cast<int>(std::lround(g.y()));
      const bool on = c >= 0 && r >= 0 && c < map.probability.cols && r < map.probability.rows;
      out.at<float>(v, u) =
          on ? map.probability.at<float>(r, c) : std::numeric_limits<float>::quiet_NaN();
    }
  return out;
}

}  // namespace watersky::study
