// SPDX-License-Identifier: MIT
#pragma once
/// What a camera does between frames: it stands still, it closes its shutter (flat-field
/// correction), its gain or level jumps. Levels are compared at the places that two frames share,
/// so that the sea's own changes are not the camera's.
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "watersky/map/grid_view.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/vision/duplicates.hpp"

namespace watersky::detail {

/// One frame's levels, averaged over some pixels, and where they lie.
struct LevelView {
  std::string file;
  Time time;
  cv::Mat level;  ///< CV_32F, a reduced image
  GridView view;  ///< with the camera of `level`
};

/// The levels of an 8 or 16 bit image of 1 or 3 channels, at an eighth of its size; empty for one
/// smaller than that.
[[nodiscard]] cv::Mat reduced_levels(const cv::Mat& image);

/// How the levels of one frame became those of another at the places that both see.
struct LevelChange {
  int places = 0;
  double before = 0.0, after = 0.0;                ///< medians
  double spread_before = 0.0, spread_after = 0.0;  ///< 10 to 90 %
  double correlation = 0.0;
};
[[nodiscard]] LevelChange level_change(const LevelView& earlier, const LevelView& later);

/// Tells frames that are worth nothing, and keeps what the camera did. Frames go in in order of
/// capture.
class FrameWatch {
 public:
  /// What of a frame is needed for that, made by any thread.
  struct Seen {
    std::optional<FrameSample> sample;
    cv::Mat level;
    int depth = 0;
  };
  [[nodiscard]] static Seen seen(const cv::Mat& image, bool duplicates, bool levels);

  /// Why the frame is to be left out; nullopt: it is not.
  [[nodiscard]] std::optional<std::string> judge(const std::string& file, Time time,
                                                 const GridView& grid, const CameraModel& camera,
                                                 const Seen& seen);
  /// All that happened; call after the last frame.
  [[nodiscard]] std::vector<SensorEvent> events();

 private:
  void end_of_still();
  [[nodiscard]] std::optional<SensorEvent> level_event(LevelView frame, int depth);

  DuplicateFilter duplicates_;
  std::string kept_file_;  ///< the last frame that was no duplicate
  Time kept_time_, still_until_;
  std::optional<LevelView> last_;
  std::vector<SensorEvent> events_;
};

/// One sentence for each kind of event.
[[nodiscard]] std::vector<std::string> notes_on(const std::vector<SensorEvent>& events);

}  // namespace watersky::detail
