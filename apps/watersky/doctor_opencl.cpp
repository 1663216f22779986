// SPDX-License-Identifier: MIT
/// The doctor on OpenCL.
#include <cmath>

#include "doctor.hpp"
#include "opencl_check.hpp"

namespace watersky::cli {

namespace {

Finding about(const OpenClDevice& device) {
  Finding f{.name = "opencl", .value = device.name + " (" + device.platform + ")"};
  f.details = {{"platform", device.platform},
               {"device", device.name},
               {"version", device.version},
               {"driver", device.driver},
               {"refusal", device.refusal},
               {"agrees", device.agrees()},
               {"comparisons", nlohmann::json::array()}};
  std::string wrong;
  for (const OpenClComparison& c : device.comparisons) {
    nlohmann::json j{{"operation", c.operation}, {"bound", c.bound}, {"max_difference", nullptr}};
    char text[100];
    if (std::isnan(c.max_difference)) {
      std::snprintf(text, sizeof text, "refuses %s", c.operation.c_str());
    } else {
      j["max_difference"] = c.max_difference;
      std::snprintf(text, sizeof text, "%s off by %.3g (bound %.3g)", c.operation.c_str(),
                    c.max_difference, c.bound);
    }
    f.details["comparisons"].push_back(std::move(j));
    if (!c.agrees()) wrong += (wrong.empty() ? "" : ", ") + std::string(text);
  }
  if (device.agrees()) {
    f.value += ": computes what the processor does";
    return f;
  }
  f.health = Health::Warning;
  f.value += device.comparisons.empty() ? ": cannot be opened (" + device.refusal + ")"
                                        : ": computes wrong: " + wrong;
  f.remedy = "do not use --opencl here; another driver may do better";
  return f;
}

}  // namespace

std::vector<Finding> examine_opencl(double timeout_s) {
  const auto check = check_opencl(timeout_s);
  std::vector<Finding> findings;
  if (!check) {
    findings.push_back({.health = Health::Warning,
                        .name = "opencl",
                        .value = "not tried: " + check.error().message});
    return findings;
  }
  for (const OpenClDevice& device : check->devices) findings.push_back(about(device));
  if (!check->fault.empty())
    findings.push_back({.health = Health::Warning,
                        .name = "opencl",
                        .value = "a driver " + check->fault,
                        .remedy = "do not use --opencl here; remove the driver from "
                                  "/etc/OpenCL/vendors, or update it",
                        .details = {{"fault", check->fault}}});
  // Not a warning: nothing needs it.
  if (findings.empty())
    findings.push_back({.name = "opencl",
                        .value = "no device, and none needed (the package pocl-opencl-icd is one "
                                 "on the processor)"});
  return findings;
}

}  // namespace watersky::cli
