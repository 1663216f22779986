// SPDX-License-Identifier: MIT
#include "contenders.hpp"

#include <malloc.h>

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "watersky/field/ising.hpp"

namespace watersky::study {

cv::Mat mean_field(const cv::Mat& log_odds, double coupling) {
  cv::Mat p(log_odds.size(), CV_32F);
  for (int r = 0; r < p.rows; ++r)
    for (int c = 0; c < p.cols; ++c)
      p.at<float>(r, c) = 1.0F / (1.0F + std::exp(-log_odds.at<float>(r, c)));
  const auto update = [&](int r, int c) {
    double sum = static_cast<double>(log_odds.at<float>(r, c));
    if (std::isnan(sum)) return 0.0F;
    for (const field::Neighbour& n : field::kNeighbours) {
      const int row = r + n.row, column = c + n.column;
      if (row < 0 || row >= p.rows || column < 0 || column >= p.cols) continue;
      const float other = p.at<float>(row, column);
      if (!std::isnan(other)) sum += coupling * n.weight * (2.0 * static_cast<double>(other) - 1.0);
    }
    float& own = p.at<float>(r, c);
    const float step = 0.5F * (static_cast<float>(1.0 / (1.0 + std::exp(-sum))) - own);
    own += step;
    return std::abs(step);
  };
  for (int iteration = 0; iteration < 200; ++iteration) {
    float change = 0.0F;
    for (int color = 0; color < 4; ++color)
      for (int r = color / 2; r < p.rows; r += 2)
        for (int c = color % 2; c < p.cols; c += 2) change = std::max(change, update(r, c));
    if (change < 1e-3F) break;
  }
  return p;
}

BoostCut boost_cut(const cv::Mat& log_odds, double coupling) {
  using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
  struct Node {
    Traits::edge_descriptor predecessor;
    long distance = 0;
    boost::default_color_type color{};
  };
  struct Edge {
    double capacity = 0.0;
    double residual = 0.0;
    Traits::edge_descriptor reverse;
  };
  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, Node, Edge>;
  const std::size_t before = mallinfo2().uordblks + mallinfo2().hblkhd;
  const auto cells = static_cast<std::size_t>(log_odds.rows) * log_odds.cols;
  Graph graph(cells + 2);
  const auto connect = [&](std::size_t a, std::size_t b, double there, double back) {
    const auto forth = boost::add_edge(a, b, graph).first;
    const auto reverse = boost::add_edge(b, a, graph).first;
    graph[forth] = {there, there, reverse};
    graph[reverse] = {back, back, forth};
  };
  const auto at = [&](int r, int c) {
    return static_cast<std::size_t>(r) * log_odds.cols + static_cast<std::size_t>(c);
  };
  for (int r = 0; r < log_odds.rows; ++r)
    for (int c = 0; c < log_odds.cols; ++c) {
      const double l = static_cast<double>(log_odds.at<float>(r, c));
      if (std::isnan(l)) continue;
      if (l > 0.0)
        connect(cells, at(r, c), l, 0.0);
      else
        connect(at(r, c), cells + 1, -l, 0.0);
      for (std::size_t d = 4; d < 8; ++d) {
        const field::Neighbour& n = field::kNeighbours[d];
        const int row = r + n.row, column = c + n.column;
        if (row >= log_odds.rows || column < 0 || column >= log_odds.cols ||
            std::isnan(log_odds.at<float>(row, column)))
          continue;
        connect(at(r, c), at(row, column), coupling * n.weight, coupling * n.weight);
      }
    }
  const std::size_t bytes = mallinfo2().uordblks + mallinfo2().hblkhd - before;
  boost::boykov_kolmogorov_max_flow(
      graph, boost::get(&Edge::capacity, graph), boost::get(&Edge::residual, graph),
      boost::get(&Edge::reverse, graph), boost::get(&Node::predecessor, graph),
      boost::get(&Node::color, graph), boost::get(&Node::distance, graph),
      boost::get(boost::vertex_index, graph), cells, cells + 1);
  BoostCut out{cv::Mat(log_odds.size(), CV_8U, cv::Scalar(field::kUnseen)), bytes};
  const auto source = graph[cells].color;
  for (int r = 0; r < log_odds.rows; ++r)
    for (int c = 0; c < log_odds.cols; ++c)
      if (!std::isnan(log_odds.at<float>(r, c)))
        out.labels.at<std::uint8_t>(r, c) = graph[at(r, c)].color == source ? 1 : 0;
  return out;
}

}  // namespace watersky::study
