// SPDX-License-Identifier: MIT
/// The one binary: `watersky VERB …`.
#include <cstdio>
#include <exception>

#include "cli.hpp"
#include "watersky/base/memory.hpp"
#include "watersky/vision/opencl.hpp"

int main(int argc, char** argv) {
  watersky::keep_freed_memory();
  (void)watersky::use_opencl(false);  // drivers are not trusted before they are tried
  CLI::App app{
      "Watersky maps sea ice from a UAV while it flies.\n"
      "Angles are degrees, lengths metres, times seconds; every option names its unit.",
      "watersky"};
  app.require_subcommand(1);
  app.set_version_flag("--version", "watersky " WATERSKY_VERSION);
  app.failure_message([](const CLI::App*, const CLI::Error& e) {
    return "watersky: " + std::string(e.what()) + " (see watersky --help)\n";
  });
  app.footer("Exit status: 0 done, 1 the input or the world is at fault, 2 the call is at fault.");
  watersky::cli::add_map(app);
  watersky::cli::add_merge(app);
  watersky::cli::add_diff(app);
  watersky::cli::add_segment(app);
  watersky::cli::add_align(app);
  watersky::cli::add_register(app);
  watersky::cli::add_calibrate(app);
  watersky::cli::add_simulate(app);
  watersky::cli::add_inspect(app);
  watersky::cli::add_convert(app);
  watersky::cli::add_doctor(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::exception& e) {
    // Out of memory and the like: nothing that a Result could carry.
    std::fprintf(stderr, "watersky: %s\n", e.what());
    return 1;
  }
  return watersky::cli::exit_status();
}
