// SPDX-License-Identifier: MIT
/// `watersky doctor`: what this machine has, and what to do about what it has not.
#include "doctor.hpp"

#include "cli.hpp"
#include "opencl_check.hpp"

namespace watersky::cli {

namespace {

struct Options {
  std::string folder = ".";
  double opencl_timeout_s = 120.0;
  bool opencl_child = false;
};

const char* word(Health health) {
  switch (health) {
    case Health::Ok: return "ok";
    case Health::Warning: return "warning";
    case Health::Fault: return "fault";
  }
  return "fault";
}

VerbResult run(const Options& o, const Common& common) {
  if (o.opencl_child) {
    try_opencl_devices();
    return nlohmann::json();
  }
  nlohmann::json findings = nlohmann::json::array();
  std::size_t warnings = 0, faults = 0;
  const auto tell = [&](const std::vector<Finding>& found) {
    for (const Finding& f : found) {
      warnings += f.health == Health::Warning;
      faults += f.health == Health::Fault;
      char line[64];
      std::snprintf(line, sizeof line, "%-8s %-16s ", word(f.health), f.name.c_str());
      say(common, line + f.value + (f.remedy.empty() ? "" : " -> " + f.remedy));
      findings.push_back({{"name", f.name},
                          {"health", word(f.health)},
                          {"value", f.value},
                          {"remedy", f.remedy},
                          {"details", f.details}});
    }
  };
  tell(examine_machine());
  tell(examine_disk(o.folder));
  tell(examine_libraries());
  tell(examine_opencl(o.opencl_timeout_s));
  if (faults > 0) fail_in_part();
  const std::string summary =
      faults > 0     ? "watersky map cannot work here before the faults are mended."
      : warnings > 0 ? "watersky map works here; " + std::to_string(warnings) +
                           (warnings == 1 ? " warning." : " warnings.")
                     : "watersky map works here.";
  say(common, summary);
  return nlohmann::json{{"version", WATERSKY_VERSION},
                        {"works", faults == 0},
                        {"warnings", warnings},
                        {"faults", faults},
                        {"findings", std::move(findings)}};
}

}  // namespace

void add_doctor(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb =
      add_verb(app, "doctor", "Say what this machine has and lacks for Watersky, and the remedy",
               [o](const Common& common) { return run(*o, common); });
  verb.add_option("--folder", o->folder,
                  "where maps will be written: the disk that is measured, by 32 MB that are taken "
                  "away again")
      ->capture_default_str();
  verb.add_option("--opencl-timeout-s", o->opencl_timeout_s,
                  "longest wait for the OpenCL drivers, which compile their programs first [s]")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  verb.add_flag("--opencl-child", o->opencl_child)->group("");  // see opencl_check.hpp
}

}  // namespace watersky::cli
