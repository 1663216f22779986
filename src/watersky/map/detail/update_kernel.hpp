// SPDX-License-Identifier: MIT
#pragma once
/// The inner loops of the map's update, once for each instruction set, chosen at run time.
///
/// All of them are whole-number arithmetic and give the same bits; update_kernel_test.cpp holds
/// them to it. This header is included by files compiled for newer processors: plain structs only.
#include <cstddef>
#include <cstdint>

namespace watersky::detail {

/// Positions in an image are whole numbers of 2^-20 pixel, from -2048 to 2048 pixels.
inline constexpr int kPositionBits = 20;
/// Bilinear weights along an axis are whole numbers of 1/128, so a sum over four pixels has 14
/// more bits than they.
inline constexpr int kSumBits = 14;
/// Sums of several samples keep this many of them: 256 samples then fit into 32 bits.
inline constexpr int kSampleBits = 6;
/// A pixel that says nothing.
inline constexpr std::int16_t kUnknownPixel = -32768;
/// Cells from one row to the next in all arrays of cells.
inline constexpr int kCellStride = 32;

/// Where cells fall in an image: u + ui i + uj j + uii i² + uij i j + ujj j² for column i, row j.
struct CellPatch {
  std::int32_t u, ui, uj, uii, uij, ujj;
  std::int32_t v, vi, vj, vii, vij, vjj;
};

/// Some cells of a block and what they are sampled from. Columns: 16 or 32.
struct CellJob {
  CellPatch at;
  int columns, rows;
  const std::int16_t* image;  ///< the pixel at position (0, 0)
  int stride;                 ///< below 32768
  /// Positions are held between 0 and these by those functions that take a mask: a cell that is
  /// not wanted may fall anywhere.
  std::int32_t highest_u, highest_v;
  /// `add` sums over further samples of each cell, so far from the first; 0, 1 or 3 of them.
  static constexpr int kMostSteps = 3;
  int steps;
  std::int32_t step_u[kMostSteps], step_v[kMostSteps];
};

/// The cells' state. `evidence` takes (sum + dither) >> shift; the dither depends on the number of
/// looks, so that over any 16 looks in a row it takes each of 16 values once, and rounding does not
/// bias. At 255 looks, where the count stands still, `turn` (0 to 15) makes it change.
struct CellState {
  std::int16_t* evidence;
  std::uint8_t* looks;
  std::uint8_t* seen;
  std::int16_t lowest, highest;
  int shift;           ///< at least 5
  std::uint8_t place;  ///< of this look's time
  std::uint8_t turn;
};

/// An interval of positions in both axes.
struct Window {
  std::int32_t low_u, high_u, low_v, high_v;
};

struct UpdateKernels {
  const char* name;
  /// Adds one look to all cells. The shift of the state knows of the samples.
  void (*add)(const CellJob&, const CellState&);
  /// Adds one look to the cells whose mask is 255 (others: 0).
  void (*add_masked)(const CellJob&, const CellState&, const std::uint8_t* mask);
  /// sums += the bilinear reading with kSampleBits more bits, and counts += 1, where the mask is
  /// 255 and none of the four pixels is unknown.
  void (*sample)(const CellJob&, const std::uint8_t* mask, std::int32_t* sums,
                 std::int32_t* counts);
  /// Adds one look of given sums to the cells whose mask is 255.
  void (*add_sums)(int columns, int rows, const std::int32_t* sums, const CellState&,
                   const std::uint8_t* mask);
  /// Masks of the cells whose positions lie in `surely`, and in `perhaps`.
  void (*mark)(const CellJob&, const Window& surely, const Window& perhaps, std::uint8_t* sure,
               std::uint8_t* possible);

  /// `above` where a level is above the threshold, else `below`.
  void (*threshold)(const std::uint8_t* levels, int count, std::uint8_t threshold,
                    std::int16_t below, std::int16_t above, std::int16_t* out);
  /// The mean of 2 x 2 such values; reads count + 1 levels of both rows; values within ±8191.
  void (*threshold_2x2)(const std::uint8_t* levels, const std::uint8_t* next_row, int count,
                        std::uint8_t threshold, std::int16_t below, std::int16_t above,
                        std::int16_t* out);
  /// In how many of up to 255 rows, `stride` apart, the level is above the threshold.
  void (*count_above)(const std::uint8_t* levels, int stride, int rows, int count,
                      std::uint8_t threshold, std::uint8_t* counts);
  /// out[i] = table[sum of the k counts from k i on]; k at least 2.
  void (*sum_counts)(const std::uint8_t* counts, int k, int count, const std::int16_t* table,
                     std::int16_t* out);
  /// sums[i]: of the table's values of the k x k levels from column k i on, rows `stride` apart.
  void (*sum_table)(const std::uint8_t* levels, int stride, int k, int count,
                    const std::int16_t* table, std::int32_t* sums);
  /// The mean of 2 x 2 values; reads count + 1 of both rows.
  void (*mean_2x2)(const std::int16_t* values, const std::int16_t* next_row, int count,
                   std::int16_t* out);
};

/// For this processor: the fastest. Of `all_update_kernels` the first, scalar, is what the others
/// are compared with.
[[nodiscard]] const UpdateKernels& update_kernels();
/// Those that this processor can run; ends with nullptr.
[[nodiscard]] const UpdateKernels* const* all_update_kernels();

/// Each is there where the build has its file; see CMakeLists.txt.
extern const UpdateKernels kScalarKernels;
extern const UpdateKernels kSse41Kernels;
extern const UpdateKernels kAvx2Kernels;
extern const UpdateKernels kNeonKernels;

}  // namespace watersky::detail
