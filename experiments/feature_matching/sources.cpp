// SPDX-License-Identifier: MIT
/// Where sequences come from: a video, a folder, or pictures flown over.
#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "study.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/video.hpp"

namespace watersky::study {

namespace {

constexpr int kMostWidth_px = 1000;

cv::Mat reduced(cv::Mat image) {
  if (image.cols <= kMostWidth_px) return image;
  const double scale = static_cast<double>(kMostWidth_px) / image.cols;
  cv::resize(image, image, {}, scale, scale, cv::INTER_AREA);
  return image;
}

Sequence of_loaders(std::string name, std::vector<ImageLoader> loaders) {
  auto at = std::make_shared<std::size_t>(0);
  return {std::move(name),
          [at, loaders = std::move(loaders)]() -> Result<std::optional<SequenceFrame>> {
            if (*at == loaders.size()) return std::optional<SequenceFrame>();
            WATERSKY_TRY(cv::Mat image, loaders[(*at)++]({.color = false}));
            return std::optional(SequenceFrame{reduced(std::move(image)), std::nullopt});
          }};
}

/// The flight of a made video: one frame after the other.
class Flyover {
 public:
  Flyover(std::vector<cv::Mat> pictures, const MadeVideo& options)
      : pictures_(std::move(pictures)), options_(options), random_(options.seed) {
    pattern_ = fixed_pattern(kSize, options.seed);
    phase_ = uniform(0, 6.28);
  }

  std::optional<SequenceFrame> next() {
    if (frame_ == options_.frames) return std::nullopt;
    ++frame_;
    if (last_ && uniform(0, 1) < kRepeated) {
      SequenceFrame again = *last_;
      again.repeated = true;
      return again;
    }
    double step = 1.0;
    if (uniform(0, 1) < kDropped) step += std::floor(uniform(1, 4));  // frames that are missing
    const double from = time_;
    time_ += step;
    const bool blurred = uniform(0, 1) < kBlurred;
    cv::Mat sum(kSize, CV_32F, cv::Scalar(0));
    const int shutters = blurred ? 8 : 1;
    // The shutter is open for up to 0.7 of a frame, centred on its time.
    const double open = blurred ? 0.7 : 0.0;
    for (int i = 0; i < shutters; ++i) {
      cv::Mat part;
      const double t = time_ + open * ((i + 0.5) / shutters - 0.5);
      view_of(picture(from), scene_from_frame(t), kSize).convertTo(part, CV_32F);
      sum += part / shutters;
    }
    SequenceFrame frame;
    frame.image = seen_by_sensor(sum, options_.contrast, pattern_, 2.0, random_());
    // Another picture of the set every so often: a pair across that must not be registered.
    frame.frame_from_scene = scene_from_frame(time_).inverse();
    if (picture_index(time_) != picture_index(from) || !last_) {
      scene_ = Eigen::Matrix3d::Identity();
      scene_(0, 2) = 1e5 * static_cast<double>(picture_index(time_));
    }
    frame.frame_from_scene = *frame.frame_from_scene * scene_;
    last_ = frame;
    return frame;
  }

 private:
  static inline const cv::Size kSize{640, 360};
  static constexpr double kRepeated = 0.2, kDropped = 0.08, kBlurred = 0.3, kFramesEach = 60.0;

  [[nodiscard]] std::size_t picture_index(double t) const {
    return static_cast<std::size_t>(t / kFramesEach) % pictures_.size();
  }
  [[nodiscard]] const cv::Mat& picture(double) const { return pictures_[picture_index(time_)]; }
  /// Back and forth over the picture at up to 15 px a frame, turning by up to 20°.
  [[nodiscard]] Eigen::Matrix3d scene_from_frame(double t) const {
    const cv::Mat& scene = pictures_[picture_index(time_)];
    const double x =
        scene.cols / 2.0 + 0.3 * (scene.cols - kSize.width) * std::sin(0.05 * t + phase_);
    const double y = scene.rows / 2.0 + 0.3 * (scene.rows - kSize.height) * std::sin(0.037 * t);
    const double angle = 0.35 * std::sin(0.06 * t), zoom = 1.0 + 0.05 * std::sin(0.03 * t);
    Eigen::Matrix3d middle = Eigen::Matrix3d::Identity(), turn = middle, place = middle;
    middle(0, 2) = -(kSize.width - 1) / 2.0;
    middle(1, 2) = -(kSize.height - 1) / 2.0;
    turn.topLeftCorner<2, 2>() << zoom * std::cos(angle), -zoom * std::sin(angle),
        zoom * std::sin(angle), zoom * std::cos(angle);
    turn(2, 0) = 1.5e-5 * std::sin(0.2 * t);
    turn(2, 1) = 1.5e-5 * std::cos(0.17 * t);
    place(0, 2) = x;
    place(1, 2) = y;
    return place * turn * middle;
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random_);
  }

  std::vector<cv::Mat> pictures_;
  MadeVideo options_;
  std::mt19937_64 random_;
  cv::Mat pattern_;
  double phase_ = 0.0, time_ = 0.0;
  int frame_ = 0;
  Eigen::Matrix3d scene_ = Eigen::Matrix3d::Identity();
  std::optional<SequenceFrame> last_;
};

}  // namespace

Result<Sequence> open_sequence(const std::filesystem::path& path) {
  std::vector<ImageLoader> loaders;
  if (is_video_file(path)) {
    WATERSKY_TRY(const VideoInfo info, probe_video(path));
    for (ImageFrame& frame : video_frames(info, 0.0, Time()))
      loaders.push_back(std::move(frame.load));
  } else {
    WATERSKY_TRY(const auto files, list_images(path));
    for (const auto& file : files) loaders.push_back(image_loader(file));
  }
  if (loaders.size() < 2)
    return Error{ErrorCode::NotFound, path.string() + ": holds fewer than two images"};
  return of_loaders(path.stem().string(), std::move(loaders));
}

Sequence made_video(const std::vector<cv::Mat>& pictures, const MadeVideo& options) {
  auto flyover = std::make_shared<Flyover>(pictures, options);
  char name[60];
  std::snprintf(name, sizeof name, "made_contrast_%g", options.contrast);
  return {name, [flyover]() -> Result<std::optional<SequenceFrame>> { return flyover->next(); }};
}

}  // namespace watersky::study
