// SPDX-License-Identifier: MIT
#include "watersky/sim/sea_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "watersky/sim/detail/random.hpp"
#include "watersky/sim/laboratory.hpp"

namespace watersky::sim {
namespace {

/// The size that a share `u` of all sizes stays below, for N(> d) ~ d^-exponent in [low, high].
double power_law_quantile(double u, double exponent, double low, double high) {
  const double a = std::pow(low, -exponent), b = std::pow(high, -exponent);
  return std::clamp(std::pow(a - u * (a - b), -1.0 / exponent), low, high);
}

/// `count` sizes, the largest first; one from each of as many equally likely classes, so that the
/// sum of their areas does not depend on the luck of the largest.
std::vector<double> power_law_sizes(Random& random, std::size_t count, double exponent, double low,
                                    double high) {
  std::vector<double> sizes(count);
  for (std::size_t i = 0; i < count; ++i)
    sizes[i] = power_law_quantile(
        (static_cast<double>(count - 1 - i) + random.uniform()) / static_cast<double>(count),
        exponent, low, high);
  return sizes;
}

double mean_area_m2(double exponent, double low, double high) {
  constexpr int kClasses = 20000;
  double sum = 0.0;
  for (int i = 0; i < kClasses; ++i) {
    const double d = power_law_quantile((i + 0.5) / kClasses, exponent, low, high);
    sum += 0.25 * std::numbers::pi * d * d;
  }
  return sum / kClasses;
}

/// Where ice may still go, on a raster finer than the gaps. Every step errs towards more water:
/// an outline covers all cells it touches, and its surroundings are widened by a cell more than
/// the gap.
class Room {
 public:
  explicit Room(const SeaParameters& p)
      : half_(0.5 * p.extent_north_m, 0.5 * p.extent_east_m),
        cell_m_(std::max(0.2, std::sqrt(p.extent_north_m * p.extent_east_m) / 4096.0)),
        taken_(static_cast<int>(std::floor(p.extent_north_m / cell_m_)),
               static_cast<int>(std::floor(p.extent_east_m / cell_m_)), CV_8U, cv::Scalar(0)) {
    taken_.row(0) = taken_.row(taken_.rows - 1) = 255;
    taken_.col(0) = taken_.col(taken_.cols - 1) = 255;
  }

  void close_lead(const Lead& lead) {
    std::vector<cv::Point> line;
    for (const Eigen::Vector2d& p : lead.centreline_north_east_m)
      line.emplace_back(cv::Point(static_cast<int>((p.y() + half_.y()) / cell_m_),
                                  static_cast<int>((p.x() + half_.x()) / cell_m_)));
    cv::polylines(taken_, line, false, 255,
                  std::clamp(static_cast<int>(std::lround(lead.width_m / cell_m_)), 1, 32767));
    fresh_ = false;
  }

  /// Moves an outline whose centroid is at (0, 0) to where it fits and keeps `gap_m` around it
  /// free; nullopt where there is no such place among those tried.
  std::optional<Outline> place(Random& random, Outline outline, double gap_m) {
    // A random part of a cell first, so that places are not bound to the raster.
    const Eigen::Vector2d part(random.uniform(0.0, cell_m_), random.uniform(0.0, cell_m_));
    double nearest = std::numeric_limits<double>::infinity();
    Eigen::Vector2d reach = Eigen::Vector2d::Zero();
    for (Eigen::Vector2d& p : outline) {
      nearest = std::min(nearest, p.norm());
      p += part;
      reach = reach.cwiseMax(p.cwiseAbs());
    }
    const int margin = static_cast<int>(std::ceil(gap_m / cell_m_)) + 2;
    const int rows = static_cast<int>(std::ceil(reach.x() / cell_m_)) + 1;
    const int columns = static_cast<int>(std::ceil(reach.y() / cell_m_)) + 1;
    cv::Mat body = cv::Mat::zeros(2 * (rows + margin) + 1, 2 * (columns + margin) + 1, CV_8U);
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& p : outline)
      corners.emplace_back(static_cast<int>(std::floor(p.y() / cell_m_)) + columns + margin,
                           static_cast<int>(std::floor(p.x() / cell_m_)) + rows + margin);
    cv::fillPoly(body, std::vector<std::vector<cv::Point>>{corners}, 255);
    cv::Mat grown;
    cv::dilate(body, body, cv::Mat::ones(3, 3, CV_8U));
    cv::dilate(body, grown,
               cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * margin - 1, 2 * margin - 1}));

