// SPDX-License-Identifier: MIT
#include "watersky/map/evidence.hpp"

#include <algorithm>
#include <string>

#include "watersky/map/log_odds.hpp"

namespace watersky {

EvidenceTable threshold_evidence(int threshold, double p_above, double p_below, double prior) {
  EvidenceTable table{};
  for (int level = 0; level < 256; ++level)
    table[static_cast<std::size_t>(level)] =
        static_cast<float>(log_odds(level > threshold ? p_above : p_below) - log_odds(prior));
  return table;
}

EvidenceTable probability_evidence(double prior) {
  EvidenceTable table{};
  for (int level = 0; level < 256; ++level)
    table[static_cast<std::size_t>(level)] = static_cast<float>(
        log_odds(std::clamp(level / 255.0, 1.0 / 510, 1.0 - 1.0 / 510)) - log_odds(prior));
  return table;
}

Evidence Evidence::of_levels(const cv::Mat& levels, const EvidenceTable& table,
                             const cv::Mat& valid) {
  Evidence e;
  e.image_ = levels;
  e.table_ = table;
  e.valid_ = valid;
  e.has_levels_ = true;
  return e;
}

Evidence Evidence::of_log_odds(const cv::Mat& log_odds) {
  Evidence e;
  e.image_ = log_odds;
  return e;
}

Status Evidence::check() const {
  const auto bad = [](const std::string& message) {
    return Error{ErrorCode::InvalidInput, message};
  };
  if (image_.empty()) return bad("evidence without pixels");
  if (image_.type() != (has_levels_ ? CV_8U : CV_32F))
    return bad(has_levels_ ? "levels must be CV_8U; convert the image"
                           : "log-odds must be CV_32F; convert the image");
  if (!valid_.empty() && (valid_.type() != CV_8U || valid_.size() != image_.size()))
    return bad("the mask of valid pixels must be CV_8U and of the image's size, " +
               std::to_string(image_.cols) + "x" + std::to_string(image_.rows));
  return {};
}

}  // namespace watersky
