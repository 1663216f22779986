// SPDX-License-Identifier: MIT
#include "watersky/sim/sea.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "watersky/sim/detail/earth.hpp"
#include "watersky/sim/detail/sea_index.hpp"

namespace watersky::sim {

struct Sea::Geometry {
  Extent extent;
  std::vector<IceObject> objects;
  std::vector<Outline> pieces;
  std::vector<int> owners;
  std::vector<Lead> leads;
  std::unique_ptr<const SeaIndex> index;  ///< of outlines; null for a raster
  cv::Mat labels;                         ///< of a raster: CV_32S, object + 1
  cv::Mat picture;                        ///< CV_32F
  double cell_m = 0.0;                    ///< of a raster
};

namespace {

/// An index cell of half a metre holds few edges; a large scene gets larger cells, 16 million at
/// most, a room smaller ones.
double index_cell_m(const Sea::Extent& extent) {
  const double edge_m = std::sqrt(extent.north_m * extent.east_m);
  return std::max(std::min(0.5, edge_m / 128.0), edge_m / 4096.0);
}

void finish(IceObject& object) {
  object.equivalent_radius_m = std::sqrt(object.area_m2 / std::numbers::pi);
}

/// Whether ice of another object, or the raster's border, is nearer than the gap to a square.
std::vector<bool> isolated_objects(const cv::Mat& labels, std::size_t count, double gap_cells) {
  std::vector<bool> isolated(count, true);
  const int reach = static_cast<int>(std::ceil(gap_cells)) + 1;
  std::vector<cv::Point> near;
  for (int dr = -reach; dr <= reach; ++dr)
    for (int dc = -reach; dc <= reach; ++dc) {
      // Between the nearest sides of two squares.
      const double distance =
          std::hypot(std::max(0, std::abs(dr) - 1), std::max(0, std::abs(dc) - 1));
      if (distance < gap_cells) near.emplace_back(dc, dr);
    }
  for (int r = 0; r < labels.rows; ++r)
    for (int c = 0; c < labels.cols; ++c) {
      const int label = labels.at<int>(r, c);
      if (label == 0 || !isolated[static_cast<std::size_t>(label - 1)]) continue;
      if (r == 0 || c == 0 || r == labels.rows - 1 || c == labels.cols - 1) {
        isolated[static_cast<std::size_t>(label - 1)] = false;
        continue;
      }
      for (const cv::Point& d : near) {
        const int rr = r + d.y, cc = c + d.x;
        if (rr < 0 || cc < 0 || rr >= labels.rows || cc >= labels.cols) continue;
        const int other = labels.at<int>(rr, cc);
        if (other != 0 && other != label) isolated[static_cast<std::size_t>(label - 1)] = false;
      }
    }
  return isolated;
}

}  // namespace

Result<Sea> Sea::from_outlines(std::vector<Outline> outlines, const std::vector<bool>& isolated,
                               Extent extent, std::vector<Lead> leads) {
  if (!(extent.north_m > 0.0 && extent.east_m > 0.0 &&
        std::isfinite(extent.north_m * extent.east_m)))
    return Error{ErrorCode::InvalidInput, "the scene's extent must be positive"};
  auto geometry = std::make_shared<Geometry>();
  const Eigen::Vector2d half(0.5 * extent.north_m, 0.5 * extent.east_m);
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const Outline& outline = outlines[i];
    const std::string name = "outline " + std::to_string(i);
    if (outline.size() < 3)
      return Error{ErrorCode::InvalidInput, name + " has fewer than three corners"};
    for (const Eigen::Vector2d& p : outline)
      if (!((p.cwiseAbs() - half).maxCoeff() <= 0.0))
        return Error{ErrorCode::InvalidInput, name + " leaves the scene's extent"};
    IceObject object;
    object.id = static_cast<int>(i);
    object.area_m2 = std::abs(signed_area_m2(outline));
    if (!(object.area_m2 > 0.0)) return Error{ErrorCode::InvalidInput, name + " has no area"};
    object.centre_north_east_m = centroid(outline);
    object.max_length_m = max_length_m(outline);
    object.isolated = i < isolated.size() && isolated[i];
    finish(object);
    geometry->objects.push_back(object);
    geometry->owners.push_back(object.id);
  }
  geometry->extent = extent;
  geometry->pieces = std::move(outlines);
  geometry->leads = std::move(leads);
  geometry->index = std::make_unique<const SeaIndex>(geometry->pieces, geometry->owners, -half,
                                                     2.0 * half, index_cell_m(extent));
  return Sea(std::move(geometry));
}

