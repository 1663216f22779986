// SPDX-License-Identifier: MIT
#pragma once
/// The tree of frames that /tf and /tf_static describe.
#include <map>
#include <string>
#include <vector>

#include "watersky/base/result.hpp"
#include "watersky/base/time.hpp"

#include <Eigen/Geometry>

namespace watersky::detail {

/// parent_from_child, whatever the frames are.
struct RigidMotion {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  [[nodiscard]] RigidMotion operator*(const RigidMotion& inner) const {
    return {(rotation * inner.rotation).normalized(),
            rotation * inner.translation_m + translation_m};
  }
};

struct StampedMotion {
  Time time;
  RigidMotion motion;
};

class FrameTree {
 public:
  /// InvalidInput for a motion that is not finite or no rotation. Leading slashes of names are cut.
  [[nodiscard]] Status add(const std::string& parent, const std::string& child, Time time,
                           const RigidMotion& motion, bool is_static);
  /// To be called when all is added: sorts by time, of equal times the last stays.
  void finish();

  [[nodiscard]] bool empty() const { return edges_.empty(); }
  [[nodiscard]] bool has(const std::string& frame) const;
  /// Every frame, for messages.
  [[nodiscard]] std::string names() const;
  /// How often time ran backwards in what was added.
  [[nodiscard]] std::size_t backward_steps() const { return backward_; }
  /// The only frame that moves against its parent; empty when there are several or none.
  [[nodiscard]] std::string only_moving() const;

  struct Chain {
    std::string root, body;  ///< body: the nearest frame to the start that moves, or the start
    std::vector<StampedMotion> root_from_body;  ///< by strictly rising time
    RigidMotion body_from_start;                ///< of the static frames below it
  };
  /// From `start` up to `root` (empty: as far as it goes), sampled wherever one of its motions is,
  /// the others interpolated and never extrapolated. NotFound, naming the frames there are, when
  /// they are not connected, Unsupported when nothing between them moves.
  [[nodiscard]] Result<Chain> chain(const std::string& start, const std::string& root) const;

 private:
  struct Edge {
    std::string parent;
    bool is_static = false;
    std::vector<StampedMotion> samples;
  };
  std::map<std::string, Edge> edges_;  ///< by child
  std::size_t backward_ = 0;
};

/// "/map" → "map".
[[nodiscard]] std::string plain_frame(std::string name);

}  // namespace watersky::detail
