// SPDX-License-Identifier: MIT
#pragma once
/// How experiments tell people what they find: on standard error, and kept for a table on disk.
#include <cstdarg>
#include <cstdio>
#include <string>

namespace watersky::study {

/// All that was told so far.
inline std::string& told() {
  static std::string text;
  return text;
}

/// A printf of at most 399 characters.
[[gnu::format(printf, 1, 2)]] inline void tell(const char* format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  told() += text;
  std::fputs(text, stderr);
}

}  // namespace watersky::study
