// SPDX-License-Identifier: MIT
#pragma once
/// Drawn ice, for training: what a handful of hand-made masks does not show.
///
/// Masks cost hours, so there are few, of one campaign, and most of what they show is pack ice
/// with a little water. A network that saw nothing else takes whatever covers most of a picture
/// for ice. Here concentration, shapes, contrast and polarity are drawn evenly, so that none of
/// them is taken for granted: floes on open water, leads in closed ice, and patches without a
/// shape of their own, of which nobody could tell the classes apart unless told.
#include <opencv2/core/mat.hpp>

namespace watersky::detail {

struct DrawnScene {
  cv::Mat image;  ///< CV_32FC1 or CV_32FC3 (BGR), levels about 0 to 255; before blur and noise of
                  ///< a camera
  cv::Mat mask;   ///< CV_8UC1, values of IceClass
  bool floes_have_shape = true;  ///< so that the ice could be known by them
};

/// The next scene that `random` draws, of this size.
[[nodiscard]] DrawnScene draw_scene(cv::Size size, bool in_colour, cv::RNG& random);

}  // namespace watersky::detail
