// SPDX-License-Identifier: MIT
/// Anchors, their tracks, ground control points and ranges as text.
#include <cstdint>

#include "watersky/io/known_points_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> notes;
  const auto same_name = [](const std::string& frame) { return std::optional(frame); };
  if (const auto anchors = parse_anchors_csv(text, "anchors.csv", notes)) {
    // What was read once is read again from what it is written as.
    if (!parse_anchors_csv(format_anchors_csv(*anchors, same_name), "anchors.csv", notes))
      __builtin_trap();
  }
  std::vector<Anchor> tracked;
  if (parse_anchor_tracks_csv(text, "anchor_tracks.csv", tracked, notes))
    for (const Anchor& anchor : tracked)
      if (!anchor.at(anchor.track.front().time)) __builtin_trap();
  (void)parse_gcp_list(text, "gcp_list.txt", notes);
  (void)parse_range_csv(text, "range.csv", notes);
  return 0;
}
