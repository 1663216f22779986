// SPDX-License-Identifier: MIT
#pragma once
/// A small fully connected network, evaluated for every pixel of a stack of planes.
#include <opencv2/core/mat.hpp>
#include <vector>

namespace watersky::detail {

/// One value per pixel of one quantity: CV_32FC1, continuous. A stack's planes are of one size.
using Planes = std::vector<cv::Mat>;

/// outputs = weights * inputs + biases; weights row by row.
struct DenseLayer {
  int inputs = 0;
  int outputs = 0;
  std::vector<float> weights;
  std::vector<float> biases;
};

/// Inputs are brought to zero mean and unit variance and clamped, so that what was never seen in
/// training stays within what was; ReLU follows every layer but the last.
struct DenseNetwork {
  static constexpr float kClamp = 5.0F;  ///< standard deviations
  std::vector<float> input_mean;
  std::vector<float> input_scale;  ///< 1 / standard deviation
  std::vector<DenseLayer> layers;

  [[nodiscard]] int inputs() const { return static_cast<int>(input_mean.size()); }
  [[nodiscard]] int outputs() const { return layers.empty() ? 0 : layers.back().outputs; }
};

/// One plane per output. `planes`: one per input.
[[nodiscard]] Planes evaluate(const DenseNetwork& network, const Planes& planes);

/// The same for inputs at two scales: first `fine`, then `coarse` at half its size, bilinearly
/// interpolated to it. A linear layer commutes with interpolation, so the first layer's share of
/// the coarse inputs is summed at the coarse size and only those sums are interpolated.
[[nodiscard]] Planes evaluate(const DenseNetwork& network, const Planes& fine,
                              const Planes& coarse);

}  // namespace watersky::detail
