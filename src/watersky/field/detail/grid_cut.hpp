// SPDX-License-Identifier: MIT
#pragma once
/// Minimum cut of a grid with eight neighbours, in whole numbers: the least source side.
///
/// Why not what there is. Debian's libmaxflow is under the GPL. OpenCV's cv::detail::GCGraph
/// (grabCut's) tells the side of a node that neither tree reaches by where it was last, which need
/// not be a minimum cut. Boost's boykov_kolmogorov_max_flow finds the same energy with 830 bytes a
/// cell instead of 57, and takes five times as long or more (experiments/smoothing).
#include <array>
#include <cstdint>
#include <vector>

namespace watersky::field::detail {

/// Nodes are the cells of a grid; a border of nodes without edges must surround it.
class GridCut {
 public:
  /// `columns`: of the grid with its border.
  GridCut(std::size_t nodes, int columns);

  /// What flows into the node from the source (positive) or out of it to the sink (negative).
  void set_terminal(std::int32_t node, std::int32_t capacity) { nodes_[node].terminal = capacity; }
  /// Capacity towards neighbour `d` of kNeighbours; the other direction is set from its own end.
  void set_edge(std::int32_t node, int d, std::int32_t capacity) {
    nodes_[node].residual[static_cast<std::size_t>(d)] = capacity;
  }

  void solve();
  /// After solve(): whether the node is on the source's side of the minimum cut whose source side
  /// is least.
  [[nodiscard]] bool is_source(std::int32_t node) const {
    return nodes_[node].parent != kFree && nodes_[node].tree == Tree::Source;
  }

 private:
  enum class Tree : std::uint8_t { Source, Sink };
  static constexpr std::uint8_t kTerminal = 8, kOrphan = 9, kFree = 10;  // else a direction
  static constexpr std::int32_t kNone = -1;

  struct Node {
    std::array<std::int32_t, 8> residual{};
    std::int32_t terminal = 0;  ///< what is left of it
    std::int32_t next = kNone;  ///< in the queue of active nodes; itself: the last
    std::int32_t stamp = 0;     ///< when `distance` was last known to be right
    std::int32_t distance = 0;  ///< to the terminal along the tree
    std::uint8_t parent = kFree;
    Tree tree = Tree::Source;
  };

  /// What can still flow between a node of `tree` and its neighbour d, in the tree's direction:
  /// from the node in the source's tree, to it in the sink's.
  [[nodiscard]] std::int32_t away(std::int32_t node, int d, Tree tree) const {
    return tree == Tree::Source ? nodes_[node].residual[static_cast<std::size_t>(d)]
                                : nodes_[node + offset_[static_cast<std::size_t>(d)]]
                                      .residual[static_cast<std::size_t>(7 - d)];
  }
  /// The same in the other direction.
  [[nodiscard]] std::int32_t towards(std::int32_t node, int d, Tree tree) const {
    return away(node, d, tree == Tree::Source ? Tree::Sink : Tree::Source);
  }
  void push(std::int32_t node, int d, std::int32_t flow) {
    nodes_[node].residual[static_cast<std::size_t>(d)] -= flow;
    nodes_[node + offset_[static_cast<std::size_t>(d)]].residual[static_cast<std::size_t>(7 - d)] +=
        flow;
  }
  void activate(std::int32_t node);
  [[nodiscard]] std::int32_t next_active();
  void make_orphan(std::int32_t node) {
    nodes_[node].parent = kOrphan;
    orphans_.push_back(node);
  }
  /// Grows `node`'s tree to its neighbours; the direction in which the other tree was met, or -1.
  [[nodiscard]] int grow(std::int32_t node);
  void augment(std::int32_t node, int d);
  void adopt();
  void adopt(std::int32_t orphan);
  /// Length of the way to the terminal; 0 when it ends at an orphan.
  [[nodiscard]] std::int32_t distance_to_terminal(std::int32_t node);

  std::vector<Node> nodes_;
  std::array<std::int32_t, 8> offset_{};
  std::int32_t first_ = kNone, last_ = kNone;
  std::vector<std::int32_t> orphans_;
  std::int32_t time_ = 0;
};

}  // namespace watersky::field::detail
