// SPDX-License-Identifier: MIT
#pragma once
/// What a machine has for Watersky: one finding a line, each with what to do about it.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace watersky::cli {

enum class Health {
  Ok,
  Warning,  ///< something is slower, missing or unsure; the main job can be done
  Fault     ///< `watersky map` cannot work
};

struct Finding {
  Health health = Health::Ok;
  std::string name{};    ///< dotted and never changed, for scripts: "gdal.drivers"
  std::string value{};   ///< for people, one line
  std::string remedy{};  ///< empty where nothing need be done
  nlohmann::json details = nlohmann::json::object();
};

/// Processor, instruction sets, memory, clock.
[[nodiscard]] std::vector<Finding> examine_machine();
/// Room and speed of the disk that holds `folder`; writes 32 MB there and takes them away.
[[nodiscard]] std::vector<Finding> examine_disk(const std::filesystem::path& folder);
/// GDAL's drivers, PROJ's grids, video.
[[nodiscard]] std::vector<Finding> examine_libraries();
/// OpenCL's devices, each tried in a process of its own.
[[nodiscard]] std::vector<Finding> examine_opencl(double timeout_s);

}  // namespace watersky::cli
