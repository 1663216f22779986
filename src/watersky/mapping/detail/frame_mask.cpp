// SPDX-License-Identifier: MIT
#include "watersky/mapping/detail/frame_mask.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace watersky::detail {
namespace {

/// Edges are drawn on at most so many cells; beyond, on coarser ones.
constexpr double kMostDrawn_px = 4096;
/// Sea positions are worked out for every so many pixels and taken as straight in between.
constexpr int kStride_px = 8;
/// OpenCV draws in whole numbers of this part of a pixel.
constexpr int kFractionBits = 4;

}  // namespace

Result<ExcludedAreas> ExcludedAreas::make(const std::vector<GeoPolygon>& polygons,
                                          const MapReference& reference) {
  ExcludedAreas excluded;
  for (const GeoPolygon& polygon : polygons) {
    Area area;
    area.least.setConstant(std::numeric_limits<double>::infinity());
    area.most = -area.least;
    for (const auto& ring : polygon.rings_lon_lat_deg) {
      auto& out = area.rings.emplace_back();
      for (const Eigen::Vector2d& p : ring) {
        auto en = reference.projection.forward(Angle::degrees(p.y()), Angle::degrees(p.x()));
        if (!en) return en.error().at("polygon of a mask");
        out.push_back(reference.grid(*en));
        area.least = area.least.cwiseMin(out.back());
        area.most = area.most.cwiseMax(out.back());
      }
    }
    if (!area.rings.empty()) excluded.areas_.push_back(std::move(area));
  }
  return excluded;
}

cv::Mat ExcludedAreas::valid(const SeaView& view, const GridView& grid,
                             const CameraModel& camera) const {
  const CellBox& box = grid.box;
  const auto seen = [&](const Area& area) {
    return area.most.x() >= box.first_column - 1 && area.least.x() <= box.end_column() &&
           area.most.y() >= box.first_row - 1 && area.least.y() <= box.end_row();
  };
  if (std::none_of(areas_.begin(), areas_.end(), seen)) return {};

  // Drawn on the plane, where nothing is behind the camera, then looked up by each pixel.
  const double scale = std::min(1.0, kMostDrawn_px / std::max(box.columns, box.rows));
  cv::Mat drawn =
      cv::Mat::zeros(std::max(1, static_cast<int>(std::ceil(box.rows * scale))),
                     std::max(1, static_cast<int>(std::ceil(box.columns * scale))), CV_8U);
  const auto to_drawn = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d((p.x() - box.first_column + 0.5) * scale - 0.5,
                           (p.y() - box.first_row + 0.5) * scale - 0.5);
  };
  for (const Area& area : areas_) {
    if (!seen(area)) continue;
    std::vector<std::vector<cv::Point>> rings;
    for (const auto& ring : area.rings) {
      auto& out = rings.emplace_back();
      for (const Eigen::Vector2d& p : ring) {
        const Eigen::Vector2d d = to_drawn(p) * (1 << kFractionBits);
        constexpr double kMost = 1e9;  // OpenCV's coordinates are int
        out.emplace_back(static_cast<int>(std::clamp(d.x(), -kMost, kMost)),
                         static_cast<int>(std::clamp(d.y(), -kMost, kMost)));
      }
    }
    cv::fillPoly(drawn, rings, cv::Scalar(255), cv::LINE_8, kFractionBits);
  }

  const Eigen::Matrix3d grid_from_sea = grid.sea_from_grid.inverse();
  const cv::Size size(camera.width_px(), camera.height_px());
  const cv::Size coarse((size.width + kStride_px - 1) / kStride_px,
                        (size.height + kStride_px - 1) / kStride_px);
  // Pixels of the view's own camera for those of `camera`: both cover the same field.
  const double to_full_x = static_cast<double>(view.camera().width_px()) / size.width;
  const double to_full_y = static_cast<double>(view.camera().height_px()) / size.height;
  const auto position = [&](double x, double y) -> cv::Vec2f {
    const auto p = view.sea_point(Pixel{(x + 0.5) * to_full_x - 0.5, (y + 0.5) * to_full_y - 0.5});
    if (!p) return {-1e6F, -1e6F};
    const Eigen::Vector3d g = grid_from_sea * Eigen::Vector3d(p->v.x(), p->v.y(), 1.0);
    const Eigen::Vector2d d = to_drawn(g.head<2>() / g.z());
    return {static_cast<float>(d.x()), static_cast<float>(d.y())};
  };
  cv::Mat coarse_map(coarse, CV_32FC2), map;
  // cv::resize puts the middle of a coarse pixel at the middle of its block; blocks that hang over
  // the edge are part of the stretched field.
  const double step_x = static_cast<double>(size.width) / coarse.width;
  const double step_y = static_cast<double>(size.height) / coarse.height;
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x)
      coarse_map.at<cv::Vec2f>(y, x) = position((x + 0.5) * step_x - 0.5, (y + 0.5) * step_y - 0.5);
  cv::resize(coarse_map, map, size, 0, 0, cv::INTER_LINEAR);
  // Beyond the outermost middles resize only repeats: that half block is worked out exactly.
  const int rim = kStride_px / 2 + 1;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (y >= rim && y < size.height - rim && x == rim && size.width > 2 * rim)
        x = size.width - rim;
      map.at<cv::Vec2f>(y, x) = position(x, y);
    }
  cv::Mat blocked;
  cv::remap(drawn, blocked, map, cv::Mat(), cv::INTER_NEAREST, cv::BORDER_CONSTANT, cv::Scalar(0));
  return blocked == 0;
}

}  // namespace watersky::detail
