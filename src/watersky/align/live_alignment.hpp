// SPDX-License-Identifier: MIT
#pragma once
/// Time, mount and poses of a flight while it flies: the causal form of align_flight().
///
///   WATERSKY_TRY(LiveAligner aligner, LiveAligner::make(setup, {}));
///   aligner.add_pose(pose);                        // as they come in
///   aligner.add_frame(id, stamps, picture);        // as they come in
///   for (const LiveFrame& frame : aligner.take())  // in order of capture
///     map.add(frame.aligned.pose, ...);
///
/// Each frame gets its time and pose from what came before it, at a cost that does not grow: the
/// last few seconds of keyframes are adjusted together (a sliding window); what came before them is
/// kept as one normal distribution of the mount, the delay and the oldest pose in the window.
/// Nothing is looked up that was flown over earlier, and no regular clock is looked for in the
/// images: for that there is align_flight().
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/align/alignment.hpp"

namespace watersky {

/// By how much pictures may be reduced while decoding, for add_frame(): tracking needs no more.
[[nodiscard]] int reduction_for_tracking(const CameraModel& camera);

/// When a frame was taken, or came in.
struct FrameStamps {
  std::optional<Time> captured_at;  ///< known: kept
  std::optional<Time> received_at;
  std::optional<std::uint64_t> counter;  ///< the camera's own frame count
  /// As ImageFrame's.
  std::optional<StampedPose> own_pose{};
  std::optional<Eigen::Quaterniond> own_gimbal{};
};

struct LiveFrame {
  std::size_t id = 0;  ///< as add_frame() was told
  /// Its pose, of a body on which the camera sits as `setup` says (what was found of the mount is
  /// in it), or why there is none.
  Result<AlignedFrame> aligned;
  /// Of the poses so far: AsGiven while the delay is not known, and where places that take no part
  /// agree better without.
  AlignMethod method = AlignMethod::AsGiven;
};

/// What is known by now, and what it took.
struct LiveStatus {
  bool started = false;  ///< the delay has been found, or needs not to be
  AlignMethod method = AlignMethod::AsGiven;
  PoseSigma navigation_sigma;
  double delay_s = 0.0, delay_sigma_s = 0.0;
  Mount mount;  ///< corrected
  std::vector<Estimate> estimates;
  double pixel_sigma = 0.0;  ///< of one sighting, px
  /// Of places that took no part, lately.
  TieStatistics as_given, constant_delay, after;
  Eigen::Matrix2d shared_covariance_m2 = Eigen::Matrix2d::Zero();
  std::size_t frames = 0, keyframes = 0, sightings = 0, pending = 0;
  double tracking_s = 0.0, solving_s = 0.0;  ///< CPU of one core, in all
  double longest_solve_s = 0.0;              ///< of one frame, start-up aside
  std::vector<std::string> notes;
};

class LiveAligner {
 public:
  /// `setup`: a flight of which datum, camera, mount, sea level, gimbal reference, readout and
  /// delay are used; frames and poses are to come. NotFound without a sea level; Usage as
  /// align_flight().
  [[nodiscard]] static Result<LiveAligner> make(const Flight& setup, const AlignOptions& options);
  LiveAligner(LiveAligner&&) noexcept;
  LiveAligner& operator=(LiveAligner&&) noexcept;
  ~LiveAligner();

  /// In order of time. OutOfRange otherwise; the pose is then not used.
  [[nodiscard]] Status add_pose(const StampedPose& pose);
  [[nodiscard]] Status add_gimbal(const StampedRotation& rotation);
  /// In order of time. `picture` as for ImageLoader, full size or reduced by `reduction` while
  /// decoding.
  void add_frame(std::size_t id, const FrameStamps& stamps, const cv::Mat& picture,
                 int reduction = 1);
  /// Frames whose time the poses have passed, with theirs.
  [[nodiscard]] std::vector<LiveFrame> take();
  /// No more will come: the frames that still wait, with what poses there are.
  [[nodiscard]] std::vector<LiveFrame> finish();
  [[nodiscard]] LiveStatus status() const;

 private:
  class Impl;
  explicit LiveAligner(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A recorded flight as it would have been aligned while it flew: poses and frames are given in
/// order of time (of arrival, where that is known). The estimates are those at the end; each
/// frame's pose is what was known when it came in.
[[nodiscard]] Result<Alignment> align_flight_causally(const Flight& flight,
                                                      const AlignOptions& options,
                                                      const Progress& progress = {});

}  // namespace watersky
