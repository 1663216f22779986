// SPDX-License-Identifier: MIT
#pragma once
/// Flat targets of known pattern, and where one was seen in an image.
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/camera/camera_model.hpp"

namespace watersky {

/// Holes is the thesis's plate (2.3): evenly spaced holes in a sheet that is warmer or colder than
/// what is seen through them. It is found as Circles are; the name is for people.
enum class TargetKind { Chessboard, Circles, AsymmetricCircles, Holes };

/// "chessboard", "circles", "asymmetric-circles", "holes".
[[nodiscard]] std::string_view name_of(TargetKind kind);
/// nullopt for another name.
[[nodiscard]] std::optional<TargetKind> target_kind(std::string_view name);

/// Points across and down, as OpenCV counts them: inner corners of a chessboard; circles; of an
/// asymmetric grid the circles in a row and the rows, every other row half a step to the right.
struct TargetSize {
  int columns = 0;
  int rows = 0;
  [[nodiscard]] int points() const { return columns * rows; }
  bool operator==(const TargetSize&) const = default;
};

/// "9x6". Usage where that is not two numbers from 3 to 100 with an x between them.
[[nodiscard]] Result<TargetSize> parse_target_size(std::string_view text);
[[nodiscard]] std::string to_string(const TargetSize& size);

/// One point of a target and the pixel that shows it.
struct TargetPoint {
  Eigen::Vector2d on_target;  ///< in spacings: between neighbours in a row (of an asymmetric grid
                              ///< between neighbouring rows)
  Pixel seen;
};

/// A target as one image shows it. Points lie row by row; where rows begin is arbitrary, because
/// every even pattern looks the same turned around.
struct DetectedTarget {
  TargetKind kind = TargetKind::Chessboard;
  TargetSize size;  ///< what is seen of it; less than the target where a part is out of the image
  std::vector<TargetPoint> points;
  /// How wide edges are, from 10 % to 90 % of their step, in pixels. NaN: not known.
  double edge_width_px = std::numeric_limits<double>::quiet_NaN();
  /// Radius of the circles in spacings; 0 for a chessboard.
  double radius = 0.0;
  /// Whether the circles are brighter (hotter) than what is around them; false for a chessboard.
  bool bright = false;
  /// The step between the pattern's two levels, in the image's levels. NaN: not known.
  double contrast = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace watersky
