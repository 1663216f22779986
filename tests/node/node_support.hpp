// SPDX-License-Identifier: MIT
#pragma once
/// Runs one of the programs of this folder.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "support/temporary_folder.hpp"

namespace watersky::test {

/// Why the programs of this folder cannot run here; empty when they can.
inline std::string node_is_missing() {
  if (std::string(WATERSKY_NODE).empty()) return "node is not installed";
  if (!std::filesystem::exists(WATERSKY_NODE_FOLDER "/node_modules"))
    return "tests/node/node_modules is not there; run scripts/setup test";
  return "";
}

#define WATERSKY_NEEDS_NODE()                                            \
  if (const std::string missing = node_is_missing(); !missing.empty()) { \
    GTEST_SKIP() << missing;                                             \
  }

/// What `node SCRIPT ARGUMENTS` prints, as JSON; a failure of the test when it fails.
inline nlohmann::json node(const std::string& script, const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string(), err = (folder.path() / "err").string();
  const std::string command = "'" WATERSKY_NODE "' '" WATERSKY_NODE_FOLDER "/" + script + "' " +
                              arguments + " >'" + out + "' 2>'" + err + "' </dev/null";
  const int status = std::system(command.c_str());
  const auto text = [](const std::string& file) {
    std::ostringstream all;
    all << std::ifstream(file, std::ios::binary).rdbuf();
    return all.str();
  };
  EXPECT_EQ(status, 0) << text(err);
  return nlohmann::json::parse(text(out), nullptr, false);
}

}  // namespace watersky::test
