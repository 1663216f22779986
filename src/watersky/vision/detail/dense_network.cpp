// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/dense_network.hpp"

#include <algorithm>
#include <cstring>

#include "watersky/base/contract.hpp"
#include "watersky/vision/detail/dispatch.hpp"
#include "watersky/vision/detail/enlarge.hpp"

namespace watersky::detail {
namespace {

/// Pixels that go through the network together: a multiple of the widest register, few enough
/// for all their activations to stay in the first-level cache.
constexpr int kBlock = 64;

WATERSKY_MULTIVERSION void standardise(const float* __restrict in, float mean, float scale,
                                       float* __restrict out) {
  for (int k = 0; k < kBlock; ++k) {
    float v = (in[k] - mean) * scale;
    v = v < -DenseNetwork::kClamp ? -DenseNetwork::kClamp : v;
    out[k] = v > DenseNetwork::kClamp ? DenseNetwork::kClamp : v;
  }
}

/// Eight floats in one register of AVX2, two of SSE2 or NEON.
typedef float Lanes __attribute__((vector_size(32)));
constexpr int kLanes = 8;
static_assert(kBlock % (2 * kLanes) == 0);

/// Two registers, from and to anywhere in memory.
inline void load(const float* from, Lanes& a, Lanes& b) {
  std::memcpy(&a, from, sizeof a);
  std::memcpy(&b, from + kLanes, sizeof b);
}
inline void store(const Lanes& a, const Lanes& b, float* to) {
  std::memcpy(to, &a, sizeof a);
  std::memcpy(to + kLanes, &b, sizeof b);
}

/// Outputs that are summed together; a layer's weights are packed in such groups.
constexpr int kGroup = 4;

/// Where a layer's sums start: at their biases, or at sums over other inputs.
struct FromBiases {
  const float* biases;
  void operator()(int output, int, Lanes& a, Lanes& b) const {
    a = biases[output] + Lanes{};
    b = a;
  }
};
struct FromSums {
  const float* sums;
  std::size_t stride;
  void operator()(int output, int pixel, Lanes& a, Lanes& b) const {
    load(sums + static_cast<std::size_t>(output) * stride + pixel, a, b);
  }
};

[[gnu::always_inline]] inline void rectify(Lanes& v) { v = v > 0.0F ? v : Lanes{}; }

/// out (kGroup * groups x kBlock) = start + weights * in (inputs x kBlock). Weights of a group lie
/// together input by input, `inputs_in_all` of them. A tile of four outputs by sixteen pixels at a
/// time: their eight sums stay in registers, and are enough to hide how long a multiplication
/// takes.
template <class Start>
[[gnu::always_inline]] inline void accumulate(const float* __restrict weights, int inputs_in_all,
                                              int inputs, int groups, const float* __restrict in,
                                              const Start& start, bool rectified,
                                              float* __restrict out) {
  for (int g = 0; g < groups; ++g, weights += kGroup * inputs_in_all, out += kGroup * kBlock)
    for (int k = 0; k < kBlock; k += 2 * kLanes) {
      float* y = out + k;
      Lanes p, q, a0, b0, a1, b1, a2, b2, a3, b3;
      start(kGroup * g, k, a0, b0);
      start(kGroup * g + 1, k, a1, b1);
      start(kGroup * g + 2, k, a2, b2);
      start(kGroup * g + 3, k, a3, b3);
      const float* w = weights;
      const float* x = in + k;
      for (int i = 0; i < inputs; ++i, w += kGroup, x += kBlock) {
        load(x, p, q);
        a0 += w[0] * p;
        b0 += w[0] * q;
        a1 += w[1] * p;
        b1 += w[1] * q;
        a2 += w[2] * p;
        b2 += w[2] * q;
        a3 += w[3] * p;
        b3 += w[3] * q;
      }
      if (rectified)
        for (Lanes* sum : {&a0, &b0, &a1, &b1, &a2, &b2, &a3, &b3}) rectify(*sum);
      store(a0, b0, y);
      store(a1, b1, y + kBlock);
      store(a2, b2, y + 2 * kBlock);
      store(a3, b3, y + 3 * kBlock);
    }
}

WATERSKY_MULTIVERSION void accumulate_from_biases(const float* weights, int inputs_in_all,
                                                  int inputs, int groups, const float* in,
                                                  const float* biases, bool rectified, float* out) {
  accumulate(weights, inputs_in_all, inputs, groups, in, FromBiases{biases}, rectified, out);
}

WATERSKY_MULTIVERSION void accumulate_from_sums(const float* weights, int inputs_in_all, int inputs,
                                                int groups, const float* in, const float* sums,
                                                std::size_t stride, bool rectified, float* out) {
  accumulate(weights, inputs_in_all, inputs, groups, in, FromSums{sums, stride}, rectified, out);
}

/// A block of pixels at its way through the layers.
class Block {
 public:
  explicit Block(const DenseNetwork& network) : network_(network) {
    int widest = network.inputs();
    for (const auto& layer : network.layers) {
      widest = std::max(widest, kGroup * groups(layer));
      packed_.push_back(packed(layer));
      biases_.push_back(layer.biases);
      biases_.back().resize(static_cast<std::size_t>(kGroup * groups(layer)));
    }
    in_.resize(static_cast<std::size_t>(widest) * kBlock);
    out_.resize(in_.size());
  }

