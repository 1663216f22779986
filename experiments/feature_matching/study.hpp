// SPDX-License-Identifier: MIT
#pragma once
/// What the parts of the study of feature matching share.
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "support/print_figure.hpp"
#include "support/tell.hpp"
#include "watersky/base/result.hpp"
#include "watersky/registration/registration.hpp"

namespace watersky::study {

/// Time of the processor: one thread works, and others on the machine should not count.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC;
  }

 private:
  std::clock_t start_ = std::clock();
};

[[nodiscard]] double mean(const std::vector<double>& values);
[[nodiscard]] double median(std::vector<double> values);

/// A method under study with its registrar.
struct Contender {
  RegistrationMethod method;
  std::string name;
  std::unique_ptr<Registrar> registrar;
};
/// Those that this build's OpenCV has; what it lacks is told.
[[nodiscard]] std::vector<Contender> contenders();

/// A frame of a sequence and, where it is known, the homography from the scene's plane to it.
struct SequenceFrame {
  cv::Mat image;
  std::optional<Eigen::Matrix3d> frame_from_scene;
  bool repeated = false;  ///< known to be the frame before once more
};
/// Frames one after the other; nullopt at the end.
struct Sequence {
  std::string name;  ///< as figures spell it
  std::function<Result<std::optional<SequenceFrame>>()> next;
};
/// A video, or a folder of images by name; frames wider than 1000 px are reduced to that.
[[nodiscard]] Result<Sequence> open_sequence(const std::filesystem::path& video_or_folder);

/// A thermal camera's video over real pictures, as the thesis's from Eggemoen was: little
/// contrast, frames recorded twice, motion blur, frames dropped. Its truth is known.
struct MadeVideo {
  double contrast = 0.25;  ///< of the pictures' own
  int frames = 200;
  std::uint64_t seed = 1;
};
[[nodiscard]] Sequence made_video(const std::vector<cv::Mat>& pictures, const MadeVideo& options);

/// Every image in `folder`, gray 8 bit, reduced to `width_px` where it is wider.
[[nodiscard]] Result<std::vector<cv::Mat>> read_pictures(const std::filesystem::path& folder,
                                                         int width_px);

/// A picture as seen through picture_from_view.
[[nodiscard]] cv::Mat view_of(const cv::Mat& picture, const Eigen::Matrix3d& picture_from_view,
                              cv::Size size);
/// Contrast c about the mean, a pattern common to frames, noise of its own, in 8 bit.
[[nodiscard]] cv::Mat seen_by_sensor(const cv::Mat& level, double contrast, const cv::Mat& pattern,
                                     double noise_sigma, std::uint64_t seed);
/// Pixels and columns of a sensor, levels.
[[nodiscard]] cv::Mat fixed_pattern(cv::Size size, std::uint64_t seed);

/// Table 4.2 with Figures 4.6 to 4.8 for a sequence. `thesis_duplicates`: frames are skipped by
/// the thesis's rule alone.
Status study_sequence(const Sequence& sequence, bool thesis_duplicates,
                      const std::filesystem::path& out);

/// Figure 4.6: histograms of the distances of consecutive frames.
Status write_figure_4_6(const std::filesystem::path& file, const std::vector<double>& l2_norms,
                        const std::vector<double>& hellinger);
/// Figure 4.7: matches over the sequence, gray bars where a pair was registered.
struct MethodCourse {
  std::string name;
  std::vector<std::size_t> matches;
  std::vector<bool> registered;
};
Status write_figure_4_7(const std::filesystem::path& file,
                        const std::vector<MethodCourse>& courses);

/// Known warps at 640x360; figures feature_matching.warps.*.
Status study_warps(const std::vector<std::filesystem::path>& folders, int pairs_each,
                   std::uint64_t seed);

/// Pictures that have only a few pairs in common: every pair, and its triplet.
Status study_hotrax(const std::filesystem::path& folder, const std::filesystem::path& out);
/// Consecutive drone frames: how well three homographies close around three frames.
Status study_brighton(const std::filesystem::path& folder);

}  // namespace watersky::study
