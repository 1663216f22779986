// SPDX-License-Identifier: MIT
#include "watersky/base/error.hpp"

namespace watersky {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidInput: return "invalid_input";
    case ErrorCode::NotFound: return "not_found";
    case ErrorCode::Io: return "io";
    case ErrorCode::Unsupported: return "unsupported";
    case ErrorCode::Degenerate: return "degenerate";
    case ErrorCode::OutOfRange: return "out_of_range";
    case ErrorCode::Exists: return "exists";
    case ErrorCode::Usage: return "usage";
  }
  return "unknown";
}

}  // namespace watersky
