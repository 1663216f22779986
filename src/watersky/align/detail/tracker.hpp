// SPDX-License-Identifier: MIT
#pragma once
/// Places of the sea followed from frame to frame.
///
/// A place is hosted in the frame where it was chosen and is found again in each later one by the
/// window cut from the host, so that it does not creep. From frame to frame it is carried by
/// pyramidal Lucas-Kanade, or where the step is too long by registration of the two pictures.
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/align/detail/patch.hpp"
#include "watersky/registration/registration.hpp"

namespace watersky::align {

struct TrackerOptions {
  int points = 60;                   ///< followed at a time
  int longest_side_px = 1024;        ///< pictures are reduced to this
  double keyframe_interval_s = 0.2;  ///< new places are chosen this often
  /// A place hosted longer ago is hosted anew, as another place, when new ones are chosen.
  double longest_host_s = std::numeric_limits<double>::infinity();
  /// Steps longer than this share of the picture's width are left to registration.
  double long_step = 0.12;
};

/// A place seen again. Pixels of the full-size picture.
struct Sighting {
  int track = 0;
  int host = 0;  ///< the frame, as add() was told
  Eigen::Vector2d host_px, px;
  double correlation = 0.0;
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

/// One picture as the tracker wants it, with what was worked out from it.
struct TrackerPicture;

class Tracker {
 public:
  Tracker(const TrackerOptions& options, const Registrar* registrar)
      : options_(options), registrar_(registrar) {}

  struct Step {
    bool keyframe = false;
    std::vector<Sighting> sightings;  ///< of places hosted in earlier frames
    std::string lost;                 ///< why nothing could be followed into it; else empty
  };
  /// The next frame in time. `picture`: 8 or 16 bit, 1 or 3 channels, full size or reduced by
  /// `reduction` while decoding; `valid` empty or 0 where it must not be used.
  /// `map`: how a step around a host's full-size pixel becomes a step in this frame, by the poses
  /// and the lens; poses need to be right to a few degrees.
  using LocalMap = std::function<Eigen::Matrix2d(int host, const Eigen::Vector2d& host_px)>;
  /// `from_previous`: where the poses expect the previous frame's full-size pixels to be, or empty.
  [[nodiscard]] Result<Step> add(int frame, double t_s, const cv::Mat& picture, int reduction,
                                 const cv::Mat& valid,
                                 const std::optional<Eigen::Matrix3d>& from_previous,
                                 const LocalMap& map);

 private:
  struct Track {
    int id;
    int host;
    double host_s;
    Eigen::Vector2d host_px;  ///< reduced pixels
    Eigen::Vector2d px;       ///< in the latest frame
    Patch patch;
    double noise;  ///< of the host's pixels
    int misses = 0;
  };
  void follow(TrackerPicture& now, const std::optional<Eigen::Matrix3d>& expected,
              const LocalMap& map, Step& step);
  void host_anew(const TrackerPicture& now, int frame);
  void choose(const TrackerPicture& now, int frame);

  TrackerOptions options_;
  const Registrar* registrar_;
  std::shared_ptr<TrackerPicture> previous_;
  std::vector<Track> tracks_;
  int next_id_ = 0;
  std::size_t after_choice_ = 0;  ///< places there were when they were last chosen
  double last_keyframe_s_ = -1e300;
};

}  // namespace watersky::align
