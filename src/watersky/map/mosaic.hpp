// SPDX-License-Identifier: MIT
#pragma once
/// The pictures themselves laid onto the sea plane, because people look before they measure.
#include <map>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/map/ice_map.hpp"

namespace watersky {

/// Of all frames that saw a cell, the one that saw it nearest to its nadir gives the colour.
class Mosaic {
 public:
  /// Adds one frame: 8 bit, 1 or 3 (BGR) channels, of the view's camera (scale the view first).
  /// Each cell takes the mean colour over its own area.
  Status add(const GridView& view, const cv::Mat& image);

  [[nodiscard]] bool empty() const { return tiles_.empty(); }
  /// BGR and validity (255 seen, 0 not) as four 8-bit channels.
  [[nodiscard]] cv::Mat bgra(const CellBox& box) const;
  [[nodiscard]] CellBox seen() const;

 private:
  struct Tile {
    Tile();
    std::vector<cv::Vec3b> bgr;
    std::vector<float>
        distance2_m2;  ///< squared, from the point under the camera; infinity: not seen
  };
  /// `image`: the frame's, shrunk by a whole factor.
  template <int Channels>
  void lay(const GridView& view, const cv::Mat& image, int shrink);

  std::map<TileIndex, Tile> tiles_;
};

}  // namespace watersky
