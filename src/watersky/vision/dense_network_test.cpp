// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/dense_network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace watersky::detail {
namespace {

DenseNetwork random_network(const std::vector<int>& widths, cv::RNG& random) {
  DenseNetwork network;
  for (int i = 0; i < widths[0]; ++i) {
    network.input_mean.push_back(random.uniform(-1.0F, 1.0F));
    network.input_scale.push_back(random.uniform(0.5F, 3.0F));
  }
  for (std::size_t l = 1; l < widths.size(); ++l) {
    DenseLayer layer{widths[l - 1], widths[l], {}, {}};
    for (int i = 0; i < layer.inputs * layer.outputs; ++i)
      layer.weights.push_back(static_cast<float>(random.gaussian(0.5)));
    for (int o = 0; o < layer.outputs; ++o)
      layer.biases.push_back(static_cast<float>(random.gaussian(0.5)));
    network.layers.push_back(layer);
  }
  return network;
}

Planes random_planes(int count, cv::Size size, cv::RNG& random) {
  Planes planes(static_cast<std::size_t>(count));
  for (auto& plane : planes) {
    plane.create(size, CV_32F);
    random.fill(plane, cv::RNG::NORMAL, 0.0, 2.0);
  }
  return planes;
}

/// Pixel by pixel, as one would write it down.
std::vector<double> by_hand(const DenseNetwork& network, const Planes& planes, int y, int x) {
  std::vector<double> in;
  for (std::size_t i = 0; i < planes.size(); ++i)
    in.push_back(
        std::clamp((planes[i].at<float>(y, x) - network.input_mean[i]) * network.input_scale[i],
                   -DenseNetwork::kClamp, DenseNetwork::kClamp));
  for (std::size_t l = 0; l < network.layers.size(); ++l) {
    const auto& layer = network.layers[l];
    std::vector<double> out(layer.biases.begin(), layer.biases.end());
    for (std::size_t o = 0; o < out.size(); ++o) {
      for (std::size_t i = 0; i < in.size(); ++i)
        out[o] += static_cast<double>(layer.weights[o * in.size() + i]) * in[i];
      if (l + 1 < network.layers.size()) out[o] = std::max(out[o], 0.0);
    }
    in = out;
  }
  return in;
}

TEST(DenseNetwork, EqualsTheSumsWrittenOut) {
  cv::RNG random(1);
  for (const auto& widths : {std::vector<int>{3, 2}, {7, 5, 3}, {26, 24, 12, 3}, {1, 9, 1, 4}})
    for (const cv::Size size : {cv::Size(1, 1), {64, 1}, {65, 3}, {40, 30}}) {
      const DenseNetwork network = random_network(widths, random);
      const Planes planes = random_planes(widths[0], size, random);
      const Planes outputs = evaluate(network, planes);
      ASSERT_EQ(outputs.size(), static_cast<std::size_t>(widths.back()));
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
          const auto expected = by_hand(network, planes, y, x);
          for (std::size_t o = 0; o < outputs.size(); ++o)
            ASSERT_NEAR(outputs[o].at<float>(y, x), expected[o], 1e-3);
        }
    }
}

// The shortcut, to interpolate the first layer's sums instead of its inputs, changes nothing
// but roundings.
TEST(DenseNetwork, TakesCoarseInputsAsIfTheyHadBeenEnlarged) {
  cv::RNG random(2);
  const DenseNetwork network = random_network({11, 6, 3}, random);
  for (const cv::Size size : {cv::Size(2, 2), {64, 2}, {130, 24}}) {
    const Planes fine = random_planes(4, size, random);
    Planes coarse = random_planes(7, size / 2, random), together = fine;
    for (std::size_t i = 0; i < coarse.size(); ++i) {
      // Within the clamp, which does not commute with interpolation.
      const double most = (DenseNetwork::kClamp - 0.01) / network.input_scale[i + 4];
      coarse[i] = cv::min(cv::max(coarse[i], network.input_mean[i + 4] - most),
                          network.input_mean[i + 4] + most);
      cv::Mat enlarged;
      cv::resize(coarse[i], enlarged, size, 0, 0, cv::INTER_LINEAR);
      together.push_back(enlarged);
    }
    const Planes a = evaluate(network, fine, coarse), b = evaluate(network, together);
    for (std::size_t o = 0; o < a.size(); ++o) EXPECT_LT(cv::norm(a[o], b[o], cv::NORM_INF), 1e-3);
  }
}

}  // namespace
}  // namespace watersky::detail