Result<Sea> Sea::from_ascii(std::string_view drawing, double cell_m, double isolation_gap_m) {
  std::vector<std::string> lines;
  while (!drawing.empty()) {
    const std::size_t end = std::min(drawing.find('\n'), drawing.size());
    std::string_view line = drawing.substr(0, end);
    drawing.remove_prefix(std::min(end + 1, drawing.size()));
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!line.empty() && blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && blank(line.back())) line.remove_suffix(1);
    if (!line.empty()) lines.emplace_back(line);
  }
  if (lines.empty()) return Error{ErrorCode::InvalidInput, "the drawing of the sea is empty"};
  cv::Mat ice(static_cast<int>(lines.size()), static_cast<int>(lines[0].size()), CV_8U);
  for (int r = 0; r < ice.rows; ++r) {
    const std::string& line = lines[static_cast<std::size_t>(r)];
    const std::string place = "line " + std::to_string(r + 1) + " of the drawing";
    if (static_cast<int>(line.size()) != ice.cols)
      return Error{ErrorCode::InvalidInput, place + " has " + std::to_string(line.size()) +
                                                " characters, the first has " +
                                                std::to_string(ice.cols)};
    for (int c = 0; c < ice.cols; ++c) {
      const char drawn = line[static_cast<std::size_t>(c)];
      if (drawn != '#' && drawn != '.')
        return Error{ErrorCode::InvalidInput,
                     place + " holds '" + std::string(1, drawn) + "': '#' is ice and '.' water"};
      ice.at<unsigned char>(r, c) = drawn == '#' ? 1 : 0;
    }
  }
  return from_raster(ice, cv::Mat(), cell_m, isolation_gap_m);
}

Result<Sea> Sea::from_raster(const cv::Mat& ice, const cv::Mat& picture, double cell_m,
                             double isolation_gap_m) {
  if (ice.empty() || ice.type() != CV_8UC1)
    return Error{ErrorCode::InvalidInput, "the ice mask must be an 8-bit image of one channel"};
  if (!(cell_m > 0.0 && std::isfinite(cell_m)))
    return Error{ErrorCode::InvalidInput, "the mask's pixels must have a positive size in metres"};
  auto geometry = std::make_shared<Geometry>();
  geometry->cell_m = cell_m;
  geometry->extent = {ice.rows * cell_m, ice.cols * cell_m};
  const double north = 0.5 * geometry->extent.north_m, west = -0.5 * geometry->extent.east_m;

  if (!picture.empty()) {
    if (picture.size() != ice.size() || picture.channels() != 1)
      return Error{ErrorCode::InvalidInput,
                   "the picture must have one channel and the mask's size"};
    picture.convertTo(geometry->picture, CV_32F);
    const double mean_ice = cv::mean(geometry->picture, ice)[0];
    const double mean_water = cv::mean(geometry->picture, ice == 0)[0];
    if (cv::countNonZero(ice) == 0 || cv::countNonZero(ice == 0) == 0 ||
        !(std::abs(mean_ice - mean_water) > 1e-6 * (std::abs(mean_ice) + std::abs(mean_water))))
      return Error{ErrorCode::InvalidInput,
                   "the picture is as bright over ice as over water; give the mask alone"};
    geometry->picture = (geometry->picture - mean_water) / (mean_ice - mean_water);
  }

  cv::Mat stats, middles;
  const int labels =
      cv::connectedComponentsWithStats(ice, geometry->labels, stats, middles, 8, CV_32S);
  const auto count = static_cast<std::size_t>(labels - 1);
  const std::vector<bool> isolated =
      isolated_objects(geometry->labels, count, isolation_gap_m / cell_m);
  std::vector<Outline> ends(count);
  for (int r = 0; r < ice.rows; ++r)
    for (int c = 0; c < ice.cols; ++c) {
      const int label = geometry->labels.at<int>(r, c);
      if (label == 0) continue;
      int end = c + 1;
      while (end < ice.cols && geometry->labels.at<int>(r, end) == label) ++end;
      const double top = north - r * cell_m, bottom = north - (r + 1) * cell_m;
      const double left = west + c * cell_m, right = west + end * cell_m;
      geometry->pieces.push_back({{top, left}, {top, right}, {bottom, right}, {bottom, left}});
      geometry->owners.push_back(label - 1);
      for (const Eigen::Vector2d& p : geometry->pieces.back())
        ends[static_cast<std::size_t>(label - 1)].push_back(p);
      c = end - 1;
    }
  for (int i = 1; i < labels; ++i) {
    IceObject object;
    object.id = i - 1;
    object.area_m2 = stats.at<int>(i, cv::CC_STAT_AREA) * cell_m * cell_m;
    object.centre_north_east_m = {north - (middles.at<double>(i, 1) + 0.5) * cell_m,
                                  west + (middles.at<double>(i, 0) + 0.5) * cell_m};
    // The largest caliper is between corners of the convex hull; all pairs would be quadratic
    // in the size of the floe.
    const Outline& corners = ends[static_cast<std::size_t>(i - 1)];
    std::vector<cv::Point2f> points, hull;
    for (const Eigen::Vector2d& p : corners)
      points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    cv::convexHull(points, hull);
    Outline hull_outline;
    for (const cv::Point2f& p : hull) hull_outline.emplace_back(p.x, p.y);
    object.max_length_m = max_length_m(hull_outline);
    object.isolated = isolated[static_cast<std::size_t>(i - 1)];
    finish(object);
    geometry->objects.push_back(object);
  }
  return Sea(std::move(geometry));
}

