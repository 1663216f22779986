// SPDX-License-Identifier: MIT
#include "watersky/align/detail/flight_edit.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>

#include "watersky/camera/reduced_image.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/geodesy/projection.hpp"

namespace watersky {

namespace {

constexpr double kFoot_m = 0.3048;
constexpr Angle kSteep = Angle::degrees(60.0);

using AttitudeEdit = std::function<Eigen::Quaterniond(const Eigen::Quaterniond&)>;

/// The angles that a person would have written: beyond straight down rather than upside down.
YawPitchRoll written_angles(const Eigen::Quaterniond& q) {
  YawPitchRoll angles = yaw_pitch_roll(q);
  const Angle half_turn = Angle::radians(std::numbers::pi);
  if (std::abs(angles.roll.degrees()) > 90.0)
    angles = {(angles.yaw + half_turn).wrapped(), half_turn - angles.pitch,
              (angles.roll + half_turn).wrapped()};
  return angles;
}

/// Where pitch is steep, yaw and roll turn about nearly one axis, and all of that turn is heading.
AttitudeEdit edit_yaw(const std::function<Angle(Angle)>& edit) {
  return [edit](const Eigen::Quaterniond& q) {
    const YawPitchRoll angles = written_angles(q);
    if (std::abs(angles.pitch.degrees()) < kSteep.degrees())
      return rotation_from({edit(angles.yaw), angles.pitch, angles.roll});
    const Angle twist = Angle::radians(2.0 * std::atan2(q.z(), q.w()));
    return Eigen::Quaterniond(heading(edit(twist)) * heading(-twist) * q);
  };
}

AttitudeEdit attitude_edit(const MetadataFinding& finding) {
  const auto angles = [](const std::function<YawPitchRoll(const YawPitchRoll&)>& edit) {
    return [edit](const Eigen::Quaterniond& q) { return rotation_from(edit(written_angles(q))); };
  };
  switch (finding.fault) {
    case MetadataFault::YawSign: return edit_yaw([](Angle yaw) { return -yaw; });
    case MetadataFault::YawFromEast:
      return edit_yaw([](Angle yaw) { return Angle::degrees(90.0) - yaw; });
    case MetadataFault::YawOffset:
      return [turn = finding.turn](const Eigen::Quaterniond& q) {
        return Eigen::Quaterniond(heading(turn) * q);
      };
    case MetadataFault::RollSign:
      return angles([](const YawPitchRoll& a) { return YawPitchRoll{a.yaw, a.pitch, -a.roll}; });
    case MetadataFault::PitchSign:
      return angles([](const YawPitchRoll& a) { return YawPitchRoll{a.yaw, -a.pitch, a.roll}; });
    case MetadataFault::RollAndPitchSign:
      return angles([](const YawPitchRoll& a) { return YawPitchRoll{a.yaw, -a.pitch, -a.roll}; });
    case MetadataFault::AllSigns:
      return [](const Eigen::Quaterniond& q) {
        const YawPitchRoll a = written_angles(q);
        return rotation_from({-a.yaw, -a.pitch, -a.roll});
      };
    case MetadataFault::EastNorthUp:
      return [](const Eigen::Quaterniond& q) {
        const YawPitchRoll a = written_angles(q);
        return rotation_from({Angle::degrees(90.0) - a.yaw, -a.pitch, a.roll});
      };
    case MetadataFault::RollPitchSwapped:
      return angles([](const YawPitchRoll& a) { return YawPitchRoll{a.yaw, a.roll, a.pitch}; });
    default: return {};
  }
}

template <class Edit>
Status edit_poses(Flight& flight, Edit&& edit) {
  for (ImageFrame& frame : flight.frames)
    if (frame.own_pose) WATERSKY_CHECK(edit(*frame.own_pose));
  std::vector<StampedPose> poses = flight.trajectory.poses();
  for (StampedPose& pose : poses) WATERSKY_CHECK(edit(pose));
  WATERSKY_TRY(flight.trajectory, Trajectory::make(std::move(poses)));
  return {};
}

Status edit_attitudes(Flight& flight, const AttitudeEdit& edit) {
  if (flight.gimbal_reference == GimbalReference::NorthEastDown) {
    for (ImageFrame& frame : flight.frames)
      if (frame.own_gimbal) frame.own_gimbal = edit(*frame.own_gimbal);
    std::vector<StampedRotation> rotations = flight.gimbal.rotations();
    for (StampedRotation& stamped : rotations) stamped.rotation = edit(stamped.rotation);
    WATERSKY_TRY(flight.gimbal, RotationTrack::make(std::move(rotations)));
    return {};
  }
  // A room whose axes are turned has its angles written against these.
  const bool north_up = flight.datum.x_azimuth().radians() == 0.0;
  return edit_poses(flight, [&](StampedPose& pose) -> Status {
    const Point<World>& at = pose.world_from_body.origin();
    const Eigen::Quaterniond world_from_ned =
        north_up ? flight.datum.world_from_ned_rotation(flight.datum.geodetic(at))
                 : Eigen::Quaterniond::Identity();
    pose.world_from_body = {
        world_from_ned * edit(world_from_ned.conjugate() * pose.world_from_body.rotation()), at};
    return {};
  });
}

/// Adds to heights what `up_m` says for a place.
Status edit_heights(Flight& flight, const std::function<Result<double>(const Geodetic&)>& up_m) {
  return edit_poses(flight, [&](StampedPose& pose) -> Status {
    Geodetic place = flight.datum.geodetic(pose.world_from_body.origin());
    WATERSKY_TRY(const double add_m, up_m(place));
    place.height_ellipsoid_m += add_m;
    pose.world_from_body = {pose.world_from_body.rotation(), flight.datum.world(place)};
    return {};
  });
}

Status from_feet(Flight& flight, HeightZero zero) {
  return edit_heights(flight, [&](const Geodetic& place) -> Result<double> {
    double zero_m = flight.datum.origin().height_ellipsoid_m;
    if (zero == HeightZero::Geoid) {
      WATERSKY_TRY(zero_m, egm96_above_ellipsoid_m(place.latitude, place.longitude));
    } else if (zero == HeightZero::Sea) {
      if (!flight.sea_level || !flight.sea_level->height_ellipsoid_m)
        return Error{ErrorCode::NotFound, "the height of the sea is not known"};
      WATERSKY_TRY(zero_m, flight.sea_level->height_ellipsoid_m(place));
    }
    return (kFoot_m - 1.0) * (place.height_ellipsoid_m - zero_m);
  });
}

}  // namespace

namespace detail {

/// A pixel of the stored image in the one that turned_back() makes of it.
Pixel turned_back(const Pixel& px, int quarter_turns, int width_px, int height_px) {
  switch ((quarter_turns % 4 + 4) % 4) {
    case 1: return {px.v, height_px - 1 - px.u};
    case 2: return {width_px - 1 - px.u, height_px - 1 - px.v};
    case 3: return {width_px - 1 - px.v, px.u};
    default: return px;
  }
}

/// Anchors are marked in pixels as they are stored.
void turn_marks_back(const MetadataFinding& finding, const std::string& frame, Flight& flight) {
  for (Anchor& anchor : flight.anchors)
    for (AnchorSighting& s : anchor.sightings)
      if (s.frame == frame)
        s.px = turned_back(s.px, finding.quarter_turns, flight.camera.width_px(),
                           flight.camera.height_px());
}

Status apply(const MetadataFinding& finding, Flight& flight) {
  if (const AttitudeEdit edit = attitude_edit(finding)) return edit_attitudes(flight, edit);
  switch (finding.fault) {
    case MetadataFault::TurnedImages:
      for (const std::size_t i : finding.frames) {
        if (i >= flight.frames.size())
          return Error{ErrorCode::Usage, "the findings are those of another flight"};
        // Its bytes are turned the other way.
        flight.frames[i].file.clear();
        flight.frames[i].encoded = nullptr;
        flight.frames[i].load =
            watersky::turned_back(std::move(flight.frames[i].load), finding.quarter_turns,
                                  flight.camera.width_px(), flight.camera.height_px());
        turn_marks_back(finding, flight.frames[i].name, flight);
      }
      return {};
    case MetadataFault::CameraTurned:
      flight.mount.rotation =
          flight.mount.rotation * quaternion(finding.turn, Eigen::Vector3d::UnitZ());
      return {};
    case MetadataFault::HeightsInFeet: return from_feet(flight, finding.height_zero);
    case MetadataFault::PositionsInFeet:
      return edit_poses(flight, [&](StampedPose& pose) -> Status {
        Eigen::Vector3d at = pose.world_from_body.origin().v;
        at.head<2>() *= kFoot_m;
        pose.world_from_body = {pose.world_from_body.rotation(), Point<World>{at}};
        return {};
      });
    case MetadataFault::HeightReference:
      return edit_heights(flight,
                          [&](const Geodetic&) { return Result<double>(finding.height_shift_m); });
    default: return Error{ErrorCode::Unsupported, "what is off cannot be told, so not mended"};
  }
}

Pixel native_pixel(const Pixel& stored, int quarter_turns, int width_px, int height_px) {
  const double right = width_px - 1, bottom = height_px - 1;
  switch ((quarter_turns % 4 + 4) % 4) {
    case 1: return {stored.v, bottom - stored.u};
    case 2: return {right - stored.u, bottom - stored.v};
    case 3: return {right - stored.v, stored.u};
    default: return stored;
  }
}

}  // namespace detail

ImageLoader turned_back(ImageLoader load, int quarter_turns, int width_px, int height_px) {
  const int turns = (quarter_turns % 4 + 4) % 4;
  if (turns == 0 || !load) return load;
  return [load = std::move(load), turns, width_px,
          height_px](const ImageRequest& request) -> Result<cv::Mat> {
    // Blocks that do not tile the image would begin at the wrong edge once it is turned.
    const auto tiles = [&](int r) { return width_px % r == 0 && height_px % r == 0; };
    int decoded = request.reduction;
    while (decoded > 1 && !tiles(decoded)) decoded /= 2;
    WATERSKY_TRY(const cv::Mat stored, load({.color = request.color, .reduction = decoded}));
    cv::Mat image;
    cv::rotate(stored, image,
               turns == 1   ? cv::ROTATE_90_COUNTERCLOCKWISE
               : turns == 2 ? cv::ROTATE_180
                            : cv::ROTATE_90_CLOCKWISE);
    // A format that cannot be reduced while decoding comes in full size, and stays so.
    const bool was_reduced = decoded == 1 || image.cols < width_px;
    const int still = was_reduced ? request.reduction / decoded : 1;
    return still > 1 ? reduced_by(image, still) : image;
  };
}

Result<Flight> mended(Flight flight, std::span<const MetadataFinding> findings) {
  for (const MetadataFinding& finding : findings) {
    if (!finding.certain) continue;
    WATERSKY_CHECK(detail::apply(finding, flight));
    flight.notes.push_back(finding.sentence);
  }
  return flight;
}

}  // namespace watersky
