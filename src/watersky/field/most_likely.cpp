// SPDX-License-Identifier: MIT
#include "watersky/field/most_likely.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "watersky/field/detail/grid_cut.hpp"

namespace watersky::field {

namespace {

constexpr double kSteps = 16777216.0;  // per log-odds

/// What is known of a cell's label in the map of least energy with the least ice.
enum class Known : std::uint8_t { Unseen, Water, Ice, Open };

/// The model in whole numbers on a grid with a border, and what needs no cut.
class Decided {
 public:
  Decided(const cv::Mat& log_odds, double coupling)
      : rows_(log_odds.rows), columns_(log_odds.cols + 2) {
    for (std::size_t d = 0; d < 8; ++d) {
      offset_[d] = kNeighbours[d].row * columns_ + kNeighbours[d].column;
      weight_[d] =
          static_cast<std::int32_t>(std::lround(kSteps * coupling * kNeighbours[d].weight));
      all_ += weight_[d];
    }
    const std::size_t nodes = static_cast<std::size_t>(rows_ + 2) * columns_;
    known_.assign(nodes, Known::Unseen);
    evidence_.assign(nodes, 0);
    for (int r = 0; r < rows_; ++r) {
      const float* l = log_odds.ptr<float>(r);
      for (int c = 0; c < log_odds.cols; ++c) {
        if (std::isnan(l[c])) continue;
        const std::int32_t i = node(r, c);
        known_[i] = Known::Open;
        // Beyond all couplings together more evidence says no more.
        const double most = static_cast<double>(all_) + 1.0;
        evidence_[i] = static_cast<std::int32_t>(
            std::lround(std::clamp(kSteps * static_cast<double>(l[c]), -most, most)));
      }
    }
    decide();
  }

  [[nodiscard]] std::int32_t node(int row, int column) const {
    return (row + 1) * columns_ + column + 1;
  }
  [[nodiscard]] std::size_t nodes() const { return known_.size(); }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] Known known(std::int32_t i) const { return known_[i]; }
  [[nodiscard]] bool open_towards(std::int32_t i, std::size_t d) const {
    return known_[i + offset_[d]] == Known::Open;
  }
  [[nodiscard]] std::int32_t weight(std::size_t d) const { return weight_[d]; }
  /// The cell's own evidence with what its decided neighbours add.
  [[nodiscard]] std::int32_t field(std::int32_t i) const {
    std::int32_t sum = evidence_[i];
    for (std::size_t d = 0; d < 8; ++d) {
      const Known other = known_[i + offset_[d]];
      sum += other == Known::Ice ? weight_[d] : other == Known::Water ? -weight_[d] : 0;
    }
    return sum;
  }

 private:
  /// Labels the cell if its open neighbours cannot change it.
  bool decide(std::int32_t i) {
    std::int32_t free = 0;
    for (std::size_t d = 0; d < 8; ++d) free += open_towards(i, d) ? weight_[d] : 0;
    const std::int32_t own = field(i);
    if (own > free)
      known_[i] = Known::Ice;
    else if (own <= -free)
      known_[i] = Known::Water;
    return known_[i] != Known::Open;
  }
  void decide() {
    std::vector<std::int32_t> again;
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < columns_ - 2; ++c) {
        if (known_[node(r, c)] != Known::Open || !decide(node(r, c))) continue;
        again.push_back(node(r, c));
        while (!again.empty()) {
          const std::int32_t i = again.back();
          again.pop_back();
          for (std::size_t d = 0; d < 8; ++d)
            if (open_towards(i, d) && decide(i + offset_[d])) again.push_back(i + offset_[d]);
        }
      }
  }

  int rows_, columns_;
  std::array<std::int32_t, 8> offset_{}, weight_{};
  std::int32_t all_ = 0;
  std::vector<Known> known_;
  std::vector<std::int32_t> evidence_;
};

}  // namespace

Result<cv::Mat> most_likely(const cv::Mat& log_odds, double coupling) {
  WATERSKY_CHECK(check_field(log_odds, coupling));
  cv::Mat labels(log_odds.size(), CV_8U, cv::Scalar(kUnseen));
  if (log_odds.empty()) return labels;
  const Decided decided(log_odds, coupling);

  detail::GridCut cut(decided.nodes(), decided.columns());
  bool any_open = false;
  for (int r = 0; r < labels.rows; ++r)
    for (int c = 0; c < labels.cols; ++c) {
      const std::int32_t i = decided.node(r, c);
      if (decided.known(i) != Known::Open) continue;
      any_open = true;
      cut.set_terminal(i, decided.field(i));
      for (std::size_t d = 0; d < 8; ++d)
        if (decided.open_towards(i, d)) cut.set_edge(i, static_cast<int>(d), decided.weight(d));
    }
  if (any_open) cut.solve();

  for (int r = 0; r < labels.rows; ++r)
    for (int c = 0; c < labels.cols; ++c) {
      const std::int32_t i = decided.node(r, c);
      const Known known = decided.known(i);
      if (known != Known::Unseen)
        labels.at<std::uint8_t>(r, c) =
            known == Known::Ice || (known == Known::Open && cut.is_source(i)) ? 1 : 0;
    }
  return labels;
}

}  // namespace watersky::field