    const std::optional<cv::Point> middle = find(random, body, corners, nearest);
    if (!middle) return std::nullopt;
    const cv::Rect all(middle->x - body.cols / 2, middle->y - body.rows / 2, body.cols, body.rows);
    const cv::Rect inside = all & cv::Rect(0, 0, taken_.cols, taken_.rows);
    taken_(inside) |= grown(inside - all.tl());
    const Eigen::Vector2d move = Eigen::Vector2d(middle->y * cell_m_, middle->x * cell_m_) - half_;
    for (Eigen::Vector2d& p : outline) p += move;
    return outline;
  }

 private:
  [[nodiscard]] bool fits(const cv::Mat& body, const std::vector<cv::Point>& corners,
                          const cv::Point& middle) const {
    const int top = middle.y - body.rows / 2, left = middle.x - body.cols / 2;
    // Where it does not fit, a corner commonly shows it at once.
    for (const cv::Point& corner : corners) {
      const int x = left + corner.x, y = top + corner.y;
      if (x < 0 || y < 0 || x >= taken_.cols || y >= taken_.rows || taken_.at<unsigned char>(y, x))
        return false;
    }
    for (int r = 0; r < body.rows; ++r) {
      const int y = top + r;
      const unsigned char* mine = body.ptr(r);
      const bool row_inside = y >= 0 && y < taken_.rows;
      const unsigned char* theirs = row_inside ? taken_.ptr(y) : nullptr;
      for (int c = 0; c < body.cols; ++c) {
        if (!mine[c]) continue;
        const int x = left + c;
        if (!row_inside || x < 0 || x >= taken_.cols || theirs[x]) return false;
      }
    }
    return true;
  }

  /// Tries the middles that are far enough from all ice; they are listed anew when the list has
  /// become stale.
  std::optional<cv::Point> find(Random& random, const cv::Mat& body,
                                const std::vector<cv::Point>& corners, double nearest_m) {
    for (const int tries : {3000, 6000}) {
      if (tries == 6000 || !fresh_ || nearest_m < 0.7 * listed_for_m_) list(nearest_m);
      if (middles_.empty()) return std::nullopt;
      for (int i = 0; i < tries; ++i) {
        const cv::Point& middle = middles_[random.index(middles_.size())];
        if (fits(body, corners, middle)) return middle;
      }
    }
    return std::nullopt;
  }

  void list(double nearest_m) {
    cv::Mat distance;
    cv::distanceTransform(taken_ == 0, distance, cv::DIST_L2, 3, CV_32F);
    middles_.clear();
    const auto least = static_cast<float>(0.95 * nearest_m / cell_m_);
    for (int r = 0; r < distance.rows; ++r)
      for (int c = 0; c < distance.cols; ++c)
        if (distance.at<float>(r, c) > least) middles_.emplace_back(c, r);
    listed_for_m_ = nearest_m;
    fresh_ = true;
  }

  Eigen::Vector2d half_;
  double cell_m_;
  cv::Mat taken_;  ///< CV_8U; rows run north, columns east
  std::vector<cv::Point> middles_;
  double listed_for_m_ = 0.0;
  bool fresh_ = false;
};

/// A crack from one side of the scene to the other that wanders as it goes.
Lead random_lead(Random& random, const SeaParameters& p) {
  const double length = std::hypot(p.extent_north_m, p.extent_east_m);
  const double azimuth = random.uniform(0.0, std::numbers::pi);
  const Eigen::Vector2d along(std::cos(azimuth), std::sin(azimuth)), across(-along.y(), along.x());
  const Eigen::Vector2d middle(random.uniform(-0.25, 0.25) * p.extent_north_m,
                               random.uniform(-0.25, 0.25) * p.extent_east_m);
  Lead lead;
  lead.width_m = p.lead_width_m * random.uniform(0.7, 1.3);
  double phase[4], amplitude[4];
  for (int k = 0; k < 4; ++k) {
    phase[k] = random.uniform(0.0, 2.0 * std::numbers::pi);
    amplitude[k] = 0.05 * length * random.uniform(0.3, 1.0) / std::pow(2.0, k);
  }
  constexpr int kPoints = 160;
  for (int i = 0; i <= kPoints; ++i) {
    const double s = 2.0 * i / kPoints - 1.0;
    double aside = 0.0;
    for (int k = 0; k < 4; ++k)
      aside += amplitude[k] * std::sin(std::numbers::pi * s * (1.5 + 2.3 * k) + phase[k]);
    lead.centreline_north_east_m.emplace_back(middle + s * length * along + aside * across);
  }
  return lead;
}

std::string percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

}  // namespace

