// SPDX-License-Identifier: MIT
#include "watersky/ice/size_class.hpp"

namespace watersky::ice {

std::string_view floe_size_class(double length_m) {
  if (length_m < 2) return "small ice cake";
  if (length_m < 20) return "ice cake";
  if (length_m < 100) return "small floe";
  if (length_m < 500) return "medium floe";
  if (length_m < 2000) return "big floe";
  if (length_m <= 10000) return "vast floe";
  return "giant floe";
}

std::string_view iceberg_size_class(double length_m) {
  if (length_m < 5) return "growler";
  if (length_m < 15) return "bergy bit";
  if (length_m <= 60) return "small iceberg";
  if (length_m <= 120) return "medium iceberg";
  if (length_m <= 200) return "large iceberg";
  return "very large iceberg";
}

}  // namespace watersky::ice
