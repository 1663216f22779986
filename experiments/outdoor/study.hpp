// SPDX-License-Identifier: MIT
#pragma once
/// What the parts of the outdoor study share.
#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

/// One way to know where a flight's frames look.
struct Contender {
  std::string name;   ///< as figures spell it: outdoor.<name>.sharpness_m
  std::string title;  ///< as tables and drawings spell it
  /// Gives each frame its time, the mount and the poses, as it thinks they are.
  std::function<Result<Flight>(const Flight&)> prepare;
};
/// Those of the study, the most naive first. The ones that are told the truth show what could be
/// had without looking at the images.
[[nodiscard]] std::vector<Contender> contenders(const sim::Truth& truth);

/// One look at one point of the sea.
struct Look {
  std::size_t point = 0;
  /// Where the frame's claimed pose and mount put what it shows there, less where it is: along
  /// World's horizontal axes.
  Eigen::Vector2d error_m = Eigen::Vector2d::Zero();
};

/// Points on a square grid over the scene and every frame that truly shows them, but for the
/// frames in turns unless asked for: those that are not is_level().
/// Frames that the prepared flight left out are left out; `frames_left_out` counts them.
struct Looks {
  std::vector<Eigen::Vector2d> points_m;  ///< true places along World's horizontal axes
  std::vector<Look> looks;
  std::size_t frames = 0;
  std::size_t frames_left_out = 0;
};
[[nodiscard]] Looks look_at_points(const Flight& prepared, const sim::Simulation& simulation,
                                   bool turns);

/// Root mean squares of the errors' lengths, both axes together.
struct Accuracy {
  double absolute_m = 0.0;
  double shape_m = 0.0;      ///< after taking out the flight's mean error
  double sharpness_m = 0.0;  ///< of the looks at a point about their own mean
  /// After moving all so that one point, the one nearest to the middle of those seen, is on
  /// average where it is: what is left of the shape, seen from there. It is told the truth; what an
  /// anchor is good for shows the absolute error of the contender that has one.
  double anchored_m = 0.0;
};
[[nodiscard]] Accuracy judge(const Looks& looks);

/// What remains when the shape is perfect and only its place, size and direction come from the
/// navigation: the errors of a similarity fitted from the frames' true to their recorded
/// positions, as Accuracy::shape_m has them.
[[nodiscard]] double floor_m(const Looks& looks, const sim::Truth& truth);

/// The errors of all looks of one flight, a panel each contender.
struct ErrorCloud {
  std::string title;
  Looks looks;
};
Status write_error_clouds(const std::filesystem::path& file, const std::vector<ErrorCloud>& clouds);

}  // namespace watersky::study
