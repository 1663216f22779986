// SPDX-License-Identifier: MIT
#include "watersky/vision/polarity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace watersky {
namespace {

/// Between floes (0.63 to 0.95 in real images of ours) and leads, gaps and ponds (0.35 to 0.62);
/// the one number here that was chosen by looking at data.
constexpr double kSolidityOfFloes = 0.66;
/// One frame's score that counts as odds of e to 1, and the most that one frame may say.
constexpr double kScorePerLogOdds = 0.03;
constexpr double kMostLogOddsPerFrame = 1.5;
/// Frames of a flight show the same sea again and again: no more than these count as independent.
constexpr double kIndependentFrames = 4.0;
constexpr double kColourLogOdds = 4.0;

/// Twice the area of the hull of points that are sorted by row, by Andrew's monotone chain on
/// the left ends and the right ends apart.
double doubled_hull_area(const std::vector<cv::Point>& lefts, const std::vector<cv::Point>& rights,
                         std::vector<cv::Point>& hull) {
  const auto cross = [](cv::Point o, cv::Point a, cv::Point b) {
    return static_cast<long>(a.x - o.x) * (b.y - o.y) - static_cast<long>(a.y - o.y) * (b.x - o.x);
  };
  double area = 0.0;
  const auto chain = [&](const std::vector<cv::Point>& points, int side) {
    hull.clear();
    for (const auto& p : points) {
      while (hull.size() >= 2 && side * cross(hull[hull.size() - 2], hull.back(), p) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    for (std::size_t i = 1; i < hull.size(); ++i)
      area += side * (static_cast<double>(hull[i - 1].x) + hull[i].x) * (hull[i].y - hull[i - 1].y);
  };
  chain(rights, 1);
  chain(lefts, -1);
  return area;
}

/// Area-weighted mean solidity of the 4-connected components of `mask`.
double mean_solidity(const cv::Mat& mask, double smallest_px) {
  cv::Mat labels, stats, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centroids, 4, CV_32S);
  // Per component and row the corners of its first and last pixel: all that a hull needs.
  struct Extents {
    std::vector<cv::Point> lefts, rights;
  };
  std::vector<Extents> extents(static_cast<std::size_t>(count));
  const auto counts_component = [&](int label) {
    return label > 0 && stats.at<int>(label, cv::CC_STAT_AREA) >= smallest_px;
  };
  for (int y = 0; y < labels.rows; ++y) {
    const int* row = labels.ptr<int>(y);
    for (int x = 0; x < labels.cols;) {
      const int label = row[x];
      const int begin = x;
      while (x < labels.cols && row[x] == label) ++x;
      if (!counts_component(label)) continue;
      auto& e = extents[static_cast<std::size_t>(label)];
      if (e.lefts.empty() || e.lefts.back().y != y + 1) {
        e.lefts.emplace_back(begin, y);
        e.lefts.emplace_back(begin, y + 1);
        e.rights.emplace_back(x, y);
        e.rights.emplace_back(x, y + 1);
      } else {
        e.rights[e.rights.size() - 2].x = x;
        e.rights.back().x = x;
      }
    }
  }
  double area = 0.0, weighted = 0.0;
  std::vector<cv::Point> hull;
  for (int label = 1; label < count; ++label) {
    if (!counts_component(label)) continue;
    const auto& e = extents[static_cast<std::size_t>(label)];
    const double a = stats.at<int>(label, cv::CC_STAT_AREA);
    area += a;
    weighted += a * a / (0.5 * doubled_hull_area(e.lefts, e.rights, hull));
  }
  return area > 0.0 ? weighted / area : kSolidityOfFloes;
}

}  // namespace

std::string polarity_note(const PolarityEstimate& polarity) {
  return std::string("Ice was taken as the ") +
         (polarity.polarity == IcePolarity::Brighter ? "brighter" : "darker") +
         " class: " + polarity.evidence +
         (polarity.confidence < kSureOfPolarity
              ? ". This is not sure; give --ice brighter or --ice darker."
              : ".");
}

ShapeEvidence shape_evidence(const cv::Mat& bright, const cv::Mat& valid) {
  cv::Mat bright_mask = bright != 0, dark_mask = bright == 0;
  if (!valid.empty()) {
    bright_mask.setTo(0, valid == 0);
    dark_mask.setTo(0, valid == 0);
  }
  const double n_bright = cv::countNonZero(bright_mask), n_dark = cv::countNonZero(dark_mask);
  ShapeEvidence evidence;
  if (n_bright + n_dark == 0.0) return evidence;
  const double smallest_px = std::max(8.0, (n_bright + n_dark) / 4000.0);
  evidence.bright_fraction = n_bright / (n_bright + n_dark);
  evidence.bright_solidity = mean_solidity(bright_mask, smallest_px);
  evidence.dark_solidity = mean_solidity(dark_mask, smallest_px);
  const double b = evidence.bright_fraction, d = 1.0 - b;
  evidence.score = (evidence.bright_solidity - kSolidityOfFloes) * d * d -
                   (evidence.dark_solidity - kSolidityOfFloes) * b * b;
  return evidence;
}

PolarityEstimate estimate_polarity(const std::vector<double>& scores, std::size_t frames,
                                   bool in_colour) {
  double mean = 0.0;
  std::size_t bright_votes = 0;
  for (const double score : scores) {
    mean += std::clamp(score / kScorePerLogOdds, -kMostLogOddsPerFrame, kMostLogOddsPerFrame);
    bright_votes += score > 0.0;
  }
  const auto n = static_cast<double>(scores.size());
  if (n > 0) mean /= n;
  const double log_odds =
      mean * std::min(n, kIndependentFrames) + (in_colour ? kColourLogOdds : 0.0);
  PolarityEstimate estimate;
  estimate.polarity = log_odds >= 0.0 ? IcePolarity::Brighter : IcePolarity::Darker;
  estimate.confidence = 1.0 / (1.0 + std::exp(-std::abs(log_odds)));
  char text[200];
  std::snprintf(text, sizeof text,
                "of %zu frames %zu with two classes were looked at; the bright one is shaped like "
                "floes in %zu, the dark one in %zu%s",
                frames, scores.size(), bright_votes, scores.size() - bright_votes,
                in_colour ? "; the images are in visible light, where ice is brighter" : "");
  estimate.evidence = text;
  return estimate;
}

}  // namespace watersky
