// SPDX-License-Identifier: MIT
#pragma once
/// Masks: pictures whose values are classes, drawn by hand.
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "watersky/io/image_file.hpp"

namespace watersky {

/// What the values of a mask mean.
enum class MaskValues {
  Auto,     ///< Binary where 255 occurs, otherwise Classes
  Classes,  ///< 0 melt pond, 1 sea ice, 2 ocean (marlens123/tir_melt_pond_segmentation)
  Binary,   ///< 0 water, anything else ice
};

/// Melt ponds are water on ice: whoever sails counts them as ice, whoever looks for water not.
enum class PondIs { Water, Ice };

/// A mask's values, CV_8UC1. A mask saved in three equal channels is taken; InvalidInput for
/// colours, Unsupported for another depth, and InvalidInput when its size is not `expected`.
[[nodiscard]] Result<cv::Mat> read_mask(const std::filesystem::path& file, ImageSize expected);

/// Ice in a mask: CV_8U, 255 or 0. InvalidInput naming the first pixel whose value is no class.
[[nodiscard]] Result<cv::Mat> ice_in_mask(const cv::Mat& values, MaskValues meaning, PondIs pond);

/// The mask that belongs to an image: in each folder of `masks` a file with the image's name, or
/// with its stem and another ending; among files of `masks` the one with its stem, or, when it is
/// the only one and `only_image` says that there is but one image, that. NotFound says where it
/// looked; InvalidInput when two would do.
[[nodiscard]] Result<std::filesystem::path> find_mask(
    const std::filesystem::path& image, const std::vector<std::filesystem::path>& masks,
    bool only_image);

}  // namespace watersky
