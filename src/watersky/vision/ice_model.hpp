// SPDX-License-Identifier: MIT
#pragma once
/// The trained classifier: its file, and the one that comes with Watersky.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky {

namespace detail {
struct DenseNetwork;
}

/// A pair of small networks that look at an image at two scales; see docs/segmentation.md.
struct IceNetworks {
  std::shared_ptr<const detail::DenseNetwork> coarse, fine;
  std::vector<float> polarity;  ///< how much each cue says that ice is brighter; gray only
  float detail = 0.0F;  ///< log-odds of ice by what half the size leaves out; gray only
};

/// Networks for images of one channel and for images in colour; one of them may be absent. Their
/// outputs are melt pond, ice and open water (log of their probabilities but for a constant).
class IceModel {
 public:
  std::optional<IceNetworks> gray;
  std::optional<IceNetworks> colour;
  std::string name;         ///< where it was read from; not in the file
  std::string gray_origin;  ///< what it was trained on, one line
  std::string colour_origin;

  /// The model that ships with Watersky.
  [[nodiscard]] static const IceModel& shipped();
};

/// The file is text: a line that names format and version, the networks with their weights, and a
/// checksum. Numbers are the shortest that read back the same.
[[nodiscard]] std::string format_ice_model(const IceModel& model);

/// The inverse. `name` stands in errors and in the model: Unsupported for another version,
/// InvalidInput for text that is not a model, is cut short, damaged, or made for other features
/// than this program's.
[[nodiscard]] Result<IceModel> parse_ice_model(std::string_view text, const std::string& name);

}  // namespace watersky
