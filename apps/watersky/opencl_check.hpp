// SPDX-License-Identifier: MIT
#pragma once
/// Whether an OpenCL driver can be trusted. Drivers hang, crash and compute wrong (section 4.4 of
/// the thesis), so they are tried in a child process: this program again, with
/// `doctor --opencl-child`, whose lines of JSON are read until a deadline.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::cli {

/// One operation on the device against the same on the processor.
struct OpenClComparison {
  std::string operation;
  double max_difference = 0.0;  ///< NaN: the device refused
  double bound = 0.0;           ///< largest difference that rounding explains
  [[nodiscard]] bool agrees() const { return max_difference <= bound; }
};

struct OpenClDevice {
  std::string platform, name, version, driver;
  std::string refusal{};  ///< why it could not be opened
  std::vector<OpenClComparison> comparisons{};
  [[nodiscard]] bool agrees() const;
};

struct OpenClCheck {
  std::vector<OpenClDevice> devices{};
  std::string fault{};  ///< how the child ended before it was done: "died of SIGSEGV while …"
};

/// Tries all devices. Io when no child can be started.
[[nodiscard]] Result<OpenClCheck> check_opencl(double timeout_s);

/// What the child does: a line of JSON before each step and for each device, on standard output.
void try_opencl_devices();

/// Turns OpenCL on for this process once the default device has proved itself: Unsupported, with
/// what is wrong and the remedy, where it has not.
[[nodiscard]] Status use_opencl_if_sound();

}  // namespace watersky::cli
