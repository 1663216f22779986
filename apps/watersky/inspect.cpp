// SPDX-License-Identifier: MIT
/// `watersky inspect FILE`: what a recording holds.
#include <cstdio>

#include "cli.hpp"
#include "watersky/base/time.hpp"
#include "watersky/io/inspect.hpp"

namespace watersky::cli {

namespace {

void print(const Inspection& found, const Common& common) {
  say(common, found.name + ": " + found.kind);
  for (const auto& [what, value] : found.facts) say(common, "  " + what + ": " + value);
  if (found.first && found.last)
    say(common, "  from " + to_iso8601(*found.first) + " to " + to_iso8601(*found.last));
  char line[200];
  if (found.extent) {
    std::snprintf(line, sizeof line, "  between %.6f and %.6f north, %.6f and %.6f east",
                  found.extent->south_deg, found.extent->north_deg, found.extent->west_deg,
                  found.extent->east_deg);
    say(common, line);
  }
  for (const auto& [what, count] : found.counts) {
    const auto rate = found.rates_hz.find(what);
    if (rate == found.rates_hz.end()) {
      std::snprintf(line, sizeof line, "  %8zu %s", count, what.c_str());
    } else {
      std::snprintf(line, sizeof line, "  %8zu %s (%.3g a second)", count, what.c_str(),
                    rate->second);
    }
    say(common, line);
  }
  for (const std::string& note : found.notes) say(common, "  " + note);
}

}  // namespace

void add_inspect(CLI::App& app) {
  auto path = std::make_shared<std::string>();
  CLI::App& verb =
      add_verb(app, "inspect", "Say what a file or folder holds: kind, counts, times, extent",
               [path](const Common& common) -> VerbResult {
                 WATERSKY_TRY(const Inspection found, inspect(*path));
                 print(found, common);
                 return to_json(found);
               });
  verb.add_option(
          "FILE", *path,
          "a flight folder, a folder of photographs, a photograph, an autopilot log (.tlog, "
          ".bin, .lsf, .lsf.gz), an MCAP file, a ROS 1 bag or a map (.wsmap)")
      ->required();
}

}  // namespace watersky::cli
