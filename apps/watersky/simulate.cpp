// SPDX-License-Identifier: MIT
/// `watersky simulate OUT`: a flight over a virtual sea, written as a flight folder with its truth.
#include <cmath>
#include <map>

#include "cli.hpp"
#include "watersky/io/simulation_folder.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::cli {

namespace {

struct Options {
  std::string out;
  std::string preset = "not_easy";
  bool overwrite = false;
  std::map<std::string, double> overrides;  ///< by parameter name; flags as 0 and 1
};

/// A preset's parameters with those replaced that the call names.
Result<sim::Scenario> scenario_of(const Options& o) {
  WATERSKY_TRY(sim::Scenario scenario, sim::scenario_preset(o.preset));
  Status whole;
  sim::Scenario::describe(scenario, [&](auto& value, const ParameterInfo& info) {
    const auto given = o.overrides.find(std::string(info.name));
    if (given == o.overrides.end()) return;
    const double x = given->second;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, int>) {
      if (x != std::floor(x) || std::abs(x) > 2147483647.0) {
        whole = Error{ErrorCode::Usage, std::string(info.name) + " must be a whole number, is " +
                                            nlohmann::json(x).dump()};
        return;
      }
    }
    value = static_cast<std::remove_cvref_t<decltype(value)>>(x);
  });
  WATERSKY_CHECK(whole);
  WATERSKY_CHECK(validate(scenario));
  return scenario;
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_TRY(const sim::Scenario scenario, scenario_of(o));
  const WriteSimulationOptions write{.overwrite = o.overwrite};
  WATERSKY_CHECK(check_simulation_output(o.out, write));
  const Progress progress = progress_bar(common);
  report(progress, "freezing the sea", 0, 1);
  WATERSKY_TRY(const sim::Simulation simulation, sim::simulate(scenario));
  report(progress, "freezing the sea", 1, 1);
  WATERSKY_CHECK(write_simulation(simulation, o.out, write, progress));

  nlohmann::json parameters;
  sim::Scenario::describe(scenario, [&](const auto& value, const ParameterInfo& info) {
    parameters[std::string(info.name)] = value;
  });
  const std::size_t frames = simulation.flight.frames.size();
  say(common, "Simulated " + std::to_string(frames) + " frames over " +
                  std::to_string(simulation.truth.sea.objects().size()) +
                  " pieces of ice: " + o.out);
  say(common, "Map it with: watersky map " + o.out + " -o MAP");
  return nlohmann::json{{"flight", o.out},
                        {"preset", o.preset},
                        {"frames", frames},
                        {"objects", simulation.truth.sea.objects().size()},
                        {"concentration", simulation.truth.sea.concentration()},
                        {"parameters", std::move(parameters)}};
}

}  // namespace

void add_simulate(CLI::App& app) {
  auto o = std::make_shared<Options>();
  std::vector<std::string> presets;
  for (const std::string_view name : sim::scenario_preset_names()) presets.emplace_back(name);
  CLI::App& verb = add_verb(app, "simulate",
                            "Fly over a virtual sea and write what was recorded, with the truth",
                            [o](const Common& common) { return run(*o, common); });
  verb.add_option("OUT", o->out, "flight folder to make")->required();
  verb.add_option("--preset", o->preset, "where the parameters start from")
      ->check(CLI::IsMember(presets))
      ->capture_default_str();
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is an earlier simulation");
  // Parameters are kept as overrides: their defaults are the preset's, whichever that is.
  const sim::Scenario defaults = sim::scenario_preset("not_easy").value_or({});
  sim::Scenario::describe(defaults, [&](const auto& value, const ParameterInfo& info) {
    const std::string name(info.name);
    const std::string unit = info.unit == "1" ? "" : " [" + std::string(info.unit) + "]";
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, bool>) {
      const std::string option = option_name(info.name);
      verb.add_flag_function(
              option + ",!--no-" + option.substr(2),
              [o, name](std::int64_t n) { o->overrides[name] = n > 0 ? 1 : 0; },
              std::string(info.help))
          ->group("Parameters (defaults of not_easy)");
    } else {
      verb.add_option_function<double>(
              option_name(info.name), [o, name](const double& x) { o->overrides[name] = x; },
              std::string(info.help) + unit)
          ->default_str(nlohmann::json(value).dump())
          ->group("Parameters (defaults of not_easy)");
    }
  });
}

}  // namespace watersky::cli
