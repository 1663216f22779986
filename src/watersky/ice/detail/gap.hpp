// SPDX-License-Identifier: MIT
#pragma once
/// How far each piece of ice is from its nearest neighbour.
#include <opencv2/core/mat.hpp>
#include <vector>

namespace watersky::ice::detail {

/// For each label of `pieces` (CV_32S, 0 water) the cells of water on the way to the nearest
/// piece with another label; infinite when there is no other. Element 0 means nothing.
///
/// A chamfer distance with OpenCV's 5 x 5 weights (within 2.2 % of Euclid's) that carries the
/// nearest label along, measured where two pieces' regions meet. cv::distanceTransform does the
/// same with its labels, five times slower (bench/ice_objects: 0.5 s of 0.6 s).
[[nodiscard]] std::vector<float> gaps_cells(const cv::Mat& pieces, int labels);

}  // namespace watersky::ice::detail