Result<Sea> make_sea(const SeaParameters& p) {
  WATERSKY_CHECK(validate(p));
  if (p.paper_patches) return laboratory_sea(p.sea_seed, p.paper_azimuth_deg);
  if (p.floe_min_m > p.floe_max_m || p.isolated_min_m > p.isolated_max_m)
    return Error{ErrorCode::Usage,
                 "the smallest ice is larger than the largest: check floe_min_m, "
                 "floe_max_m, isolated_min_m and isolated_max_m"};
  Random random(static_cast<std::uint64_t>(p.sea_seed), Stream::Sea);
  Room room(p);
  std::vector<Lead> leads;
  for (int i = 0; i < p.lead_count; ++i) {
    leads.push_back(random_lead(random, p));
    room.close_lead(leads.back());
  }

  std::vector<Outline> outlines;
  std::vector<bool> isolated;
  double ice_m2 = 0.0;
  // Ice that does not fit is drawn again in another shape before it is given up.
  const auto add = [&](double diameter_m, const OutlineShape& shape, double gap_m, bool alone) {
    for (int shapes = 0; shapes < 3; ++shapes) {
      if (auto placed = room.place(random, random_outline(random, diameter_m, shape), gap_m)) {
        ice_m2 += 0.25 * std::numbers::pi * diameter_m * diameter_m;
        outlines.push_back(std::move(*placed));
        isolated.push_back(alone);
        return true;
      }
    }
    return false;
  };

  const OutlineShape rounded{.angularity = 0.2, .elongation = 0.18, .roughness = 0.015};
  for (const double d : power_law_sizes(random, static_cast<std::size_t>(p.isolated_count),
                                        p.isolated_exponent, p.isolated_min_m, p.isolated_max_m))
    if (!add(d, rounded, std::max(p.isolation_gap_m, p.floe_gap_m), true))
      return Error{ErrorCode::OutOfRange,
                   "only " + std::to_string(outlines.size()) + " of " +
                       std::to_string(p.isolated_count) +
                       " isolated objects fit; enlarge the scene or lower isolated_count"};

  const double area_m2 = p.extent_north_m * p.extent_east_m;
  const double wanted_m2 = p.concentration * area_m2 - ice_m2;
  if (wanted_m2 > 0.0) {
    const auto count = static_cast<std::size_t>(
        std::lround(wanted_m2 / mean_area_m2(p.floe_exponent, p.floe_min_m, p.floe_max_m)));
    // The largest come first. A few that do not fit are left out; more would bend the power law.
    double left_out_m2 = 0.0;
    for (const double d :
         power_law_sizes(random, count, p.floe_exponent, p.floe_min_m, p.floe_max_m)) {
      if (add(d, OutlineShape{}, p.floe_gap_m, false)) continue;
      left_out_m2 += 0.25 * std::numbers::pi * d * d;
      if (left_out_m2 > 0.02 * area_m2)
        return Error{
            ErrorCode::OutOfRange,
            "with " + percent(ice_m2 / area_m2) + " of the scene covered, floes of " +
                std::to_string(std::lround(d)) + " m no longer fit, so it cannot hold " +
                percent(p.concentration) +
                " of ice; lower concentration, floe_gap_m or floe_max_m, or enlarge the scene"};
    }
  }
  return Sea::from_outlines(std::move(outlines), isolated, {p.extent_north_m, p.extent_east_m},
                            std::move(leads));
}

std::vector<std::string_view> sea_preset_names() {
  return {"not_easy", "pack", "marginal", "bergs"};
}

Result<SeaParameters> sea_preset(std::string_view name) {
  SeaParameters p;
  if (name == "not_easy") return p;
  if (name == "pack") {
    p.concentration = 0.6;
    p.floe_exponent = 1.5;
    p.floe_min_m = 1.5;
    p.floe_max_m = 110.0;
    p.floe_gap_m = 0.3;
    p.isolated_count = 4;
    p.lead_count = 2;
    return p;
  }
  if (name == "marginal") {
    p.concentration = 0.3;
    p.floe_exponent = 2.4;
    p.floe_min_m = 2.0;
    p.floe_max_m = 30.0;
    p.isolated_count = 25;
    p.lead_count = 0;
    return p;
  }
  if (name == "bergs") {
    p.concentration = 0.0;
    p.isolated_count = 60;
    p.isolated_exponent = 0.8;
    p.isolated_max_m = 40.0;
    p.isolation_gap_m = 8.0;
    p.lead_count = 0;
    return p;
  }
  std::string known;
  for (const std::string_view preset : sea_preset_names())
    known += (known.empty() ? "" : ", ") + std::string(preset);
  return Error{ErrorCode::NotFound,
               "no sea is called '" + std::string(name) + "'; there are " + known};
}

}  // namespace watersky::sim
