// SPDX-License-Identifier: MIT
#pragma once
/// What the parts of the laboratory's study share.
#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky::study {

inline constexpr double kCell_m = 0.01;

/// The thesis's laboratory; every seed draws motions, patches, clocks and mount of its own.
[[nodiscard]] sim::Scenario laboratory(int seed);

enum class Mapper { Algorithm1, IceMap };

/// One way from a recording to a map.
struct Contender {
  std::string name;   ///< as figures spell it: lab.<name>.patch_rms_mm
  std::string title;  ///< as tables and drawings spell it
  Mapper mapper = Mapper::IceMap;
  /// Gives each frame its time, the mount and the poses, as it thinks they are.
  std::function<Result<Flight>(const Flight&)> prepare;
};
/// Those of the study, the most naive first. The ones that are told the truth show what could be
/// had.
[[nodiscard]] std::vector<Contender> contenders(const sim::Truth& truth);
/// What is drawn beside Algorithm 1: the estimate, or the oracle where there is none.
[[nodiscard]] const Contender& drawn(const std::vector<Contender>& contenders);

/// P(ice) of the floor on some grid.
struct RoomMap {
  cv::Mat probability;  ///< CV_32F, NaN where never seen
  /// (column, row) of a place of the scene (north, east in metres); cell centres at whole numbers.
  std::function<Eigen::Vector2d(const Eigen::Vector2d&)> grid;
};

/// Otsu's split for every contender: white paper on a dark floor needs no more.
[[nodiscard]] Result<RoomMap> make_map(const Flight& prepared, Mapper mapper,
                                       const std::vector<const ImageFrame*>& frames);
/// Algorithm 1 alone, on masks made before.
[[nodiscard]] Result<RoomMap> run_algorithm1(const Flight& prepared,
                                             const std::vector<const ImageFrame*>& frames,
                                             const std::vector<cv::Mat>& masks);

/// The map in the room's own frame, (x, -y) along columns and rows, for drawing: CV_32F, NaN where
/// never seen.
struct RoomView {
  double x_from_m, x_to_m, y_from_m, y_to_m;  ///< of the motion capture's frame, z up
  double pixels_per_m;
  [[nodiscard]] cv::Size size() const;
  [[nodiscard]] Eigen::Vector2d pixel(double x_m, double y_m) const;
};
[[nodiscard]] cv::Mat in_room(const RoomMap& map, const Datum& datum, const RoomView& view);
/// (north, east) of the scene at a place of the motion capture's frame.
[[nodiscard]] Eigen::Vector2d scene_from_room(const Datum& datum, double x_m, double y_m);
[[nodiscard]] Eigen::Vector2d room_from_scene(const Datum& datum,
                                              const Eigen::Vector2d& north_east_m);

/// What became of one patch.
struct PatchFinding {
  int number = 0;
  bool found = false;
  Eigen::Vector2d error_m = Eigen::Vector2d::Zero();  ///< mapped less true centroid, room's x and y
  double area_ratio = 0.0;                            ///< mapped over true area
};

/// A patch is found when a connected piece of mapped ice has its centroid within the patch's own
/// length of the true centroid and an area within a factor of three; one piece a patch, the
/// nearest first.
struct Score {
  std::vector<PatchFinding> patches;
  double iou = 0.0;
  int spurious = 0;  ///< other pieces
  [[nodiscard]] int found() const;
  /// Over the patches that were found; NaN when there are none.
  [[nodiscard]] double patch_rms_m() const;
};
/// `sea`: that of the truth, or another to compare with.
[[nodiscard]] Score judge(const RoomMap& map, const sim::Sea& sea, const Datum& datum);

/// Delay, jitter and mount error from none to beyond the thesis's, each alone and all together,
/// under Algorithm 1 with the latest pose; figures lab.sweep.*, sweep.csv and sweep.png.
Status sweep(int seeds, int step, const std::filesystem::path& out);

/// A flight and its two maps, to draw.
struct DrawnFlight {
  const sim::Simulation* recording = nullptr;
  std::vector<const ImageFrame*> frames;
  RoomMap algorithm1, ours;
};
Status write_figure_4_2(const std::filesystem::path& file, const DrawnFlight& flight);
Status write_figure_4_3(const std::filesystem::path& file, const DrawnFlight& flight,
                        const Contender& algorithm1, const Contender& ours);
Status write_figure_4_4(const std::filesystem::path& file, const DrawnFlight& flight,
                        const Contender& algorithm1, const Contender& ours);
Status write_figure_4_5(const std::filesystem::path& file, const std::vector<DrawnFlight>& flights,
                        const std::string& title_of_ours);

}  // namespace watersky::study
