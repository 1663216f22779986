// SPDX-License-Identifier: MIT
#include "watersky/field/detail/grid_cut.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "watersky/field/ising.hpp"

namespace watersky::field::detail {

GridCut::GridCut(std::size_t nodes, int columns) : nodes_(nodes) {
  for (std::size_t d = 0; d < 8; ++d)
    offset_[d] = kNeighbours[d].row * columns + kNeighbours[d].column;
}

void GridCut::activate(std::int32_t node) {
  if (nodes_[node].next != kNone) return;
  if (last_ == kNone)
    first_ = node;
  else
    nodes_[last_].next = node;
  last_ = node;
  nodes_[node].next = node;
}

std::int32_t GridCut::next_active() {
  while (first_ != kNone) {
    const std::int32_t node = first_;
    first_ = nodes_[node].next == node ? kNone : nodes_[node].next;
    if (first_ == kNone) last_ = kNone;
    nodes_[node].next = kNone;
    if (nodes_[node].parent != kFree) return node;
  }
  return kNone;
}

int GridCut::grow(std::int32_t node) {
  const Node& from = nodes_[node];
  for (int d = 0; d < 8; ++d) {
    if (away(node, d, from.tree) == 0) continue;
    const std::int32_t index = node + offset_[static_cast<std::size_t>(d)];
    Node& to = nodes_[index];
    if (to.parent == kFree) {
      to.tree = from.tree;
      to.parent = static_cast<std::uint8_t>(7 - d);
      to.stamp = from.stamp;
      to.distance = from.distance + 1;
      activate(index);
    } else if (to.tree != from.tree) {
      return d;
    } else if (to.stamp <= from.stamp && to.distance > from.distance + 1) {
      to.parent = static_cast<std::uint8_t>(7 - d);  // a shorter way home
      to.stamp = from.stamp;
      to.distance = from.distance + 1;
    }
  }
  return -1;
}

void GridCut::augment(std::int32_t node, int d) {
  std::int32_t source = node, sink = node + offset_[static_cast<std::size_t>(d)];
  int from_source = d;
  if (nodes_[node].tree == Tree::Sink) {
    std::swap(source, sink);
    from_source = 7 - d;
  }
  std::int32_t flow = nodes_[source].residual[static_cast<std::size_t>(from_source)];
  for (const std::int32_t end : {source, sink}) {
    std::int32_t at = end;
    for (int up; (up = nodes_[at].parent) != kTerminal; at += offset_[static_cast<std::size_t>(up)])
      flow = std::min(flow, towards(at, up, nodes_[at].tree));
    flow = std::min(flow, std::abs(nodes_[at].terminal));
  }

  push(source, from_source, flow);
  for (const std::int32_t end : {source, sink}) {
    const Tree tree = nodes_[end].tree;
    std::int32_t at = end;
    for (int up; (up = nodes_[at].parent) != kTerminal;) {
      const std::int32_t parent = at + offset_[static_cast<std::size_t>(up)];
      push(tree == Tree::Source ? parent : at, tree == Tree::Source ? 7 - up : up, flow);
      if (towards(at, up, tree) == 0) make_orphan(at);
      at = parent;
    }
    nodes_[at].terminal += tree == Tree::Source ? -flow : flow;
    if (nodes_[at].terminal == 0) make_orphan(at);
  }
}

std::int32_t GridCut::distance_to_terminal(std::int32_t node) {
  std::int32_t length = 0;
  std::int32_t at = node;
  while (true) {
    const Node& n = nodes_[at];
    if (n.parent == kOrphan) return 0;
    if (n.stamp == time_) {
      length += n.distance;
      break;
    }
    ++length;
    if (n.parent == kTerminal) break;
    at += offset_[n.parent];
  }
  // Each node of the way knows it now, so that the next one asks less.
  std::int32_t left = length;
  for (at = node; nodes_[at].stamp != time_; at += offset_[nodes_[at].parent]) {
    nodes_[at].stamp = time_;
    nodes_[at].distance = left--;
    if (nodes_[at].parent == kTerminal) break;
  }
  return length;
}

void GridCut::adopt(std::int32_t orphan) {
  Node& node = nodes_[orphan];
  int best = -1;
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  for (int d = 0; d < 8; ++d) {
    if (towards(orphan, d, node.tree) == 0) continue;
    const std::int32_t index = orphan + offset_[static_cast<std::size_t>(d)];
    if (nodes_[index].parent == kFree || nodes_[index].tree != node.tree) continue;
    const std::int32_t distance = distance_to_terminal(index);
    if (distance == 0 || distance >= least) continue;
    least = distance;
    best = d;
  }
  if (best >= 0) {
    node.parent = static_cast<std::uint8_t>(best);
    node.stamp = time_;
    node.distance = least + 1;
    return;
  }
  node.parent = kFree;
  for (int d = 0; d < 8; ++d) {
    const std::int32_t index = orphan + offset_[static_cast<std::size_t>(d)];
    const Node& other = nodes_[index];
    if (other.parent == kFree || other.tree != node.tree) continue;
    if (towards(orphan, d, node.tree) > 0) activate(index);
    if (other.parent < 8 && index + offset_[other.parent] == orphan) make_orphan(index);
  }
}

void GridCut::adopt() {
  ++time_;
  // In order of their making; orphans made meanwhile join at the end.
  for (std::size_t i = 0; i < orphans_.size(); ++i) adopt(orphans_[i]);
  orphans_.clear();
}

void GridCut::solve() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (node.terminal == 0) continue;
    node.tree = node.terminal > 0 ? Tree::Source : Tree::Sink;
    node.parent = kTerminal;
    node.distance = 1;
    activate(static_cast<std::int32_t>(i));
  }
  for (std::int32_t node; (node = next_active()) != kNone;) {
    // The node stays while it finds ways to the other tree.
    for (int d; nodes_[node].parent != kFree && (d = grow(node)) >= 0;) {
      augment(node, d);
      adopt();
    }
  }
}

}  // namespace watersky::field::detail
