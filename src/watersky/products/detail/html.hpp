// SPDX-License-Identifier: MIT
#pragma once
/// Text for pages.
#include <string>
#include <string_view>

#include "watersky/base/angle.hpp"

namespace watersky::detail {

/// Foreign text, safe between tags and in quoted attributes.
[[nodiscard]] std::string escaped(std::string_view text);

/// With so many digits behind the point; "–" when not finite.
[[nodiscard]] std::string number(double value, int decimals);
/// About three significant digits, thin spaces between thousands; "–" when not finite.
[[nodiscard]] std::string rounded(double value);
[[nodiscard]] std::string metres(double value_m);          ///< "2.34 cm", "12.4 m", "12.3 km"
[[nodiscard]] std::string square_metres(double value_m2);  ///< "52 m²", "1.23 km²"
[[nodiscard]] std::string percent(double fraction);        ///< "37.2 %"

/// Degrees and decimal minutes, as mariners write them: 78°54.012′ N. `decimals` of the minute.
[[nodiscard]] std::string latitude(Angle latitude, int decimals);
[[nodiscard]] std::string longitude(Angle longitude, int decimals);

/// "2018-08-05 01:00:44 UTC"; plain seconds when they do not count from 1970.
[[nodiscard]] std::string moment(double seconds_utc, bool is_utc = true);

}  // namespace watersky::detail
