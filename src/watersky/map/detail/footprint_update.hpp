// SPDX-License-Identifier: MIT
#pragma once
/// One frame into blocks of cells: the footprint, part by part, through the kernels.
#include <functional>

#include "watersky/map/detail/evidence_levels.hpp"
#include "watersky/map/detail/footprint.hpp"

namespace watersky::detail {

/// What a look does to a cell besides adding to it.
struct LookLimits {
  std::int16_t lowest = 0, highest = 0;  ///< of a cell's evidence
  int supersampling = 0;
};

/// The block at a place in the grid of blocks, ready to be written to: asked for once something of
/// it is seen, with the cells that will be (kCellStride apart, from its first cell; 255 or 0), or
/// nullptr for all of its cells.
using BlockAt = std::function<MapTile::Block&(int column, int row, const std::uint8_t* cells)>;

/// Keeps its memory from frame to frame.
class FootprintUpdate {
 public:
  explicit FootprintUpdate(const UpdateKernels& kernels = update_kernels())
      : kernels_(kernels), levels_(kernels) {}

  /// Adds `evidence`, which has passed check() and has the size of the view's camera. Returns the
  /// number of cells that took it.
  std::size_t run(const GridView& view, const Evidence& evidence, Time time,
                  const LookLimits& limits, const BlockAt& block_at);

 private:
  /// A part's patch in an averaged image, and where of it the kernels may read.
  struct Placed {
    CellJob job{};
    Window surely{}, perhaps{};
    bool unknown = false;
  };
  [[nodiscard]] Placed place(const FootprintPart& part, EvidenceLevels::Level& level, double dx,
                             double dy);
  void mark_seen(const Footprint& footprint, const FootprintPart& part, const Placed& placed,
                 double dx, double dy);
  void sample_exactly(const Footprint& footprint, const FootprintPart& part,
                      EvidenceLevels::Level& level, double dx, double dy);
  static void add_steps(const FootprintPart& part, double shrink, CellJob& job);
  bool finish_samples(const FootprintPart& part);

  static constexpr std::size_t kCells = MapTile::kCellsInBlock;
  const UpdateKernels& kernels_;
  EvidenceLevels levels_;
  alignas(64) std::array<std::uint8_t, kCells> mask_{}, possible_{};
  alignas(64) std::array<std::int32_t, kCells> sums_{}, counts_{};
};

}  // namespace watersky::detail
