// SPDX-License-Identifier: MIT
#pragma once
/// The WMO's and MANICE's words for how large a piece of ice is, by its greatest length.
#include <string_view>

namespace watersky::ice {

/// WMO: "small ice cake" below 2 m, "ice cake" below 20 m, "small floe" below 100 m, "medium
/// floe" below 500 m, "big floe" below 2 km, "vast floe" to 10 km, "giant floe" beyond. Pancake
/// ice is a matter of shape and of how it froze, which a map does not tell.
[[nodiscard]] std::string_view floe_size_class(double length_m);

/// "growler" below 5 m, "bergy bit" below 15 m, "small iceberg" to 60 m, "medium iceberg" to
/// 120 m, "large iceberg" to 200 m, "very large iceberg" beyond. By length alone: the WMO's
/// classes also use the height above the sea, which a map does not tell.
[[nodiscard]] std::string_view iceberg_size_class(double length_m);

}  // namespace watersky::ice
