// SPDX-License-Identifier: MIT
#pragma once
/// What can go wrong in the world, as a value.
#include <string>
#include <string_view>
#include <utility>

namespace watersky {

/// The kind of fault: it decides what a caller may do about it. Faults of ours are not here:
/// those are contract violations (contract.hpp).
enum class ErrorCode {
  InvalidInput,  ///< a file, message or value that contradicts its format or itself
  NotFound,      ///< a file, field or message that should be there is not
  Io,            ///< the operating system refused to read or write
  Unsupported,   ///< understood, but not something we can do
  Degenerate,    ///< geometry without an answer: a camera in the sea plane, parallel lines
  OutOfRange,    ///< outside what was recorded or is covered; nothing is extrapolated
  Exists,        ///< would overwrite what is there
  Usage,         ///< the call itself is at fault (exit status 2)
};

[[nodiscard]] std::string_view to_string(ErrorCode code);

/// A fault and its one-line explanation: what was wrong, where (file, line, field), and what
/// to do about it.
struct Error {
  ErrorCode code = ErrorCode::InvalidInput;
  std::string message;

  /// The same fault with its place put in front: `e.at("poses.csv:7")` → "poses.csv:7: …".
  [[nodiscard]] Error at(std::string_view place) const {
    return {code, std::string(place) + ": " + message};
  }
};

}  // namespace watersky