  /// Loads standardised inputs `first`… from `planes` at `pixel`.
  void load(const Planes& planes, int first, std::size_t pixel, std::size_t count) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const float* source = planes[i].ptr<float>() + pixel;
      float rest[kBlock] = {};
      if (count < kBlock) {
        std::memcpy(rest, source, count * sizeof(float));
        source = rest;
      }
      const auto input = static_cast<std::size_t>(first) + i;
      standardise(source, network_.input_mean[input], network_.input_scale[input],
                  in_.data() + i * kBlock);
    }
  }

  /// The first layer's sums over inputs [first, first + count), which load() has brought.
  void sum_first(int first, int count) {
    accumulate_from_biases(packed_[0].data() + kGroup * first, network_.inputs(), count,
                           groups(network_.layers[0]), in_.data(), biases_[0].data(), false,
                           out_.data());
  }
  /// All layers, the first one from inputs [0, count).
  void run(int count) {
    accumulate_from_biases(packed_[0].data(), network_.inputs(), count, groups(network_.layers[0]),
                           in_.data(), biases_[0].data(), network_.layers.size() > 1, out_.data());
    finish();
  }
  /// All layers, the first one from inputs [0, count) and `sums` over its other inputs: rows of
  /// `stride` values, one row per output and up to a whole group, kBlock values to be read.
  void run(int count, const float* sums, std::size_t stride) {
    accumulate_from_sums(packed_[0].data(), network_.inputs(), count, groups(network_.layers[0]),
                         in_.data(), sums, stride, network_.layers.size() > 1, out_.data());
    finish();
  }
  void store(Planes& planes, std::size_t pixel, std::size_t count) const {
    for (std::size_t o = 0; o < planes.size(); ++o)
      std::memcpy(planes[o].ptr<float>() + pixel, out_.data() + o * kBlock, count * sizeof(float));
  }

  static int groups(const DenseLayer& layer) { return (layer.outputs + kGroup - 1) / kGroup; }

 private:
  void finish() {
    for (std::size_t l = 1; l < network_.layers.size(); ++l) {
      const DenseLayer& layer = network_.layers[l];
      in_.swap(out_);
      accumulate_from_biases(packed_[l].data(), layer.inputs, layer.inputs, groups(layer),
                             in_.data(), biases_[l].data(), l + 1 < network_.layers.size(),
                             out_.data());
    }
  }

  /// Group by group, in it input by input; zeros where a group has no output.
  static std::vector<float> packed(const DenseLayer& layer) {
    std::vector<float> weights;
    for (int g = 0; g < groups(layer); ++g)
      for (int i = 0; i < layer.inputs; ++i)
        for (int o = kGroup * g; o < kGroup * (g + 1); ++o)
          weights.push_back(o < layer.outputs
                                ? layer.weights[static_cast<std::size_t>(o * layer.inputs + i)]
                                : 0.0F);
    return weights;
  }

  const DenseNetwork& network_;
  std::vector<std::vector<float>> packed_, biases_;
  std::vector<float> in_, out_;
};

Planes make_planes(int count, cv::Size size) {
  Planes planes(static_cast<std::size_t>(count));
  for (auto& plane : planes) plane.create(size, CV_32F);
  return planes;
}

/// Calls body(first, count) for the blocks of `total` pixels.
template <class Body>
void for_each_block(std::size_t total, Body&& body) {
  for (std::size_t pixel = 0; pixel < total; pixel += kBlock)
    body(pixel, std::min<std::size_t>(kBlock, total - pixel));
}

}  // namespace

Planes evaluate(const DenseNetwork& network, const Planes& planes) {
  return evaluate(network, planes, {});
}

Planes evaluate(const DenseNetwork& network, const Planes& fine, const Planes& coarse) {
  WATERSKY_REQUIRE(!fine.empty() &&
                   fine.size() + coarse.size() == static_cast<std::size_t>(network.inputs()));
  const int fine_inputs = static_cast<int>(fine.size());
  const cv::Size size = fine[0].size();
  Block block(network);
  Planes outputs = make_planes(network.outputs(), size);
  if (coarse.empty()) {
    for_each_block(fine[0].total(), [&](std::size_t pixel, std::size_t count) {
      block.load(fine, 0, pixel, count);
      block.run(fine_inputs);
      block.store(outputs, pixel, count);
    });
    return outputs;
  }

  WATERSKY_REQUIRE(size == coarse[0].size() * 2);
  const DenseLayer& first = network.layers[0];
  Planes coarse_sums = make_planes(first.outputs, coarse[0].size());
  for_each_block(coarse[0].total(), [&](std::size_t pixel, std::size_t count) {
    block.load(coarse, fine_inputs, pixel, count);
    block.sum_first(fine_inputs, static_cast<int>(coarse.size()));
    block.store(coarse_sums, pixel, count);
  });
  const auto width = static_cast<std::size_t>(size.width);
  // Rows and groups are read to their end, whatever stands there.
  const std::size_t stride = (width + kBlock - 1) / kBlock * kBlock;
  std::vector<float> between(width / 2),
      sums(stride * static_cast<std::size_t>(kGroup * Block::groups(first)));
  for (int y = 0; y < size.height; ++y) {
    for (std::size_t o = 0; o < coarse_sums.size(); ++o)
      enlarged_row(coarse_sums[o], y, between.data(), sums.data() + o * stride);
    for_each_block(width, [&](std::size_t x, std::size_t count) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
      block.load(fine, 0, pixel, count);
      block.run(fine_inputs, sums.data() + x, stride);
      block.store(outputs, pixel, count);
    });
  }
  return outputs;
}

}  // namespace watersky::detail
