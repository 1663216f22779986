// SPDX-License-Identifier: MIT
/// The study of the thesis's section 4.3 with truth: how often features match, homographies come
/// out, and are right.
///
///   feature_matching [DATA or VIDEO or FOLDER] [OUT] [--pairs N] [--seed S] [--thesis-duplicates]
///
/// A video, or a folder of images, gives Table 4.2 for it with Figures 4.6, 4.7 and 4.8. DATA is a
/// folder that holds hotrax_pack_ice/ and brighton_beach/: known warps of their pictures under
/// falling contrast (N of each kind, 100), made thermal videos, and the pictures themselves. Frames
/// that were recorded twice are told by their pixels, or by the thesis's rule alone. OUT
/// (feature_matching_study) gets the figures and table.txt. Figures are printed one JSON object a
/// line, the tables on standard error as well.
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <string_view>

#include "study.hpp"
#include "support/real_data.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/video.hpp"

namespace fs = std::filesystem;

namespace watersky::study {

namespace {

struct Options {
  fs::path data, out = "feature_matching_study";
  int pairs = 100;
  std::uint64_t seed = 1;
  bool thesis_duplicates = false;
};

Status run(const Options& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error)
    return Error{ErrorCode::Io, options.out.string() + ": cannot be made: " + error.message()};
  const fs::path ice = options.data / "hotrax_pack_ice/images";
  const fs::path land = options.data / "brighton_beach/images";
  if (!fs::is_directory(ice) || !fs::is_directory(land)) {
    WATERSKY_TRY(const Sequence sequence, open_sequence(options.data));
    WATERSKY_CHECK(study_sequence(sequence, options.thesis_duplicates, options.out));
  } else {
    WATERSKY_CHECK(study_warps({ice, land}, options.pairs, options.seed));
    WATERSKY_TRY(const auto pictures, read_pictures(ice, 1600));
    for (const double contrast : {1.0, 0.25, 0.08})
      WATERSKY_CHECK(
          study_sequence(made_video(pictures, {.contrast = contrast, .seed = options.seed}),
                         options.thesis_duplicates, options.out));
    WATERSKY_CHECK(study_hotrax(ice, options.out));
    WATERSKY_TRY(const Sequence beach, open_sequence(land));
    WATERSKY_CHECK(
        study_sequence({"brighton_beach", beach.next}, options.thesis_duplicates, options.out));
    WATERSKY_CHECK(study_brighton(land));
  }
  return write_file(options.out / "table.txt", told());
}

}  // namespace

std::vector<Contender> contenders() {
  std::vector<Contender> found;
  static bool said = false;
  for (const RegistrationMethod method : registration_methods()) {
    auto registrar = make_registrar(method);
    if (registrar)
      found.push_back({method, std::string(name_of(method)), std::move(registrar).value()});
    else if (!said)
      tell("%s: %s\n", std::string(name_of(method)).c_str(), registrar.error().message.c_str());
  }
  said = true;
  return found;
}

}  // namespace watersky::study

int main(int argc, char** argv) {
  using namespace watersky;
  study::Options options;
  int given = 0;
  bool good = true;
  for (int i = 1; i < argc && good; ++i) {
    const std::string_view word = argv[i];
    if (word == "--thesis-duplicates") {
      options.thesis_duplicates = true;
    } else if ((word == "--pairs" || word == "--seed") && i + 1 < argc) {
      const long value = std::strtol(argv[++i], nullptr, 10);
      good = value > 0;
      (word == "--pairs") ? void(options.pairs = static_cast<int>(value))
                          : void(options.seed = static_cast<std::uint64_t>(value));
    } else if (word.starts_with("-") || given == 2) {
      good = false;
    } else {
      (given++ == 0 ? options.data : options.out) = word;
    }
  }
  if (!good) {
    std::fprintf(stderr,
                 "usage: feature_matching [DATA or VIDEO or FOLDER] [OUT] [--pairs N] [--seed S] "
                 "[--thesis-duplicates]\n");
    return argc == 2 && std::string_view(argv[1]) == "--help" ? 0 : 2;
  }
  if (options.data.empty()) options.data = test::real_data("").value_or("");
  if (options.data.empty()) {
    std::fprintf(stderr, "feature_matching: the data is not here; name a folder or a video\n");
    return 1;
  }
  cv::setNumThreads(1);
  const Status done = study::run(options);
  if (done) return 0;
  std::fprintf(stderr, "feature_matching: %s\n", done.error().message.c_str());
  return 1;
}
