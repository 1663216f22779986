// SPDX-License-Identifier: MIT
#pragma once
/// A simulation on disk: a flight folder with its truth.
#include <filesystem>

#include "watersky/base/progress.hpp"
#include "watersky/base/result.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky {

struct WriteSimulationOptions {
  bool overwrite = false;      ///< replace an earlier simulation
  double truth_cell_m = 0.25;  ///< of truth.tif
};

/// Writes OUT as a flight folder, with truth/truth.tif (ice 1, water 0, 255 outside the scene, in
/// the projection that Projection::for_place chooses) and truth/objects.csv (id, north_m, east_m,
/// radius_m, max_length_m, isolated; positions in World). OUT appears whole or not at all; Exists
/// when it is there, unless it is an earlier simulation (it holds simulation.txt) and may be
/// overwritten: a recording is never replaced.
[[nodiscard]] Status write_simulation(const sim::Simulation& simulation,
                                      const std::filesystem::path& out,
                                      const WriteSimulationOptions& options = {},
                                      const Progress& progress = {});

/// Whether write_simulation could start; for asking before a long simulation.
[[nodiscard]] Status check_simulation_output(const std::filesystem::path& out,
                                             const WriteSimulationOptions& options);

}  // namespace watersky
