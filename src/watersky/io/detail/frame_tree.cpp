// SPDX-License-Identifier: MIT
#include "watersky/io/detail/frame_tree.hpp"

#include <algorithm>
#include <optional>
#include <set>

namespace watersky::detail {

namespace {

/// Between the samples around a time; nullopt outside of them.
std::optional<RigidMotion> at(const std::vector<StampedMotion>& samples, Time time) {
  const auto after = std::lower_bound(samples.begin(), samples.end(), time,
                                      [](const StampedMotion& s, Time t) { return s.time < t; });
  if (after == samples.end()) return std::nullopt;
  if (after->time == time) return after->motion;
  if (after == samples.begin()) return std::nullopt;
  const StampedMotion &a = *(after - 1), &b = *after;
  const double w =
      static_cast<double>((time - a.time).count()) / static_cast<double>((b.time - a.time).count());
  return RigidMotion{
      a.motion.rotation.slerp(w, b.motion.rotation),
      a.motion.translation_m + w * (b.motion.translation_m - a.motion.translation_m)};
}

}  // namespace

std::string plain_frame(std::string name) {
  if (!name.empty() && name.front() == '/') name.erase(0, 1);
  return name;
}

Status FrameTree::add(const std::string& parent, const std::string& child, Time time,
                      const RigidMotion& motion, bool is_static) {
  const double norm = motion.rotation.norm();
  if (!motion.translation_m.allFinite() || !(std::abs(norm - 1.0) < 1e-2))
    return Error{ErrorCode::InvalidInput,
                 "the motion from " + child + " to " + parent + " is not finite or no rotation"};
  Edge& edge = edges_[plain_frame(child)];
  edge.parent = plain_frame(parent);
  edge.is_static = is_static;
  if (is_static) edge.samples.clear();
  if (!edge.samples.empty() && time < edge.samples.back().time) ++backward_;
  edge.samples.push_back({time, {motion.rotation.normalized(), motion.translation_m}});
  return {};
}

void FrameTree::finish() {
  for (auto& [child, edge] : edges_) {
    std::vector<StampedMotion>& s = edge.samples;
    const auto earlier = [](const StampedMotion& a, const StampedMotion& b) {
      return a.time < b.time;
    };
    if (!std::is_sorted(s.begin(), s.end(), earlier)) std::stable_sort(s.begin(), s.end(), earlier);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      if (i + 1 < s.size() && s[i + 1].time == s[i].time) continue;
      s[kept++] = s[i];
    }
    s.resize(kept);
  }
}

bool FrameTree::has(const std::string& frame) const {
  return edges_.contains(frame) || std::any_of(edges_.begin(), edges_.end(), [&](const auto& e) {
           return e.second.parent == frame;
         });
}

std::string FrameTree::names() const {
  std::set<std::string> names;
  for (const auto& [child, edge] : edges_) names.insert({child, edge.parent});
  std::string out;
  for (const std::string& name : names) {
    if (out.size() > 300) return out + ", …";
    out += (out.empty() ? "" : ", ") + name;
  }
  return out.empty() ? "none" : out;
}

std::string FrameTree::only_moving() const {
  std::string found;
  for (const auto& [child, edge] : edges_) {
    if (edge.is_static || edge.samples.size() < 2) continue;
    if (!found.empty()) return "";
    found = child;
  }
  return found;
}

Result<FrameTree::Chain> FrameTree::chain(const std::string& start, const std::string& root) const {
  std::vector<const Edge*> edges;  // from the start up
  std::vector<std::string> frames{start};
  while (frames.back() != root) {
    const auto next = edges_.find(frames.back());
    if (next == edges_.end() || edges.size() > edges_.size()) break;
    edges.push_back(&next->second);
    frames.push_back(next->second.parent);
  }
  if (edges.size() > edges_.size())
    return Error{ErrorCode::InvalidInput, "the frames above " + start + " run in a circle"};
  if (!root.empty() && frames.back() != root)
    return Error{ErrorCode::NotFound, "no chain of transforms leads from " + start + " to " + root +
                                          " (it ends at " + frames.back() +
                                          "); the recording's frames are: " + names()};
  const auto moves = [](const Edge* e) { return !e->is_static && e->samples.size() > 1; };
  const auto lowest = std::find_if(edges.begin(), edges.end(), moves);
  if (lowest == edges.end())
    return Error{ErrorCode::Unsupported, "nothing between " + start + " and " + frames.back() +
                                             " moves; the recording's frames are: " + names()};
  Chain out;
  out.root = frames.back();
  const auto below = static_cast<std::size_t>(lowest - edges.begin());
  out.body = frames[below];
  for (std::size_t i = below; i-- > 0;)
    out.body_from_start = out.body_from_start * edges[i]->samples.back().motion;

  std::vector<Time> times;
  for (auto e = lowest; e != edges.end(); ++e)
    if (moves(*e))
      for (const StampedMotion& s : (*e)->samples) times.push_back(s.time);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (const Time time : times) {
    std::optional<RigidMotion> whole = RigidMotion{};
    for (std::size_t i = edges.size(); whole && i-- > below;) {
      const auto motion =
          moves(edges[i]) ? at(edges[i]->samples, time) : edges[i]->samples.back().motion;
      whole = motion ? std::optional(*whole * *motion) : std::nullopt;
    }
    if (whole) out.root_from_body.push_back({time, *whole});
  }
  if (out.root_from_body.empty())
    return Error{ErrorCode::NotFound,
                 "the transforms between " + start + " and " + out.root + " never overlap in time"};
  return out;
}

}  // namespace watersky::detail
