// SPDX-License-Identifier: MIT
#pragma once
/// Which frames of a flight see the same sea, by their poses as given, and what their pictures say
/// about it: points that both show.
///
///   const PlacedFrames placed = place_frames(flight, parameters);
///   const auto chosen = choose_pairs(placed.frames, parameters);
///   WATERSKY_TRY(const auto pairs, register_pairs(flight, placed.frames, chosen, parameters));
///   for (const RegisteredPair& pair : pairs)
///     for (const PointPair& p : pair.points) …  // p.a in frame pair.a, p.b in frame pair.b
#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/registration/registration.hpp"

namespace watersky {

struct FramePairParameters {
  double max_pose_gap_s = 0.5;
  double min_grazing_deg = 10.0;
  double min_overlap = 0.2;
  int most_revisits = 3;
  int longer_side_px = 1000;
  int most_points = 40;
  int most_prepared = 32;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.max_pose_gap_s,
          ParameterInfo{"max_pose_gap_s", "s", "longest gap between poses that is interpolated", 0,
                        3600});
    visit(self.min_grazing_deg, ParameterInfo{"min_grazing_deg", "deg",
                                              "sea seen at a flatter angle is not used", 1, 89});
    visit(
        self.min_overlap,
        ParameterInfo{"min_overlap", "1",
                      "share of the smaller footprint that two frames must have in common", 0, 1});
    visit(self.most_revisits,
          ParameterInfo{"most_revisits", "1",
                        "overlaps with earlier frames, the one before apart, used of each frame", 0,
                        1000});
    visit(self.longer_side_px,
          ParameterInfo{"longer_side_px", "px",
                        "images are reduced until their longer side is no longer than this", 64,
                        20000});
    visit(self.most_points,
          ParameterInfo{"most_points", "1", "tie points kept of a pair", 5, 100000});
    visit(self.most_prepared,
          ParameterInfo{"most_prepared", "1", "images held ready in memory at a time", 2, 100000});
  }
};

/// A frame and the sea that it sees.
struct PlacedFrame {
  std::size_t frame = 0;  ///< its index in Flight::frames
  CameraPose pose;
  Rigid3<World, Sea> world_from_sea{Eigen::Quaterniond::Identity(), Point<World>{}};
  /// The outline of what it sees, convex, along World's first two axes.
  std::vector<Eigen::Vector2d> footprint_m;
  double gsd_m = 0.0;  ///< as SeaView's

  [[nodiscard]] double height_m() const { return -pose.sea_from_camera.origin().v.z(); }
};

struct PlacedFrames {
  std::vector<PlacedFrame> frames;  ///< in order of time
  std::vector<LeftOut> left_out;    ///< without a pose, or without a sight of the sea
};

/// Places those of `which` (indices into Flight::frames; empty: all) that can be placed.
[[nodiscard]] PlacedFrames place_frames(const Flight& flight,
                                        const FramePairParameters& parameters = {},
                                        std::span<const std::size_t> which = {});

/// Two frames, as indices into the placed frames, `a` the earlier.
struct FrameOverlap {
  std::size_t a = 0, b = 0;
  double share = 0.0;  ///< of the smaller footprint, by the poses
  bool consecutive = false;
};

/// What two frames have in common of the sea, of the smaller footprint.
[[nodiscard]] double overlap_share(const PlacedFrame& a, const PlacedFrame& b);

/// Each frame with the one before, and with at most `most_revisits` earlier ones, spread over how
/// long ago that was: of 2 to 3 frames ago the best, of 4 to 7, of 8 to 15 and so on, the longest
/// ago first. Only pairs that overlap by `min_overlap`, ordered by `a`, then `b`. A grid of
/// footprints' boxes finds them: work grows with the frames and how many of them see one place.
[[nodiscard]] std::vector<FrameOverlap> choose_pairs(std::span<const PlacedFrame> placed,
                                                     const FramePairParameters& parameters = {});

/// The homography that takes pixels of A to pixels of B by the plane of the sea, through the lens
/// both ways: the one that fits best where both see the sea above the grazing limit (a lens that
/// distorts makes it no homography exactly). nullopt where that is hardly any place.
[[nodiscard]] std::optional<Eigen::Matrix3d> predicted_homography(const CameraModel& camera,
                                                                  const PlacedFrame& a,
                                                                  const PlacedFrame& b,
                                                                  Angle min_grazing);

/// What came of a pair. Pixels are those of the full images, as `flight.camera` describes them.
struct RegisteredPair {
  std::size_t a = 0, b = 0;  ///< indices into Flight::frames
  bool consecutive = false;
  double predicted_share = 0.0;
  std::vector<PointPair> points;     ///< at most `most_points`, spread as widely as they come
  std::optional<HomographyFit> fit;  ///< its inliers are all that `points` were chosen from
  std::string reason;                ///< without a fit: why, in a clause
  std::string_view start;            ///< "given": by the poses; "correlation", "features": without

  [[nodiscard]] bool registered() const { return fit.has_value(); }
};

/// Registers pairs in the order given. An image is loaded and prepared once where its pairs come
/// before `most_prepared` others were needed, as in the order of choose_pairs(); an image that
/// cannot be loaded is a reason, not an error.
[[nodiscard]] Result<std::vector<RegisteredPair>> register_pairs(
    const Flight& flight, std::span<const PlacedFrame> placed, std::span<const FrameOverlap> pairs,
    const FramePairParameters& parameters = {}, const Progress& progress = {});

}  // namespace watersky
