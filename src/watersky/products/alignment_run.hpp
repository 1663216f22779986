// SPDX-License-Identifier: MIT
#pragma once
/// A flight before and after its alignment: what every product of it is made from.
#include <cstddef>
#include <string>
#include <vector>

#include "watersky/align/alignment.hpp"
#include "watersky/align/metadata_check.hpp"

namespace watersky {

struct AlignmentRun {
  Flight given;  ///< with what was certainly wrong in its metadata mended
  /// As aligned() has it; of its frames, in their order, `alignment.frames` tells.
  Flight corrected;
  Alignment alignment;
  AlignParameters parameters;
  int threads = 1;
  double wall_s = 0.0;
  MetadataCheck metadata{};  ///< of the flight as it was recorded
};

/// Checks a flight's metadata, mends what is certain, and aligns it. Where nothing could be aligned
/// the corrected flight is the given one, without the frames of which only the arrival is known
/// when no delay is: a time is never guessed. Fails as align_flight and aligned do.
[[nodiscard]] Result<AlignmentRun> run_alignment(const Flight& flight, const AlignOptions& options,
                                                 const Progress& progress = {});

/// The delay of a flight, over its course.
struct DelayFigures {
  bool estimated = false;
  double mean_s = 0.0;
  double sigma_s = 0.0;  ///< root mean square over the course: its errors hang together
  double least_s = 0.0, most_s = 0.0;
};
[[nodiscard]] DelayFigures delay_figures(const Alignment& alignment);

/// Where a frame's corrected pose lies from the recorded one at the same moment, along north, east
/// and down where the aircraft is: what was found to be wrong with the navigation.
struct PoseCorrection {
  std::size_t frame = 0;  ///< in Alignment::frames
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  /// A rotation vector; of the gimbal where its attitude is against north, east, down.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
};
/// Without the frames that have no recorded pose.
[[nodiscard]] std::vector<PoseCorrection> pose_corrections(const AlignmentRun& run);

/// Whether an anchor says where the whole flight lies.
[[nodiscard]] bool anchored(const Alignment& alignment);

/// What came of it, one sentence.
[[nodiscard]] std::string summary(const AlignmentRun& run);

/// "mount_about_optical_axis_deg" → "mount about optical axis".
[[nodiscard]] std::string spoken_name(const Estimate& estimate);
/// "1.93", to two digits of its sigma.
[[nodiscard]] std::string to_its_sigma(double value, double sigma);

}  // namespace watersky
