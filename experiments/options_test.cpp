// SPDX-License-Identifier: MIT
#include "options.hpp"

#include <gtest/gtest.h>

namespace watersky::study {
namespace {

struct Read {
  int seeds = 10;
  double rate_hz = 5.0;
  std::filesystem::path data = "data", out = "out";
  std::optional<int> status;
};

Read read(std::vector<std::string> words) {
  Read r;
  words.insert(words.begin(), "study");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  r.status = read_options(static_cast<int>(argv.size()), argv.data(), "study",
                          {{"", "DATA", &r.data},
                           {"--seeds", "N", &r.seeds},
                           {"--rate", "HZ", &r.rate_hz, 0.1},
                           {"--out", "FOLDER", &r.out}});
  return r;
}

TEST(Options, AreReadInAnyOrderAndStayWhereNotGiven) {
  const Read r = read({"--rate", "2.5", "here", "--seeds", "3"});
  EXPECT_EQ(r.status, std::nullopt);
  EXPECT_EQ(r.seeds, 3);
  EXPECT_DOUBLE_EQ(r.rate_hz, 2.5);
  EXPECT_EQ(r.data, "here");
  EXPECT_EQ(r.out, "out");
  EXPECT_EQ(read({}).status, std::nullopt);
}

TEST(Options, HelpIsNoFaultAndAnythingElseIs) {
  EXPECT_EQ(read({"--help"}).status, 0);
  const std::vector<std::vector<std::string>> bad = {
      {"--seeds"},        {"--seeds", "0"},   {"--seeds", "2.5"}, {"--seeds", "3x"},
      {"--seeds", "nan"}, {"--rate", "0.05"}, {"--depth", "3"},   {"one", "two"},
      {"--out"},          {"--seeds", "1e99"}};
  for (const auto& words : bad) EXPECT_EQ(read(words).status, 2);
}

}  // namespace
}  // namespace watersky::study
