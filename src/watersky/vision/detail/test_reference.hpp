// SPDX-License-Identifier: MIT
#pragma once
/// tests/reference/local_otsu.csv: what scikit-image makes of a small image.
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace watersky::test {

/// A column of the table as an image, CV_8U.
inline cv::Mat reference(const std::string& column) {
  std::ifstream in(WATERSKY_SOURCE_DIR "/tests/reference/local_otsu.csv");
  std::string line, cell;
  const auto cells = [&] {
    std::vector<std::string> found;
    std::istringstream text(line);
    while (std::getline(text, cell, ',')) found.push_back(cell);
    return found;
  };
  if (!std::getline(in, line)) return {};
  std::map<std::string, std::size_t> place;
  for (const auto& name : cells()) place.emplace(name, place.size());
  std::vector<unsigned char> values;
  int rows = 0;
  while (std::getline(in, line)) {
    const auto found = cells();
    rows = std::stoi(found[place.at("row")]) + 1;
    values.push_back(static_cast<unsigned char>(std::stoi(found[place.at(column)])));
  }
  return cv::Mat(values, true).reshape(1, rows);
}

}  // namespace watersky::test
