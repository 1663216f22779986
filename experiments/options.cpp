// SPDX-License-Identifier: MIT
#include "options.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace watersky::study {

namespace {

/// Whether `word` could be read, all of it.
bool read(const Option& option, const char* word) {
  if (auto* const* path = std::get_if<std::filesystem::path*>(&option.target)) {
    **path = word;
    return *word != '\0';
  }
  if (auto* const* text = std::get_if<std::string*>(&option.target)) {
    **text = word;
    return *word != '\0';
  }
  char* end = nullptr;
  const double value = std::strtod(word, &end);
  if (end == word || *end != '\0' || !(value >= option.least) || value > 1e9) return false;
  if (auto* const* whole = std::get_if<int*>(&option.target)) {
    **whole = static_cast<int>(value);
    return value == std::floor(value);
  }
  *std::get<double*>(option.target) = value;
  return true;
}

}  // namespace

std::optional<int> read_options(int argc, char** argv, const std::string& program,
                                const std::vector<Option>& options) {
  bool good = true, help = false;
  std::size_t place = 0;  // of the next option without a name
  for (int i = 1; i < argc && good && !help; ++i) {
    const std::string_view word = argv[i];
    help = word == "--help";
    if (help) break;
    good = false;
    for (std::size_t k = 0; k < options.size() && !good; ++k) {
      const bool named = !options[k].name.empty() && options[k].name == word;
      const bool placed = options[k].name.empty() && k >= place && !word.starts_with("--");
      if (placed) place = k + 1;
      if (placed) good = read(options[k], argv[i]);
      if (named && i + 1 < argc) good = read(options[k], argv[++i]);
      if (named || placed) break;
    }
  }
  if (good && !help) return std::nullopt;
  std::string usage = "usage: " + program;
  for (const Option& option : options)
    usage += " [" + std::string(option.name) + (option.name.empty() ? "" : " ") +
             std::string(option.value) + "]";
  std::fprintf(help ? stdout : stderr, "%s\n", usage.c_str());
  return help ? 0 : 2;
}

int exit_status(const std::string& program, const Status& done) {
  if (done) return 0;
  std::fprintf(stderr, "%s: %s\n", program.c_str(), done.error().message.c_str());
  return 1;
}

}  // namespace watersky::study
