// SPDX-License-Identifier: MIT
#pragma once
/// The outline of a footprint, row by row.
#include <Eigen/Core>
#include <utility>
#include <vector>

namespace watersky::detail {

/// The columns that a closed polygon covers between two values of y; first above second: none.
[[nodiscard]] std::pair<double, double> span_between(const std::vector<Eigen::Vector2d>& polygon,
                                                     double y0, double y1);

}  // namespace watersky::detail
