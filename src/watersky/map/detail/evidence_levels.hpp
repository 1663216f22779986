// SPDX-License-Identifier: MIT
#pragma once
/// A frame's evidence as the kernels read it: 16 bits a pixel, made in small pieces when something
/// asks for them, at the scale at which it asks.
#include <memory>
#include <vector>

#include "watersky/map/detail/update_kernel.hpp"
#include "watersky/map/evidence.hpp"
#include "watersky/map/map_tile.hpp"

namespace watersky::detail {

/// How an image is averaged before it is read bilinearly: shrunk by a whole number, each pixel the
/// mean of shrink x shrink; then, if `doubled`, each pixel the mean of 2 x 2 neighbours without
/// shrinking. A bilinear reading then weighs a trapezoid of 2 shrink pixels' width, which for cells
/// that far apart sums to the same weight for every pixel.
struct Averaging {
  int shrink = 1;
  bool doubled = false;
  bool operator==(const Averaging&) const = default;
};

class EvidenceLevels {
 public:
  static constexpr int kMostPixels = 32000;  ///< along a row: strides are 15 bits
  static constexpr int kMostShrink = 64;

  explicit EvidenceLevels(const UpdateKernels& kernels) : kernels_(kernels) {}

  /// Starts a frame; `evidence`'s image must stay until the last piece is made. Expects check().
  void begin(const Evidence& evidence);

  /// One averaged image. Its indices run from -1 to width and height, beyond the edge by one pixel
  /// that repeats it.
  struct Level {
    Averaging averaging;
    int width = 0, height = 0, stride = 0;
    std::vector<std::int16_t> pixels;
    std::vector<std::uint8_t> chunks;  ///< what is made: kMissing, kMade, kMadeWithUnknown

    [[nodiscard]] const std::int16_t* at(int u, int v) const {
      return pixels.data() + static_cast<std::ptrdiff_t>(v + 1) * stride + u + 1;
    }
    /// A position of the full image, in this one's pixels.
    [[nodiscard]] double scaled(double full) const {
      return (full + 0.5) / averaging.shrink - 0.5 - (averaging.doubled ? 0.5 : 0.0);
    }
  };
  /// Valid until the next frame.
  [[nodiscard]] Level& level(const Averaging& averaging);
  /// Makes the pixels from (u0, v0) to (u1, v1), both included; whether any may be unknown.
  bool make(Level& level, int u0, int v0, int u1, int v1);

  /// Whether the sum of four bilinear readings fits into 32 bits.
  [[nodiscard]] bool four_add() const { return four_add_; }
  /// Of the full image.
  [[nodiscard]] int width_px() const { return image_.cols; }
  [[nodiscard]] int height_px() const { return image_.rows; }
  /// Pixels are log-odds in units of 2^-(10 + finer): as fine as 16 bits allow for what the
  /// frame says, at most 4 bits finer than a cell.
  [[nodiscard]] int finer_bits() const { return finer_; }

 private:
  /// Wide, because processors fetch ahead along rows of the image.
  static constexpr int kChunkWidth = 1024, kChunkHeight = 16;
  static constexpr std::uint8_t kMissing = 0, kMade = 1, kMadeWithUnknown = 2;

  void make_chunk(Level& level, int u0, int v0, int u1, int v1);
  void full_row(int v, int u0, int count, std::int16_t* out) const;
  void shrunk_row(const Averaging& averaging, int width, int height, int v, int u0, int count,
                  std::int16_t* out);
  void shrunk_carefully(int shrink, int v, int u0, int count, std::int16_t* out);
  void fill_count_table(int shrink);

  const UpdateKernels& kernels_;
  cv::Mat image_, valid_;
  bool levels_ = false, may_be_unknown_ = false;
  bool four_add_ = false;
  int finer_ = 0;
  std::array<std::int16_t, 256> table_{};
  /// Whether the table has but two values, and where the second begins.
  bool steps_ = false;
  std::uint8_t threshold_ = 0;
  std::int16_t below_ = 0, above_ = 0;
  int count_table_shrink_ = 0;
  std::vector<std::int16_t> count_table_;
  std::vector<std::unique_ptr<Level>> made_, spare_;
  std::vector<std::int16_t> rows_, full_;
  std::vector<std::uint8_t> counts_;
  std::vector<std::int32_t> sums_, known_;
};

}  // namespace watersky::detail
