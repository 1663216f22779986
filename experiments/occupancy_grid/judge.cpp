// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace watersky::study
