// SPDX-License-Identifier: MIT
#pragma once
/// Time, mount and poses of a flight from its own images: what makes the same places of the sea
/// fall together.
///
///   WATERSKY_TRY(const Alignment alignment, align_flight(flight, {}));
///   WATERSKY_TRY(const Flight corrected, aligned(flight, alignment));
///
/// Places of the sea are followed from frame to frame and found again where the flight returns.
/// One robust least-squares problem on the sea plane (detail/adjustment.hpp) then estimates the
/// delay of the images (its slow course, and each frame's own), the mount, the focal scale, and the
/// errors of the navigation, all weighted by what the residuals show. What images cannot tell
/// stays as it was given, and is named; where the result does not explain places that took no part
/// better than a constant delay or nothing at all does, that is what is returned.
///
/// Images cannot see where the flight as a whole lies. The flight's anchors and ranges can, where
/// there are any: those that agree with each other and, if only one is there, with the navigation.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"

namespace watersky {

struct AlignParameters {
  int tracked_points = 60;
  double keyframe_interval_s = 0.2;
  double align_max_pose_gap_s = 0.5;
  double max_delay_s = 0.8;
  double mount_sigma_deg = 3.0;
  double lever_arm_sigma_m = 0.1;
  double focal_sigma_percent = 0.3;
  double delay_walk_s = 0.004;
  double range_sigma_m = 0.3;
  bool revisits = true;
  bool estimate_ice_drift = false;
  bool causal = false;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.tracked_points,
          ParameterInfo{"tracked_points", "1", "places followed at a time", 8, 1000});
    visit(self.keyframe_interval_s,
          ParameterInfo{"keyframe_interval_s", "s",
                        "new places are chosen, and navigation errors estimated, this often", 0.02,
                        60});
    visit(self.align_max_pose_gap_s,
          ParameterInfo{"align_max_pose_gap_s", "s",
                        "longest gap between poses that alignment interpolates", 0, 3600});
    visit(self.max_delay_s,
          ParameterInfo{"max_delay_s", "s", "largest delay of images that is looked for", 0, 10});
    visit(self.mount_sigma_deg,
          ParameterInfo{"mount_sigma_deg", "deg",
                        "one sigma of each angle of the mount, where the flight does not say", 0,
                        45});
    visit(self.lever_arm_sigma_m,
          ParameterInfo{"lever_arm_sigma_m", "m", "one sigma of the camera's place on the body", 0,
                        10});
    visit(
        self.focal_sigma_percent,
        ParameterInfo{"focal_sigma_percent", "%",
                      "one sigma of the focal length, where the calibration does not say", 0, 20});
    visit(self.delay_walk_s,
          ParameterInfo{"delay_walk_s", "s",
                        "how far the mean delay wanders in a second (per root second)", 0, 1});
    visit(self.range_sigma_m,
          ParameterInfo{"range_sigma_m", "m",
                        "one sigma of a range finder's height above the sea: swell, freeboard of "
                        "the ice, the instrument where it does not say",
                        0.001, 100});
    visit(self.revisits,
          ParameterInfo{"revisits", "1", "look for places seen again when the flight returns"});
    visit(self.estimate_ice_drift,
          ParameterInfo{"estimate_ice_drift", "1",
                        "estimate one velocity of all ice; needs GNSS or a fixed point"});
    visit(self.causal,
          ParameterInfo{"causal", "1",
                        "each frame by what came before it alone, as it would be in flight"});
  }
};

struct AlignOptions {
  AlignParameters parameters;
  int threads = 1;
  cv::Mat camera_mask{};  ///< 0 where the camera's pictures are not to be used, full size, or empty
};

/// A quantity that was looked for.
struct Estimate {
  std::string name;  ///< "mount_roll_deg"
  std::string unit;
  double value = 0.0;
  double given = 0.0;
  double sigma = 0.0;
  double sigma_before = 0.0;
  bool observed = false;  ///< otherwise it stayed as it was given
};

/// The mean delay of the images at a moment of the flight.
struct DelaySample {
  Time received;
  double delay_s = 0.0, sigma_s = 0.0;
};

/// How far apart the frames' ideas of one place are, of places that took no part.
struct TieStatistics {
  std::size_t ties = 0;
  double median_m = 0.0, p90_m = 0.0;
  double median_px = 0.0;
};

/// What became of one anchor. Errors are where frames put it less where it is, at its height.
struct AnchorOutcome {
  std::string name;
  std::size_t sightings = 0, used = 0;
  /// Mean over the sightings that were used, north and east; root mean square of their lengths.
  Eigen::Vector2d as_given_m = Eigen::Vector2d::Zero(), after_m = Eigen::Vector2d::Zero();
  double as_given_rms_m = 0.0, after_rms_m = 0.0;
  std::string left_out;  ///< why not all of it was used; empty where it was
};

/// What became of the range finder. Errors are those of the recorded heights by it, the median.
struct RangeOutcome {
  std::size_t ranges = 0, used = 0;
  double as_given_m = 0.0, after_m = 0.0;
};

enum class AlignMethod { AsGiven, ConstantDelay, Full };

struct AlignedFrame {
  std::size_t index = 0;  ///< in Flight::frames
  Time captured;
  StampedPose pose;  ///< of the body, with sigma and covariance
  std::optional<Eigen::Quaterniond> gimbal;
  /// The body's motion, for a rolling shutter.
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();     ///< World
  Eigen::Vector3d turn_rate_rad_s = Eigen::Vector3d::Zero();  ///< World
  double delay_s = 0.0;  ///< received minus captured, where that was estimated
  std::size_t ties = 0;
};

struct Alignment {
  AlignMethod method = AlignMethod::AsGiven;
  std::string method_reason;         ///< why not more, a sentence; empty for Full
  std::vector<AlignedFrame> frames;  ///< in order of capture
  std::vector<LeftOut> left_out;
  std::vector<Estimate> estimates;
  std::vector<DelaySample> delay;
  bool delay_estimated = false;
  Mount mount;                                    ///< corrected
  double focal_scale = 1.0;                       ///< of the camera's focal lengths
  TieStatistics as_given, constant_delay, after;  ///< of places that took no part
  double pixel_sigma = 0.0;                       ///< of one sighting, from the residuals, px
  PoseSigma navigation_sigma;                     ///< of the recorded poses, from the residuals
  /// Of the offset that all frames share, which images cannot see: north, east, m².
  Eigen::Matrix2d shared_covariance_m2 = Eigen::Matrix2d::Zero();
  std::vector<AnchorOutcome> anchors;  ///< as in Flight::anchors
  RangeOutcome ranges;
  std::size_t keyframes = 0, sightings = 0, revisits = 0;
  double tracking_s = 0.0, solving_s = 0.0;  ///< CPU of one core, without decoding
  double longest_solve_s = 0.0;              ///< of one frame in flight, start-up aside
  std::vector<std::string> notes;            ///< what was assumed, found, or could not be seen
};

/// NotFound when the flight has no sea level; otherwise always an answer, AsGiven at the least.
[[nodiscard]] Result<Alignment> align_flight(const Flight& flight, const AlignOptions& options,
                                             const Progress& progress = {});

/// The flight with what was found: `captured_at` of each frame, poses at those moments (and around
/// them where the shutter rolls), the mount and the focal length. Frames without a pose are in
/// `left_out`.
[[nodiscard]] Result<Flight> aligned(const Flight& flight, const Alignment& alignment);

[[nodiscard]] std::string_view name_of(AlignMethod method);

}  // namespace watersky
