// SPDX-License-Identifier: MIT
#pragma once
/// The occupancy grid: log-odds of ice in sparse tiles. An update touches the footprint only.
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "watersky/base/parameters.hpp"
#include "watersky/base/time.hpp"
#include "watersky/map/evidence.hpp"
#include "watersky/map/grid_view.hpp"
#include "watersky/map/log_odds.hpp"
#include "watersky/map/map_tile.hpp"

namespace watersky {

namespace detail {
class FootprintUpdate;
}

struct MapParameters {
  double cell_m = 0.5;
  double prior = 0.5;
  double max_probability = 0.999;
  double half_life_s = 0.0;
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
    visit(self.half_life_s,
          ParameterInfo{"half_life_s", "s",
                        "cells forget: half of what is known of one is gone so long after its last "
                        "look (2.21); 0: they keep what they saw",
                        0, 1e9});
    visit(self.supersampling,
          ParameterInfo{"supersampling", "1",
                        "samples along a cell's edge, each bilinear; 0 averages the image over a "
                        "cell's area, wherever it covers more than a pixel",
                        0, 16});
  }
};

/// The instructions that updates are computed with on this processor: "scalar", "SSE4.1", "AVX2" or
/// "NEON". The result is the same in all.
[[nodiscard]] std::string_view update_instructions();

class IceMap {
 public:
  /// A tile, and how often it has changed.
  struct VersionedTile {
    MapTile tile;
    std::uint64_t version = 0;     ///< rises with every update that touches the tile
    std::uint64_t touched_in = 0;  ///< the map's own: which update did so last
  };
  /// In no order. A hash, because the cost of an update must not know how large the map is
  /// (bench/map_extent).
  using Tiles = std::unordered_map<TileIndex, VersionedTile, TileHash>;
  /// Cells forget by these dynamics, from this time on.
  struct Decay {
    CellDynamics dynamics;
    Time from;
  };

  [[nodiscard]] static Result<IceMap> make(const MapParameters& parameters);
  IceMap(const IceMap& other);
  IceMap& operator=(const IceMap& other);
  IceMap(IceMap&&) noexcept;
  IceMap& operator=(IceMap&&) noexcept;
  ~IceMap();

  [[nodiscard]] const MapParameters& parameters() const { return parameters_; }
  [[nodiscard]] double cell_m() const { return parameters_.cell_m; }
  /// Where decay() is on, a tile's evidence is that of each cell's last look.
  [[nodiscard]] const Tiles& tiles() const { return tiles_; }
  /// Puts a whole tile in place of what is there, with its version.
  void set_tile(const TileIndex& index, MapTile tile, std::uint64_t version);
  /// What the map takes in memory.
  [[nodiscard]] std::size_t bytes() const;
  /// The prior's log-odds.
  [[nodiscard]] float prior_log_odds() const { return prior_log_odds_; }

  /// Adds one frame, whose evidence is for each pixel of an image of the view's camera (scale the
  /// view to the evidence first). Each cell takes the mean over its own area in the image, by
  /// docs/decisions/0015; a cell of which less than half shows known pixels is not touched. Cells
  /// keep whole numbers of 1/1024: a look is rounded up or down by less than one, in turns, so
  /// that the mean over looks is not biased (IceMap.RoundingDoesNotBias). Returns the number of
  /// cells touched. InvalidInput when the size contradicts the view, and for images wider or
  /// higher than 32000 pixels.
  Result<std::size_t> update(const GridView& view, const Evidence& evidence, Time time);
  /// The same of log-odds minus the prior's (CV_32F; NaN: not known).
  Result<std::size_t> update(const GridView& view, const cv::Mat& evidence, Time time);

  /// From `from` on cells forget (2.21), each from its last look: the map's clock is the latest
  /// time of an update, or of predict(). Nothing is touched for it: a cell is brought forward when
  /// it is next updated or read. A look that comes late, with a time before the cell's last one,
  /// is added as it is. InvalidInput when the dynamics' stationary probability is not the map's
  /// prior. Off until asked for, here or by MapParameters::half_life_s.
  Status forget(const CellDynamics& dynamics, Time from);
  /// Whether cells forget, how, and from when.
  [[nodiscard]] const std::optional<Decay>& decay() const { return decay_; }
  /// Moves the clock forward; back it does not go.
  void predict(Time now);
  /// The time for which cells are read; nullopt before the first update.
  [[nodiscard]] const std::optional<Time>& clock() const { return clock_; }

  /// The box of all seen cells; empty when there are none.
  [[nodiscard]] CellBox seen() const;

  /// P(ice) (2.28), CV_32F; NaN where never seen.
  [[nodiscard]] cv::Mat probability(const CellBox& box) const;
  /// Log-odds, CV_32F; the prior's where never seen.
  [[nodiscard]] cv::Mat log_odds(const CellBox& box) const;
  /// CV_16U; 0 where never seen, 255 for that and more.
  [[nodiscard]] cv::Mat looks(const CellBox& box) const;
  /// Seconds UTC, CV_64F; NaN where never seen.
  [[nodiscard]] cv::Mat last_seen_s(const CellBox& box) const;

 private:
  explicit IceMap(const MapParameters& parameters);
  void bring_forward(MapTile::Block& block, Time time, const std::uint8_t* cells) const;

  MapParameters parameters_;
  float prior_log_odds_ = 0.0F;
  Tiles tiles_;
  std::optional<Decay> decay_;
  std::optional<Time> clock_;
  std::uint64_t updates_ = 0;
  std::unique_ptr<detail::FootprintUpdate> update_;  ///< memory only: a copy has its own
};

}  // namespace watersky
