// SPDX-License-Identifier: MIT
#include "cli.hpp"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <vector>

#include "opencl_check.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky::cli {

namespace {

int g_exit_status = 0;

int status_of(const Error& error) { return error.code == ErrorCode::Usage ? 2 : 1; }

}  // namespace

int exit_status() { return g_exit_status; }

void fail_in_part() { g_exit_status = 1; }

CLI::App& add_verb(CLI::App& app, const std::string& name, const std::string& description,
                   std::function<VerbResult(const Common&)> body) {
  CLI::App* verb = app.add_subcommand(name, description);
  auto common = std::make_shared<Common>();
  verb->add_flag("--json", common->json, "print the result as one JSON object on standard output");
  auto* quiet = verb->add_flag("-q,--quiet", common->quiet, "print errors only");
  verb->add_flag("-v,--verbose", common->verbose, "print every frame")->excludes(quiet);
  // A verb below another one is called by both their names.
  const std::string called = app.get_parent() ? app.get_name() + " " + name : name;
  verb->callback([verb, called, common, body = std::move(body)] {
    if (!verb->get_subcommands().empty()) return;
    const VerbResult result = body(*common);
    if (!result) {
      g_exit_status = status_of(result.error());
      if (isatty(STDERR_FILENO) != 0)
        std::fprintf(stderr, "\r\033[K");  // a progress bar may stand there
      std::fprintf(stderr, "watersky %s: %s\n", called.c_str(), result.error().message.c_str());
      if (common->json)
        std::printf("%s\n", nlohmann::json{{"error",
                                            {{"code", to_string(result.error().code)},
                                             {"message", result.error().message}}}}
                                .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)
                                .c_str());
      return;
    }
    if (common->json)
      std::printf("%s\n",
                  result->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  });
  return *verb;
}

void add_segmentation(CLI::App& verb, SegmentationChoice& choice) {
  std::vector<std::string> methods;
  for (const SegmentationMethod m : segmentation_methods()) methods.emplace_back(name_of(m));
  verb.add_option("--method", choice.method,
                  "how pixels are told to be ice; learned: a trained classifier, in three speeds")
      ->check(CLI::IsMember(methods))
      ->capture_default_str();
  verb.add_option("--model", choice.model,
                  "model of the learned methods, from 'watersky segment train'; not given: the one "
                  "that comes with Watersky");
  verb.add_option("--ice", choice.ice,
                  "ice is brighter or darker than water, or found from the images by itself")
      ->check(CLI::IsMember({"auto", "brighter", "darker"}))
      ->capture_default_str();
  verb.add_option("--pond-is", choice.pond_is,
                  "what melt ponds on floes count as: for the learned methods, and in masks")
      ->check(CLI::IsMember({"ice", "water"}))
      ->capture_default_str();
  verb.add_flag("--opencl", choice.opencl,
                "run the filters of --method edges or watershed on the OpenCL device, once it has "
                "shown that it computes what the processor does");
}

Result<IceModel> read_ice_model(const std::string& file) {
  constexpr std::size_t kMostBytes = std::size_t{16} << 20;
  WATERSKY_TRY(const std::string text, read_text(file, kMostBytes));
  return parse_ice_model(text, file);
}

Result<Segmentation> resolve(const SegmentationChoice& choice) {
  Segmentation chosen;
  WATERSKY_TRY(chosen.method, segmentation_method(choice.method));
  WATERSKY_TRY(chosen.ice, ice_polarity(choice.ice));
  chosen.ponds_are_ice = choice.pond_is == "ice";
  if (choice.opencl) {
    if (chosen.method != SegmentationMethod::Edges &&
        chosen.method != SegmentationMethod::Watershed)
      return Error{ErrorCode::Usage, "--opencl is for --method edges or watershed; --method " +
                                         choice.method + " has nothing that OpenCL could run"};
    WATERSKY_CHECK(use_opencl_if_sound());
  }
  if (choice.model.empty()) return chosen;
  if (!is_learned(chosen.method))
    return Error{ErrorCode::Usage, "--model is for the learned methods, not for --method " +
                                       choice.method + "; leave one of them out"};
  WATERSKY_TRY(IceModel model, read_ice_model(choice.model));
  chosen.model = std::make_shared<const IceModel>(std::move(model));
  return chosen;
}

Result<std::vector<std::filesystem::path>> list_inputs(const std::vector<std::string>& given) {
  std::vector<std::filesystem::path> files;
  for (const std::string& path : given) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(path, ignored)) {
      files.emplace_back(path);
      continue;
    }
    WATERSKY_TRY(const auto found, list_images(path));
    if (found.empty())
      return Error{ErrorCode::NotFound,
                   path + ": holds no image (.jpg, .png or .tif); give the folder they are in"};
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::string option_name(std::string_view parameter) {
  std::string name = "--";
  for (const char c : parameter) name += c == '_' ? '-' : c;
  return name;
}

Progress progress_bar(const Common& common) {
  if (common.quiet) return {};
  const bool terminal = isatty(STDERR_FILENO) != 0;
  auto last_stage = std::make_shared<std::string>();
  auto last_percent = std::make_shared<int>(-1);
  return [terminal, last_stage, last_percent](std::string_view stage, std::size_t done,
                                              std::size_t total) {
    const bool new_stage = *last_stage != stage;
    const int percent = total == 0 ? -1 : static_cast<int>(100 * done / total);
    if (new_stage) {
      *last_stage = stage;
      *last_percent = -1;
    }
    if (!terminal) {
      if (new_stage) std::fprintf(stderr, "%.*s …\n", static_cast<int>(stage.size()), stage.data());
      return;
    }
    if (!new_stage && percent == *last_percent) return;
    *last_percent = percent;
    constexpr int kWidth = 30;
    std::string bar(kWidth, ' ');
    for (int i = 0; i < kWidth * std::max(percent, 0) / 100; ++i)
      bar[static_cast<std::size_t>(i)] = '=';
    std::fprintf(stderr, "\r\033[K%-10.*s [%s] %zu/%zu", static_cast<int>(stage.size()),
                 stage.data(), bar.c_str(), done, total);
    if (done >= total) {
      std::fprintf(stderr, "\r\033[K");
      last_stage->clear();
    }
    std::fflush(stderr);
  };
}

void say(const Common& common, const std::string& line) {
  if (!common.quiet && !common.json) std::printf("%s\n", line.c_str());
}

void say_more(const Common& common, const std::string& line) {
  if (common.verbose) say(common, line);
}

void warn(const Common& common, const std::string& line) {
  if (!common.quiet) std::fprintf(stderr, "%s\n", line.c_str());
}

}  // namespace watersky::cli
