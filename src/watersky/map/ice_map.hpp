// SPDX-License-Identifier: MIT
#pragma once
/// The occupancy grid: log-odds of ice in sparse tiles. An update touches the footprint only.
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/base/time.hpp"
#include "watersky/map/grid_view.hpp"
#include "watersky/map/log_odds.hpp"
#include "watersky/map/map_tile.hpp"

namespace watersky {

struct MapParameters {
  double cell_m = 0.5;
  double prior = 0.5;
  double max_probability = 0.999;
  int supersampling = 0;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.cell_m, ParameterInfo{"cell_m", "m", "edge of a map cell", 0.001, 1000.0});
    visit(self.prior,
          ParameterInfo{"prior", "1", "P(ice) of a cell nobody has seen", 0.001, 0.999});
    visit(
        self.max_probability,
        ParameterInfo{
            "max_probability", "1",
            "cells are kept within 1 minus this and this, so that a changed sea can change the map",
            0.6, 0.999999});
    visit(self.supersampling,
          ParameterInfo{
              "supersampling", "1",
              "samples along a cell's edge; 0 chooses one a pixel, 1 samples the cell's centre", 0,
              16});
  }
};

class IceMap {
 public:
  struct Tile {
    Tile();
    std::vector<float> evidence;       ///< log-odds minus the prior's; row by row
    std::vector<std::uint16_t> looks;  ///< frames that showed the cell; stays at 65535
    std::vector<double> last_seen_s;   ///< seconds UTC; NaN when never
  };

  [[nodiscard]] static Result<IceMap> make(const MapParameters& parameters);

  [[nodiscard]] const MapParameters& parameters() const { return parameters_; }
  [[nodiscard]] double cell_m() const { return parameters_.cell_m; }
  [[nodiscard]] const std::map<TileIndex, Tile>& tiles() const { return tiles_; }
  /// The prior's log-odds.
  [[nodiscard]] float prior_log_odds() const { return prior_log_odds_; }

  /// Adds one frame. `evidence` (CV_32F): log-odds minus the prior's for each pixel of an image
  /// of the view's camera (scale the view to the evidence first); NaN: not known. Each cell
  /// takes the mean over its own area in the image; a cell of which less than half shows known
  /// pixels is not touched. Returns the number of cells touched. InvalidInput when the size
  /// contradicts the view.
  Result<std::size_t> update(const GridView& view, const cv::Mat& evidence, Time time);

  /// Forgets: applies (2.21) to all seen cells over the elapsed seconds.
  void predict(const CellDynamics& dynamics, double elapsed_s);

  /// The box of all seen cells; empty when there are none.
  [[nodiscard]] CellBox seen() const;

  /// P(ice) (2.28), CV_32F; NaN where never seen.
  [[nodiscard]] cv::Mat probability(const CellBox& box) const;
  /// Log-odds, CV_32F; the prior's where never seen.
  [[nodiscard]] cv::Mat log_odds(const CellBox& box) const;
  /// CV_16U; 0 where never seen.
  [[nodiscard]] cv::Mat looks(const CellBox& box) const;
  /// Seconds UTC, CV_64F; NaN where never seen.
  [[nodiscard]] cv::Mat last_seen_s(const CellBox& box) const;

 private:
  explicit IceMap(const MapParameters& parameters);
  MapParameters parameters_;
  float prior_log_odds_ = 0.0F;
  std::map<TileIndex, Tile> tiles_;
};

}  // namespace watersky
