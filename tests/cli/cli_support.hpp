// SPDX-License-Identifier: MIT
#pragma once
/// Calls the program and looks at what it leaves.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/temporary_folder.hpp"

namespace watersky::test {

namespace fs = std::filesystem;

inline std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

struct Outcome {
  int status = -1;
  std::string out, err;

  /// Standard error without the lines that progress and left-out frames write.
  [[nodiscard]] std::string error_line() const {
    std::istringstream lines(err);
    std::string line, found;
    while (std::getline(lines, line))
      if (line.rfind("watersky", 0) == 0) found += (found.empty() ? "" : "\n") + line;
    return found;
  }
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out, nullptr, false); }
};

/// `prefix` stands before the program: for limits and the like.
inline Outcome watersky(const std::string& arguments, const std::string& prefix = "") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out", err = folder.path() / "err";
  const std::string command = prefix + "'" WATERSKY_PROGRAM "' " + arguments + " >'" +
                              out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_text(out),
          read_text(err)};
}

/// One line, on standard error, that begins with the verb.
inline void expect_one_line_error(const Outcome& outcome, int status) {
  EXPECT_EQ(outcome.status, status) << outcome.err;
  const std::string line = outcome.error_line();
  EXPECT_FALSE(line.empty()) << outcome.err;
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 0) << line;
}

/// A small simulated flight, made once a test program.
inline const fs::path& small_flight() {
  static const TemporaryFolder folder;
  static const fs::path flight = [] {
    const fs::path path = folder.path() / "flight";
    const Outcome made =
        watersky("simulate '" + path.string() +
                 "' --legs 1 --leg-length-m 120 --width-px 320 --height-px 256 --focal-px 300 "
                 "--supersampling 1 --quiet");
    if (made.status != 0) ADD_FAILURE() << made.err;
    return path;
  }();
  return flight;
}

/// A copy of it to damage.
inline fs::path copy_of_flight(const TemporaryFolder& folder) {
  const fs::path copy = folder.path() / "flight";
  fs::copy(small_flight(), copy, fs::copy_options::recursive);
  return copy;
}

inline std::vector<fs::path> images_of(const fs::path& flight) {
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(flight / "images"))
    images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  return images;
}

}  // namespace watersky::test
