// SPDX-License-Identifier: MIT
#include "watersky/vision/segmentation.hpp"

#include <array>
#include <string>

#include "watersky/vision/otsu.hpp"

namespace watersky {

namespace {

constexpr std::array kMethods{SegmentationMethod::Learned,     SegmentationMethod::LearnedFast,
                              SegmentationMethod::LearnedBest, SegmentationMethod::Otsu,
                              SegmentationMethod::LocalOtsu,   SegmentationMethod::Edges,
                              SegmentationMethod::Watershed};
constexpr std::array kPolarities{IcePolarity::Auto, IcePolarity::Brighter, IcePolarity::Darker};

template <class Values>
auto named(const Values& values, std::string_view name, std::string_view what)
    -> Result<typename Values::value_type> {
  std::string names;
  for (const auto value : values) {
    if (name_of(value) == name) return value;
    names += (names.empty() ? "" : ", ") + std::string(name_of(value));
  }
  return Error{ErrorCode::Usage, "there is no " + std::string(what) + " \"" + std::string(name) +
                                     "\"; give one of " + names};
}

}  // namespace

std::span<const SegmentationMethod> segmentation_methods() { return kMethods; }

std::string_view name_of(SegmentationMethod method) {
  switch (method) {
    case SegmentationMethod::Learned: return "learned";
    case SegmentationMethod::LearnedFast: return "learned-fast";
    case SegmentationMethod::LearnedBest: return "learned-best";
    case SegmentationMethod::Otsu: return "otsu";
    case SegmentationMethod::LocalOtsu: return "local-otsu";
    case SegmentationMethod::Edges: return "edges";
    case SegmentationMethod::Watershed: return "watershed";
  }
  return "learned";
}

bool is_learned(SegmentationMethod method) {
  return method == SegmentationMethod::Learned || method == SegmentationMethod::LearnedFast ||
         method == SegmentationMethod::LearnedBest;
}

Result<SegmentationMethod> segmentation_method(std::string_view name) {
  return named(kMethods, name, "segmentation method");
}

std::string_view name_of(IcePolarity ice) {
  switch (ice) {
    case IcePolarity::Auto: return "auto";
    case IcePolarity::Brighter: return "brighter";
    case IcePolarity::Darker: return "darker";
  }
  return "auto";
}

Result<IcePolarity> ice_polarity(std::string_view name) {
  return named(kPolarities, name, "polarity of ice");
}

std::string model_name(SegmentationMethod method, const SegmentationParameters& parameters) {
  if (!is_learned(method)) return {};
  return parameters.model ? parameters.model->name : IceModel::shipped().name;
}

Result<std::unique_ptr<Segmenter>> make_segmenter(SegmentationMethod method,
                                                  const SegmentationParameters& parameters,
                                                  IcePolarity ice) {
  WATERSKY_CHECK(validate(parameters));
  const TwoClassEvidence& evidence = parameters.evidence;
  std::unique_ptr<Segmenter> made;
  const auto learned = [&](SegmentationQuality quality) {
    return std::make_unique<LearnedSegmenter>(
        parameters.learned, quality, ice,
        parameters.model ? *parameters.model : IceModel::shipped());
  };
  switch (method) {
    case SegmentationMethod::Learned: made = learned(SegmentationQuality::Standard); break;
    case SegmentationMethod::LearnedFast: made = learned(SegmentationQuality::Fast); break;
    case SegmentationMethod::LearnedBest: made = learned(SegmentationQuality::Best); break;
    case SegmentationMethod::Otsu: made = std::make_unique<OtsuSegmenter>(evidence, ice); break;
    case SegmentationMethod::LocalOtsu:
      made = std::make_unique<LocalOtsuSegmenter>(parameters.local_otsu, evidence, ice);
      break;
    case SegmentationMethod::Edges:
      made = std::make_unique<EdgeSegmenter>(parameters.edges, evidence, ice);
      break;
    case SegmentationMethod::Watershed:
      made = std::make_unique<WatershedSegmenter>(parameters.watershed, evidence, ice);
      break;
  }
  return made;
}

}  // namespace watersky