Sea Sea::at(const Geodetic& anchor) const {
  Sea moved = *this;
  moved.anchor_ = anchor;
  return moved;
}

const Sea::Extent& Sea::extent() const { return geometry_->extent; }
const std::vector<IceObject>& Sea::objects() const { return geometry_->objects; }
const std::vector<Outline>& Sea::pieces() const { return geometry_->pieces; }
const std::vector<int>& Sea::owners() const { return geometry_->owners; }
const std::vector<Lead>& Sea::leads() const { return geometry_->leads; }
const SeaIndex* Sea::index() const { return geometry_->index.get(); }
bool Sea::has_picture() const { return !geometry_->picture.empty(); }

int Sea::object_at(double north_m, double east_m) const {
  if (geometry_->index) return geometry_->index->object_at(north_m, east_m);
  const double row = (0.5 * geometry_->extent.north_m - north_m) / geometry_->cell_m;
  const double column = (0.5 * geometry_->extent.east_m + east_m) / geometry_->cell_m;
  const cv::Mat& labels = geometry_->labels;
  if (!(row >= 0.0 && column >= 0.0 && row < labels.rows && column < labels.cols)) return -1;
  return labels.at<int>(static_cast<int>(row), static_cast<int>(column)) - 1;
}

double Sea::concentration() const {
  double ice = 0.0;
  for (const IceObject& object : objects()) ice += object.area_m2;
  return ice / (extent().north_m * extent().east_m);
}

float Sea::picture_at(double north_m, double east_m) const {
  const cv::Mat& picture = geometry_->picture;
  const double row = std::clamp((0.5 * extent().north_m - north_m) / geometry_->cell_m - 0.5, 0.0,
                                picture.rows - 1.0);
  const double column = std::clamp((0.5 * extent().east_m + east_m) / geometry_->cell_m - 0.5, 0.0,
                                   picture.cols - 1.0);
  const int r = static_cast<int>(row), c = static_cast<int>(column);
  const int r1 = std::min(r + 1, picture.rows - 1), c1 = std::min(c + 1, picture.cols - 1);
  const auto fr = static_cast<float>(row - r), fc = static_cast<float>(column - c);
  const float* top = picture.ptr<float>(r);
  const float* bottom = picture.ptr<float>(r1);
  return (1 - fr) * ((1 - fc) * top[c] + fc * top[c1]) +
         fr * ((1 - fc) * bottom[c] + fc * bottom[c1]);
}

Geodetic Sea::geodetic(const Eigen::Vector2d& north_east_m) const {
  return geodetic_of(SeaSurface(anchor_).above(north_east_m.x(), north_east_m.y(), 0.0));
}

}  // namespace watersky::sim
