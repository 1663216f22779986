// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "recording.hpp"
#include "study.hpp"
#include "watersky/sim/laboratory.hpp"

namespace watersky::study {
namespace {

/// A frame a second, exact but for what a test does to it.
sim::Simulation quiet_room() {
  sim::Scenario s = laboratory(1);
  s.camera.frame_rate_hz = 1.0;
  s.camera.drop_share = 0.0;
  s.camera.capture_recorded = true;
  s.camera.mount_error_deg = s.camera.lever_error_m = 0.0;
  s.sensor.exposure_s = s.sensor.readout_s = 0.0;
  s.sensor.supersampling = 1;
  return record(s).value();
}

/// The floor as somebody has it who takes the motion capture's x and y for World's: a mirror image.
sim::Sea mirrored_floor(const sim::Simulation& recording) {
  std::vector<sim::Outline> outlines = recording.truth.sea.pieces();
  const Datum& datum = recording.flight.datum;
  for (sim::Outline& outline : outlines)
    for (Eigen::Vector2d& corner : outline) {
      const Eigen::Vector2d p = room_from_scene(datum, corner);
      // About the middle of the patches, so that it is the layout that tells and not the place.
      corner = scene_from_room(datum, p.x(), -2.0 * sim::kPaperMiddle_m[1] - p.y());
    }
  return sim::Sea::from_outlines(std::move(outlines), {}, recording.truth.sea.extent())
      .value()
      .at(recording.truth.sea.anchor());
}

TEST(Room, BothMappersFindThePatchesOfTheTableAndNotThoseOfAMirroredRoom) {
  const sim::Simulation recording = quiet_room();
  const std::vector<const ImageFrame*> frames = every(recording.flight, 1);
  const sim::Sea mirrored = mirrored_floor(recording);
  for (const Mapper mapper : {Mapper::Algorithm1, Mapper::IceMap}) {
    const RoomMap map = make_map(recording.flight, mapper, frames).value();
    const Score right = judge(map, recording.truth.sea, recording.flight.datum);
    EXPECT_EQ(right.found(), 8);
    EXPECT_LT(right.patch_rms_m(), 0.005);
    EXPECT_GT(right.iou, 0.8);
    const Score wrong = judge(map, mirrored, recording.flight.datum);
    EXPECT_LE(wrong.found(), 4);
    EXPECT_LT(wrong.iou, 0.2);
  }
}

// The same slip in the flight: poses whose y and z were not turned over, or only one of them.
TEST(Room, PosesInAMirroredRoomFindNoPatches) {
  const sim::Simulation recording = quiet_room();
  const std::vector<const ImageFrame*> frames = every(recording.flight, 1);
  Flight mirrored = recording.flight;
  std::vector<StampedPose> poses = mirrored.trajectory.poses();
  for (StampedPose& pose : poses) {
    Eigen::Vector3d p = pose.world_from_body.origin().v;
    const Eigen::Quaterniond& q = pose.world_from_body.rotation();
    p.y() = 2.0 * sim::kPaperMiddle_m[1] - p.y();
    // Mirrored in y: turns about x and z change their sense.
    pose.world_from_body =
        Rigid3<World, Body>(Eigen::Quaterniond(q.w(), -q.x(), q.y(), -q.z()), Point<World>{p});
  }
  mirrored.trajectory = Trajectory::make(std::move(poses)).value();
  const RoomMap map = make_map(mirrored, Mapper::IceMap, frames).value();
  const Score score = judge(map, recording.truth.sea, recording.flight.datum);
  EXPECT_LE(score.found(), 2);
  EXPECT_LT(score.iou, 0.2);
}

}  // namespace
}  // namespace watersky::study
