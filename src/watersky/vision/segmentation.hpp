// SPDX-License-Identifier: MIT
#pragma once
/// Every segmentation method by its name.
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "watersky/vision/edges.hpp"
#include "watersky/vision/learned_segmenter.hpp"
#include "watersky/vision/local_otsu.hpp"
#include "watersky/vision/segmenter.hpp"
#include "watersky/vision/two_class.hpp"
#include "watersky/vision/watershed.hpp"

namespace watersky {

enum class SegmentationMethod {
  Learned,
  LearnedFast,
  LearnedBest,
  Otsu,
  LocalOtsu,
  Edges,
  Watershed
};

inline constexpr SegmentationMethod kDefaultSegmentationMethod = SegmentationMethod::Learned;

/// Whether it works by an IceModel.
[[nodiscard]] bool is_learned(SegmentationMethod method);

/// All of them, in the order in which they are shown.
[[nodiscard]] std::span<const SegmentationMethod> segmentation_methods();

/// As the command line spells it: "otsu", "local-otsu".
[[nodiscard]] std::string_view name_of(SegmentationMethod method);
/// Its inverse; Usage, listing the names, for any other.
[[nodiscard]] Result<SegmentationMethod> segmentation_method(std::string_view name);

/// "auto", "brighter", "darker".
[[nodiscard]] std::string_view name_of(IcePolarity ice);
[[nodiscard]] Result<IcePolarity> ice_polarity(std::string_view name);

/// Of all methods; each reads its own.
struct SegmentationParameters {
  /// Of the learned methods; nullptr: the one that ships.
  std::shared_ptr<const IceModel> model;
  LearnedParameters learned;
  TwoClassEvidence evidence;
  LocalOtsuParameters local_otsu;
  EdgeParameters edges;
  WatershedParameters watershed;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    TwoClassEvidence::describe(self.evidence, visit);
    LocalOtsuParameters::describe(self.local_otsu, visit);
    EdgeParameters::describe(self.edges, visit);
    WatershedParameters::describe(self.watershed, visit);
  }
};

/// Which model it works by: "shipped", or the file it was read from; empty where it needs none.
[[nodiscard]] std::string model_name(SegmentationMethod method,
                                     const SegmentationParameters& parameters);

/// A segmenter that has seen nothing yet. Usage when a parameter is out of its range.
[[nodiscard]] Result<std::unique_ptr<Segmenter>> make_segmenter(
    SegmentationMethod method, const SegmentationParameters& parameters = {},
    IcePolarity ice = IcePolarity::Auto);

}  // namespace watersky
