// SPDX-License-Identifier: MIT
#pragma once
/// What the parts of the segmentation study share.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "support/print_figure.hpp"
#include "watersky/base/result.hpp"
#include "watersky/evaluation/segmentation_score.hpp"
#include "watersky/io/mask_file.hpp"
#include "watersky/vision/segmenter.hpp"

namespace watersky::study {

struct LabelledImage {
  std::string name;
  cv::Mat image;
  cv::Mat classes;                            ///< as the mask has them: 0 pond, 1 ice, 2 ocean
  IcePolarity truth = IcePolarity::Brighter;  ///< of ice against the ocean
  [[nodiscard]] cv::Mat ice(PondIs pond) const;
};

/// FOLDER/images with FOLDER/masks.
[[nodiscard]] Result<std::vector<LabelledImage>> read_labelled(const std::filesystem::path& folder);

/// A method under study. `make` is shown the images that it may learn from, and the one that it
/// will be judged by, of which only a method that is said to be told something may look at more
/// than nothing.
struct Contender {
  std::string name;  ///< as figures spell it
  std::string what;  ///< for the table
  std::function<Result<std::unique_ptr<Segmenter>>(
      const std::vector<const LabelledImage*>& training, const LabelledImage& judged, PondIs pond)>
      make;
};
[[nodiscard]] std::vector<Contender> contenders();

/// Figure 2.1: image, histogram with its threshold, the classes, the classes closed, the truth.
Status write_figure_2_1(const std::filesystem::path& file, const LabelledImage& image);

/// How often the polarity is found, alone and as a flight; figures polarity.*.
void study_polarity(const std::filesystem::path& data, const std::vector<LabelledImage>& thermal);

/// The methods on points of drone tiles that were labelled by eye; figures
/// segmentation.glacier_bay.*. Nothing where either is absent.
Status study_points(const std::filesystem::path& tiles, const std::filesystem::path& points);

}  // namespace watersky::study
