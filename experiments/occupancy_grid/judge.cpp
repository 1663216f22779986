// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "study.hpp"
#include "watersky/ice/accuracy.hpp"
#include "watersky/sim/laboratory.hpp"

namespace watersky::study {

namespace {

/// Of mapped to true area, and its inverse.
constexpr double kMostOfArea = 3.0;

}  // namespace

int Score::found() const {
  return static_cast<int>(
      std::count_if(patches.begin(), patches.end(), [](const PatchFinding& p) { return p.found; }));
}

double Score::patch_rms_m() const {
  double sum = 0.0;
  for (const PatchFinding& patch : patches)
    if (patch.found) sum += patch.error_m.squaredNorm();
  return found() == 0 ? std::nan("") : std::sqrt(sum / found());
}

Score judge(const RoomMap& map, const sim::Sea& sea, const Datum& datum) {
  Score score;
  const cv::Mat share = sim::ice_fraction(
      sea, map.probability.size(), [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
        return map.grid(p).array() + 0.5;  // ice_fraction counts from a cell's corner
      });
  score.iou = ice::compare(map.probability, share).iou;
  const std::vector<ice::IceObject> pieces =
      ice::find_objects({.probability = map.probability, .looks = {}, .last_seen_s = {}}, kCell_m);

  struct Pair {
    double distance_m;
    std::size_t patch, piece;
    Eigen::Vector2d error_m;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < sea.objects().size(); ++i) {
    const sim::IceObject& patch = sea.objects()[i];
    score.patches.push_back({.number = sim::kPaperPatches[i].number});
    const Eigen::Vector2d place = room_from_scene(datum, patch.centre_north_east_m);
    const auto grid = [&](const Eigen::Vector2d& off) {
      return map.grid(scene_from_room(datum, place.x() + off.x(), place.y() + off.y()));
    };
    Eigen::Matrix2d cells_per_m;
    cells_per_m << grid({1, 0}) - grid({0, 0}), grid({0, 1}) - grid({0, 0});
    for (std::size_t j = 0; j < pieces.size(); ++j) {
      const double ratio = pieces[j].area_m2 / patch.area_m2;
      const Eigen::Vector2d error_m = cells_per_m.inverse() * (pieces[j].centroid - grid({0, 0}));
      if (error_m.norm() <= patch.max_length_m && ratio <= kMostOfArea && ratio >= 1 / kMostOfArea)
        pairs.push_back({error_m.norm(), i, j, error_m});
    }
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.distance_m < b.distance_m; });
  std::vector<bool> taken(pieces.size());
  for (const Pair& pair : pairs) {
    PatchFinding& patch = score.patches[pair.patch];
    if (patch.found || taken[pair.piece]) continue;
    taken[pair.piece] = true;
    patch.found = true;
    patch.error_m = pair.error_m;
    patch.area_ratio = pieces[pair.piece].area_m2 / sea.objects()[pair.patch].area_m2;
  }
  score.spurious = static_cast<int>(std::count(taken.begin(), taken.end(), false));
  return score;
}

double ground_rms_m(const Flight& prepared, const Recording& recording,
                    const std::vector<const ImageFrame*>& frames) {
  std::map<std::string, const sim::TrueFrame*> truth;
  for (const ImageFrame* frame : frames)
    truth[frame->name] =
        &recording.truth.frames[static_cast<std::size_t>(frame - recording.flight.frames.data())];
  // The floor is World's plane z = 0: over a room the Earth's curve is below a micrometre.
  const auto on_floor = [](const Rigid3<World, Camera>& pose, const Vector<Camera>& ray) {
    const Eigen::Vector3d d = pose.rotation() * ray.v, o = pose.origin().v;
    return Eigen::Vector3d(o - o.z() / d.z() * d);
  };
  double sum = 0.0, count = 0.0;
  for (const ImageFrame& frame : prepared.frames) {
    const auto true_frame = truth.find(frame.name);
    if (true_frame == truth.end()) continue;
    const auto pose = prepared.camera_pose(frame, std::chrono::milliseconds(500));
    if (!pose) continue;
    for (const double across : {0.1, 0.3, 0.5, 0.7, 0.9})
      for (const double down : {0.1, 0.5, 0.9}) {
        const Pixel pixel{across * recording.flight.camera.width_px(),
                          down * recording.flight.camera.height_px()};
        // Each by the camera it believes in: an estimate may have corrected the lens as well.
        const auto claimed = prepared.camera.direction(pixel);
        const auto real = recording.flight.camera.direction(pixel);
        if (!claimed || !real) continue;
        sum += (on_floor(pose->world_from_camera, *claimed) -
                on_floor(true_frame->second->world_from_camera, *real))
                   .squaredNorm();
        count += 1.0;
      }
  }
  return count > 0.0 ? std::sqrt(sum / count) : std::nan("");
}

}  // namespace watersky::study
