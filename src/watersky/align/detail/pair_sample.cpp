// SPDX-License-Identifier: MIT
#include "watersky/align/detail/pair_sample.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "watersky/camera/sea_plane.hpp"

namespace watersky::detail {

namespace {

constexpr double kSharedBySuccessive = 0.55;
constexpr double kSharedByRevisits = 0.4;
constexpr std::size_t kMostApart = 1024;
constexpr std::size_t kHeadings = 8;

/// Frames from `i` to the farthest that still shares enough with it; 1 where none does.
std::size_t frames_apart(std::span<const PlacedFrame> posed, std::size_t i) {
  const auto shares = [&](std::size_t apart) {
    return i + apart < posed.size() &&
           overlap_share(posed[i], posed[i + apart]) >= kSharedBySuccessive;
  };
  std::size_t good = 1;
  while (good < kMostApart && shares(2 * good)) good *= 2;
  for (std::size_t step = good / 2; step > 0; step /= 2)
    if (shares(good + step)) good += step;
  return good;
}

/// Where the image's top points, in eighths of a turn.
std::size_t heading_of(const PlacedFrame& frame) {
  const Eigen::Vector3d top = frame.pose.world_from_camera.rotation() * -Eigen::Vector3d::UnitY();
  const double turns = std::atan2(top.y(), top.x()) / (2 * std::numbers::pi) + 1.0;
  return static_cast<std::size_t>(std::lround(turns * kHeadings)) % kHeadings;
}

/// `count` of them at even distances, the first and the last among them.
std::vector<std::size_t> evenly(const std::vector<std::size_t>& all, std::size_t count) {
  if (count >= all.size()) return all;
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < count; ++k)
    out.push_back(all[count == 1 ? all.size() / 2 : k * (all.size() - 1) / (count - 1)]);
  return out;
}

std::vector<std::size_t> spread_over_headings(std::span<const PlacedFrame> posed,
                                              std::size_t budget) {
  std::array<std::vector<std::size_t>, kHeadings> by_heading;
  for (std::size_t i = 0; i + 1 < posed.size(); ++i) by_heading[heading_of(posed[i])].push_back(i);
  std::array<std::size_t, kHeadings> quota{};
  for (bool gave = true; gave && budget > 0;) {
    gave = false;
    for (std::size_t h = 0; h < kHeadings && budget > 0; ++h)
      if (quota[h] < by_heading[h].size()) {
        ++quota[h], --budget;
        gave = true;
      }
  }
  std::vector<std::size_t> out;
  for (std::size_t h = 0; h < kHeadings; ++h)
    for (const std::size_t i : evenly(by_heading[h], quota[h])) out.push_back(i);
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<FrameOverlap> some_revisits(std::span<const PlacedFrame> posed,
                                        const FramePairParameters& parameters, std::size_t budget) {
  std::vector<FrameOverlap> revisits;
  for (const FrameOverlap& pair : choose_pairs(posed, parameters))
    if (!pair.consecutive && pair.share >= kSharedByRevisits) revisits.push_back(pair);
  std::vector<std::size_t> all(revisits.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::vector<FrameOverlap> out;
  for (const std::size_t i : evenly(all, budget)) out.push_back(revisits[i]);
  return out;
}

}  // namespace

std::vector<PlacedFrame> posed_frames(const Flight& flight, const FramePairParameters& parameters,
                                      std::vector<LeftOut>& left_out) {
  PlacedFrames placed = place_frames(flight, parameters);
  std::vector<bool> is_placed(flight.frames.size(), false);
  for (const PlacedFrame& frame : placed.frames) is_placed[frame.frame] = true;
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    if (is_placed[i]) continue;
    const auto pose = flight.camera_pose(flight.frames[i], seconds(parameters.max_pose_gap_s));
    if (!pose) {
      left_out.push_back({flight.frames[i].name, pose.error().message});
      continue;
    }
    placed.frames.push_back(
        {i, *pose, pose->world_from_camera * pose->sea_from_camera.inverse(), {}, 0.0});
  }
  std::stable_sort(placed.frames.begin(), placed.frames.end(),
                   [](const PlacedFrame& a, const PlacedFrame& b) {
                     return std::pair(a.pose.time, a.frame) < std::pair(b.pose.time, b.frame);
                   });
  return std::move(placed.frames);
}

Result<PairSample> sample_pairs(const Flight& flight, std::span<const PlacedFrame> posed,
                                const FramePairParameters& parameters, std::size_t budget,
                                const Progress& progress) {
  PairSample out;
  std::map<std::string, std::size_t> reasons;
  const std::vector<FrameOverlap> revisits = some_revisits(posed, parameters, budget / 3);
  std::vector<FrameOverlap> next;
  for (const std::size_t i :
       spread_over_headings(posed, budget - std::min(budget, revisits.size()))) {
    const std::size_t apart = std::min(frames_apart(posed, i), posed.size() - 1 - i);
    next.push_back({i, i + apart, 0.0, true});
  }
  const auto order = [](const FrameOverlap& x, const FrameOverlap& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  };
  next.insert(next.end(), revisits.begin(), revisits.end());
  while (!next.empty()) {
    std::sort(next.begin(), next.end(), order);
    WATERSKY_TRY(auto pairs, register_pairs(flight, posed, next, parameters, progress));
    std::vector<FrameOverlap> nearer;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      ++out.tried;
      if (pairs[k].registered()) {
        out.pairs.push_back(std::move(pairs[k]));
        continue;
      }
      ++reasons[pairs[k].reason];
      const std::size_t apart = next[k].b - next[k].a;
      if (next[k].consecutive && apart > 1)
        nearer.push_back({next[k].a, next[k].a + apart / 2, 0.0, true});
    }
    next = std::move(nearer);
  }
  std::size_t most = 0;
  for (const auto& [reason, count] : reasons)
    if (count > most) most = count, out.commonest_reason = reason;
  return out;
}

}  // namespace watersky::detail
