// SPDX-License-Identifier: MIT
/// `watersky inspect FILE`: what a recording holds.
#include "cli.hpp"
#include "watersky/io/inspect.hpp"

namespace watersky::cli {

void add_inspect(CLI::App& app) {
  auto path = std::make_shared<std::string>();
  CLI::App& verb = add_verb(app, "inspect", "Say what a file or folder holds: kind, counts, times, extent",
                            [path](const Common& common) -> VerbResult {
                              WATERSKY_TRY(const Inspection found, inspect(*path));
                              say(common, to_text(found));
                              return to_json(found);
                            });
  verb.add_option("FILE", *path, "a flight folder, a folder of photographs, a photograph or a .tlog")->required();
}

}  // namespace watersky::cli
