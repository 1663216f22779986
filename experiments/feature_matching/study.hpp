// SPDX-License-Identifier: MIT
#pragma once
/// What the parts of the study of feature matching share.
#include <Eigen/Core>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/registration/registration.hpp"

namespace watersky::study {

/// {"name":…, "value":…, "unit":…}; names are dotted and never change.
inline void print_figure(const std::string& name, double value, const char* unit = "1") {
  if (std::isfinite(value)) {
    std::printf("{\"name\": \"%s\", \"value\": %.6g, \"unit\": \"%s\"}\n", name.c_str(), value,
                unit);
  } else {
    std::printf("{\"name\": \"%s\", \"value\": null, \"unit\": \"%s\"}\n", name.c_str(), unit);
  }
  std::fflush(stdout);
}

/// To standard error and into OUT/table.txt.
[[gnu::format(printf, 1, 2)]] void tell(const char* format, ...);
[[nodiscard]] const std::string& told();

class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A method under study with its registrar.
struct Contender {
  RegistrationMethod method;
  std::string name;
  std::unique_ptr<Registrar> registrar;
};
/// Those that this build's OpenCV has; what it lacks is told.
[[nodiscard]] std::vector<Contender> contenders();

/// A frame of a sequence, where its truth is known with the homography to the one before.
struct SequenceFrame {
  cv::Mat image;
  std::optional<Eigen::Matrix3d> from_first;  ///< pixels of a plane to this frame's
};
/// Frames one after the other; nullopt at the end.
struct Sequence {
  std::string name;
  std::function<Result<std::optional<SequenceFrame>>()> next;
};
[[nodiscard]] Result<Sequence> open_sequence(const std::filesystem::path& video_or_folder);

/// A thermal camera's video over real pictures, as the thesis's from Eggemoen was: little
/// contrast, frames recorded twice, motion blur, frames dropped. Its truth is known.
struct MadeVideo {
  double contrast = 0.25;  ///< of the pictures' own
  int frames = 300;
  std::uint64_t seed = 1;
};
[[nodiscard]] Result<Sequence> made_video(const std::filesystem::path& pictures, MadeVideo options);

/// Every file in `folder`, gray 8 bit, no wider than `width_px`.
[[nodiscard]] Result<std::vector<cv::Mat>> read_pictures(const std::filesystem::path& folder,
                                                         int width_px);

/// Contrast c about the mean, a pattern common to frames, noise of its own, in 8 bit.
[[nodiscard]] cv::Mat seen_by_sensor(const cv::Mat& level, double contrast, const cv::Mat& pattern,
                                     double noise_sigma, std::uint64_t seed);
/// Pixels and columns of a sensor, levels.
[[nodiscard]] cv::Mat fixed_pattern(cv::Size size, std::uint64_t seed);

/// Table 4.2 with figures 4.6 to 4.8 for a sequence.
Status study_sequence(const std::filesystem::path& video_or_folder, const Sequence& opened,
                      const std::filesystem::path& out);

/// Known warps at 640x360; figures feature_matching.warps.*.
Status study_warps(const std::vector<std::filesystem::path>& folders, int pairs_each,
                   std::uint64_t seed);

/// Every pair and the triplet of hotrax_pack_ice; triplets of brighton_beach.
Status study_hotrax(const std::filesystem::path& folder, const std::filesystem::path& out);
Status study_brighton(const std::filesystem::path& folder);

}  // namespace watersky::study
