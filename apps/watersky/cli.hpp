// SPDX-License-Identifier: MIT
#pragma once
/// What all verbs share: levels, JSON, progress, and options made from described parameters.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/base/progress.hpp"
#include "watersky/base/result.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky::cli {

/// Options that every verb takes.
struct Common {
  bool json = false;
  bool quiet = false;
  bool verbose = false;
};

/// What a verb gives back: shown as JSON with --json; the verb has printed its own text before.
using VerbResult = Result<nlohmann::json>;

/// Adds a verb with the common options; `body` runs when it is called.
CLI::App& add_verb(CLI::App& app, const std::string& name, const std::string& description,
                   std::function<VerbResult(const Common&)> body);

/// Makes the exit status 1 although the verb has a result: a part of its input was at fault.
void fail_in_part();

/// Exit status of the verb that ran: 0 done, 1 the input or the world is at fault, 2 the call is.
[[nodiscard]] int exit_status();

/// "cell_m" → "--cell-m".
[[nodiscard]] std::string option_name(std::string_view parameter);

/// Adds an option for each described parameter: name, unit, meaning and default from its one
/// description. Those in `without` are left away.
template <class Parameters>
void add_parameters(CLI::App& app, Parameters& parameters, const std::string& group = "Parameters",
                    std::initializer_list<std::string_view> without = {}) {
  Parameters::describe(parameters, [&](auto& value, const ParameterInfo& info) {
    if (std::find(without.begin(), without.end(), info.name) != without.end()) return;
    const std::string unit = info.unit == "1" ? "" : " [" + std::string(info.unit) + "]";
    const std::string help = std::string(info.help) + unit;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, bool>) {
      const std::string name = option_name(info.name);
      app.add_flag(name + ",!--no-" + name.substr(2), value,
                   help + (value ? " (on unless --no-)" : " (off)"))
          ->group(group);
    } else {
      app.add_option(option_name(info.name), value, help)->capture_default_str()->group(group);
    }
  });
}

/// --method, --model, --ice, --pond-is and --opencl, as every verb that segments has them.
struct SegmentationChoice {
  std::string method{name_of(kDefaultSegmentationMethod)}, ice = "auto", model, pond_is = "water";
  bool opencl = false;
};
void add_segmentation(CLI::App& verb, SegmentationChoice& choice);

/// What was chosen, its model read.
struct Segmentation {
  SegmentationMethod method = kDefaultSegmentationMethod;
  IcePolarity ice = IcePolarity::Auto;
  std::shared_ptr<const IceModel> model;  ///< nullptr: the one that ships
  bool ponds_are_ice = false;
};
/// Turns OpenCL on when it was chosen; Unsupported where it cannot be trusted.
[[nodiscard]] Result<Segmentation> resolve(const SegmentationChoice& choice);

[[nodiscard]] Result<IceModel> read_ice_model(const std::string& file);

/// Files as they are, folders as the images in them. NotFound for a folder without any.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_inputs(
    const std::vector<std::string>& given);

/// Refuses NaN and infinities, which parse as numbers.
[[nodiscard]] inline CLI::Validator finite() {
  return CLI::Validator(
      [](const std::string& text) {
        double x = 0;
        return CLI::detail::lexical_cast(text, x) && std::isfinite(x)
                   ? std::string()
                   : text + " is not a finite number";
      },
      "");
}

/// A progress bar on standard error when that is a terminal; otherwise a line a stage.
[[nodiscard]] Progress progress_bar(const Common& common);

/// Text for people, on standard output; nothing with --quiet or --json.
void say(const Common& common, const std::string& line);
/// The same, only with --verbose.
void say_more(const Common& common, const std::string& line);
/// On standard error, unless --quiet.
void warn(const Common& common, const std::string& line);

void add_map(CLI::App& app);
void add_merge(CLI::App& app);
void add_diff(CLI::App& app);
void add_segment(CLI::App& app);
void add_segment_train(CLI::App& segment);
void add_register(CLI::App& app);
void add_align(CLI::App& app);
void add_calibrate(CLI::App& app);

void add_simulate(CLI::App& app);
void add_inspect(CLI::App& app);
void add_convert(CLI::App& app);
void add_doctor(CLI::App& app);

}  // namespace watersky::cli
