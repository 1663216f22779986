// SPDX-License-Identifier: MIT
#pragma once
/// Chosen frames of a video, decoded by ffmpeg.
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>

#include "watersky/io/detail/child_process.hpp"
#include "watersky/io/video.hpp"

namespace watersky::detail {

/// The rule by which frames are chosen, the same for us and for ffmpeg's filter expression: the
/// first of each run of `interval_ticks`.
struct FrameChoice {
  std::int64_t first_pts = 0;
  double interval_ticks = 0.0;  ///< 0: every frame

  /// Half a tick forgives what an interval that is no whole number of ticks is off.
  [[nodiscard]] double run_of(std::int64_t pts) const;
  /// For the filter `select`, of frames from `from_pts` on.
  [[nodiscard]] std::string expression(std::int64_t from_pts) const;
};

[[nodiscard]] FrameChoice frame_choice(const VideoInfo& info, double interval_s);

class VideoDecoder {
 public:
  /// `chosen` as choose_video_frames() says for `choice`.
  VideoDecoder(VideoInfo info, FrameChoice choice, std::vector<std::size_t> chosen)
      : info_(std::move(info)), choice_(choice), chosen_(std::move(chosen)) {}

  /// The k-th of the chosen frames. Safe for several threads, which wait for each other.
  [[nodiscard]] Result<cv::Mat> load(std::size_t k, const ImageRequest& request);

 private:
  /// The form in which pixels are wanted.
  struct Form {
    bool color = true;
    int reduction = 1;
    friend bool operator==(const Form&, const Form&) = default;
  };
  /// What ffmpeg says about a frame that it is about to write.
  struct Announced {
    std::int64_t pts = 0;
    bool sound = false;
  };
  /// One ffmpeg process, and where it is.
  struct Stream {
    Stream(const Form& wanted, ChildProcess started, std::size_t first, bool seeks)
        : form(wanted), process(std::move(started)), next(first), sought(seeks) {}
    Form form;
    ChildProcess process;
    std::size_t next = 0;  ///< no chosen frame before this will come
    bool sought = false;   ///< it does not begin at the video's start
    bool ended = false;
    /// Decoding has gone well since a key frame: the pixels are those that were filmed.
    bool sound = false;
    std::optional<std::size_t> previous;   ///< the last frame that was decoded
    std::optional<std::size_t> begins_at;  ///< the first sound frame
    std::size_t suspect = 0;               ///< so many of the next frames may be the damaged one
    std::deque<Announced> decoded;         ///< the last few, chosen or not
    std::deque<Announced> announced;       ///< chosen, their pixels not read yet
    std::string complaint;                 ///< the last line that is about no frame
  };
  struct Kept {
    std::size_t k = 0;
    Form form;
    cv::Mat image;
  };

  [[nodiscard]] Result<Stream*> stream_at(std::size_t k, const Form& form);
  [[nodiscard]] Result<Stream*> open(std::size_t k, const Form& form, int attempt);
  [[nodiscard]] Status advance(Stream& stream, std::size_t k);
  void note(Stream& stream, std::string_view line) const;
  [[nodiscard]] std::optional<std::size_t> frame_with(std::int64_t pts) const;
  [[nodiscard]] bool key_between(std::size_t after, std::size_t upto) const;
  void keep(std::size_t k, const Form& form, cv::Mat image);
  [[nodiscard]] cv::Mat kept(std::size_t k, const Form& form) const;
  [[nodiscard]] std::string name(std::size_t k) const;
  void fail(std::size_t k, const Stream& stream, const std::string& what);
  void close(const Stream* stream);

  const VideoInfo info_;
  const FrameChoice choice_;
  const std::vector<std::size_t> chosen_;
  std::mutex mutex_;
  std::list<Stream> streams_;  ///< the last used first
  std::deque<Kept> kept_;
  std::map<std::size_t, std::string> failed_;  ///< chosen frames that cannot be had, and why
};

}  // namespace watersky::detail
