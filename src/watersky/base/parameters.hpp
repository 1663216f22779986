// SPDX-License-Identifier: MIT
#pragma once
/// Parameters that describe themselves, so that name, unit, range, default and meaning stand in
/// one place, and command line, run record and validation all read it there.
///
/// A parameter struct is a plain aggregate with its defaults and one static function:
///
///   struct BlurParameters {
///     double sigma_px = 0.0;
///     template <class Self, class Visitor>
///     static void describe(Self& self, Visitor&& visit) {
///       visit(self.sigma_px, {"sigma_px", "px", "Gaussian blur of the evidence", 0.0, 100.0});
///     }
///   };
///
/// A visitor is called with (T& value, const ParameterInfo&) for T of double, int, bool.
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

#include "watersky/base/result.hpp"

namespace watersky {

struct ParameterInfo {
  std::string_view name;  ///< snake case, ends in the unit: "cell_m"
  std::string_view unit;  ///< "m", "px", "deg", "1" for a pure number
  std::string_view help;  ///< one clause, no full stop
  double minimum = -std::numeric_limits<double>::infinity();  ///< inclusive
  double maximum = std::numeric_limits<double>::infinity();   ///< inclusive
};

/// "cell_m must be from 0.001 to 1000 m, is 0": the first parameter out of its range, if any.
template <class Parameters>
[[nodiscard]] Status validate(const Parameters& parameters) {
  Status status;
  Parameters::describe(parameters, [&](const auto& value, const ParameterInfo& info) {
    if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(value)>, bool>) {
      const double number = static_cast<double>(value);
      if (status.ok() && !(number >= info.minimum && number <= info.maximum)) {
        const auto text = [](double x) {
          std::string s = std::to_string(x);
          while (s.find('.') != std::string::npos && (s.back() == '0' || s.back() == '.')) {
            const bool dot = s.back() == '.';
            s.pop_back();
            if (dot) break;
          }
          return s;
        };
        status =
            Error{ErrorCode::Usage, std::string(info.name) + " must be from " + text(info.minimum) +
                                        " to " + text(info.maximum) +
                                        (info.unit == "1" ? "" : " " + std::string(info.unit)) +
                                        ", is " + text(number)};
      }
    }
  });
  return status;
}

}  // namespace watersky
