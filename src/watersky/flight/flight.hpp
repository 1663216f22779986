// SPDX-License-Identifier: MIT
#pragma once
/// What was seen, from where, when: the one form that every recording is read into and that the
/// map is made from.
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"
#include "watersky/camera/camera_model.hpp"
#include "watersky/camera/sea_plane.hpp"
#include "watersky/flight/known_points.hpp"
#include "watersky/flight/trajectory.hpp"
#include "watersky/geodesy/wgs84.hpp"

namespace watersky {

/// How an image is wanted.
struct ImageRequest {
  bool color = true;  ///< BGR when the file has colour; otherwise, and when false, one channel
  /// Reduced by 1, 2, 4 or 8 while decoding, where the file format can; otherwise full size.
  /// Each pixel is then the mean of a whole block: its camera is `camera.reduced_by(reduction)`.
  int reduction = 1;
};

/// Loads one frame's pixels, 8 or 16 bit, 1 or 3 channels, in the orientation in which they
/// were stored (EXIF orientation is not applied: the lens and the mount speak of stored pixels).
using ImageLoader = std::function<Result<cv::Mat>(const ImageRequest&)>;

/// An image as a file of its own would hold it.
struct EncodedImage {
  std::vector<std::uint8_t> bytes;
  std::string extension;  ///< ".jpg", ".png"
};

/// One image, not necessarily decoded.
struct ImageFrame {
  std::string name;  ///< as reports show it: "DJI_0018.JPG", "video.mp4#120"
  std::optional<Time> captured_at;
  std::optional<Time> received_at;
  std::optional<std::uint64_t> counter;  ///< the camera's own frame count
  ImageLoader load;
  /// The body's pose as recorded with this very frame (EXIF, CAMERA_FEEDBACK); then no
  /// interpolation is needed.
  std::optional<StampedPose> own_pose;
  /// The gimbal's rotation as recorded with this very frame, see Flight::gimbal_reference.
  std::optional<Eigen::Quaterniond> own_gimbal;
  /// The image file that `load` reads, where it is one of its own: it can be copied as it is.
  /// Empty: of a video, or made in memory.
  std::filesystem::path file{};
  /// The same for one that lies in a recording as a file would hold it. Not set: there is none.
  std::function<Result<EncodedImage>()> encoded{};
};

/// A frame that could not be used, and why.
struct LeftOut {
  std::string file;
  std::string reason;
};

/// How the camera sits: on the body or, when a gimbal's attitude is recorded, on the gimbal.
struct Mount {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< platform_from_camera
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();  ///< the camera's position in its axes
  double sigma_rad = 0.0;                                 ///< one sigma of each angle; 0: not known
  bool assumed = false;                                   ///< nobody gave it
};

/// Where the sea surface is. Never guessed: a flight without one cannot be mapped.
struct SeaLevel {
  /// The height of the sea above the ellipsoid at a place.
  std::function<Result<double>(const Geodetic&)> height_ellipsoid_m;
  std::string description;  ///< "40 m below take-off (143.2 m above the ellipsoid)"
  double sigma_m = 0.0;     ///< 0: not known
};

/// A pose of the camera over the sea at one frame's time.
struct CameraPose {
  Time time;
  Rigid3<World, Camera> world_from_camera;
  Geodetic camera;                      ///< the camera's position
  Geodetic sea_below;                   ///< the point of the sea under it
  Rigid3<Sea, Camera> sea_from_camera;  ///< in the tangent plane of the sea at sea_below
  std::optional<PoseSigma> sigma;
  /// Of the camera along Sea's axes: position [m], then a rotation vector [rad]; with what is known
  /// of the mount's and the sea level's sigmas. Without it nothing is known of any.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance{};
  /// Its motion, where the shutter rolls and poses around the frame's time tell it.
  RollingShutter shutter{};
};

struct Flight {
  Flight(std::string flight_name, const Datum& world_datum, CameraModel model)
      : name(std::move(flight_name)), datum(world_datum), camera(std::move(model)) {}

  std::string name;
  Datum datum;
  CameraModel camera;  ///< one camera a flight
  CalibrationSource calibration;
  Mount mount;
  std::optional<GimbalReference> gimbal_reference;  ///< set when gimbal attitude is recorded
  RotationTrack gimbal;
  std::vector<ImageFrame> frames;
  Trajectory trajectory;
  std::optional<SeaLevel> sea_level;
  std::vector<Anchor> anchors;
  std::vector<RangeSample> ranges;  ///< by rising time
  bool times_are_utc = true;        ///< false: a clock of unknown time zone; only differences count
  double readout_s = 0.0;           ///< rolling shutter, first row to last
  std::optional<double> delay_s;    ///< received minus captured, where captured is not known
  /// Of the offset on the sea (north, east, m²) that all frames share, when their poses'
  /// covariances say only how they err against each other. Zero: not known.
  Eigen::Matrix2d shared_covariance_m2 = Eigen::Matrix2d::Zero();
  std::vector<LeftOut> left_out;   ///< frames already left out by the reader
  std::vector<std::string> notes;  ///< what was assumed or noticed, one sentence each

  /// When a frame was captured: its own time, or its arrival less the delay. OutOfRange when
  /// neither is known: time is never guessed.
  [[nodiscard]] Result<Time> capture_time(const ImageFrame& frame) const;

  /// Where the camera was at a frame, and the sea under it. Fails, with the reason to report,
  /// when no poses bracket the frame within `max_gap`, or there is no sea level.
  [[nodiscard]] Result<CameraPose> camera_pose(const ImageFrame& frame, Duration max_gap) const;

 private:
  /// The camera with the body at a pose; `own`: of the frame itself, or as recorded at that time.
  [[nodiscard]] Result<Rigid3<World, Camera>> camera_at(
      const StampedPose& pose, const std::optional<Eigen::Quaterniond>& own_gimbal,
      Duration max_gap) const;
};

}  // namespace watersky
