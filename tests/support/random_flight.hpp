// SPDX-License-Identifier: MIT
#pragma once
/// Flights for tests of what writes and reads them.
#include <opencv2/core.hpp>
#include <random>

#include "watersky/flight/flight.hpp"
#include "watersky/geodesy/projection.hpp"

namespace watersky::test {

struct Dice {
  std::mt19937_64 rng;
  double operator()(double low, double high) {
    return std::uniform_real_distribution(low, high)(rng);
  }
  int whole(int low, int high) { return std::uniform_int_distribution(low, high)(rng); }
  Eigen::Quaterniond rotation() {
    return rotation_from({Angle::degrees((*this)(-180, 180)), Angle::degrees((*this)(-85, 85)),
                          Angle::degrees((*this)(-180, 180))});
  }
};

inline CameraModel random_camera(Dice& dice, int w, int h) {
  Eigen::Matrix3d a;
  a << dice(50, 60), 0, dice(30, 33), 0, dice(50, 60), dice(20, 27), 0, 0, 1;
  return CameraModel::make(LensModel::Pinhole, w, h, a,
                           {dice(-0.1, 0.1), dice(-0.01, 0.01), 1e-4, -2e-4, 0.001})
      .value();
}

/// A flight of every kind: own poses or a trajectory, gimbal or none, 8 or 16 bit.
inline Flight random_flight(int seed) {
  Dice dice{std::mt19937_64(static_cast<unsigned>(seed))};
  const Datum datum(
      {Angle::degrees(dice(-80, 80)), Angle::degrees(dice(-180, 180)), dice(-50, 200)},
      Angle::degrees(seed % 3 == 0 ? dice(-180, 180) : 0.0));
  Flight f("flight", datum, random_camera(dice, 64, 48));
  f.calibration = {"EXIF \"focal\" and the table: 55 px", 1.25};
  f.mount = {camera_rotation({Angle::degrees(dice(-180, 180)), Angle::degrees(dice(-90, 90)),
                              Angle::degrees(dice(-180, 180))}),
             {dice(-1, 1), dice(-1, 1), dice(-1, 1)},
             0.01,
             false};
  const bool own = seed % 2 == 0, gimbal = seed % 4 < 2, sigma = seed % 3 == 1;
  Time t(Duration(1'533'430'844'000'000'000 + dice.whole(0, 999'999'999)));
  std::vector<StampedPose> poses;
  std::vector<StampedRotation> rotations;
  for (int i = 0; i < 12; ++i) {
    StampedPose p{
        t,
        {dice.rotation(), Point<World>{{dice(-5e4, 5e4), dice(-5e4, 5e4), dice(-500, -10)}}},
        std::nullopt};
    if (sigma)
      p.sigma = PoseSigma{{dice(0, 1), dice(0, 1), dice(0, 1)},
                          {dice(0, 0.1), dice(0, 0.1), dice(0, 0.1)}};
    poses.push_back(p);
    rotations.push_back({t, dice.rotation()});
    t += Duration(dice.whole(1, 1'000'000'000));
  }
  if (gimbal)
    f.gimbal_reference = seed % 8 < 4 ? GimbalReference::Body : GimbalReference::NorthEastDown;
  for (int i = 0; i < 5; ++i) {
    ImageFrame frame;
    frame.name = "frame_" + std::to_string(i) + ".png";
    frame.captured_at =
        poses[static_cast<std::size_t>(2 * i)].time + (own ? Duration{0} : Duration(1234567));
    if (seed % 5 == 0) {
      frame.received_at = *frame.captured_at + std::chrono::milliseconds(50);
      frame.counter = static_cast<std::uint64_t>(1000 + i);
    }
    if (own) frame.own_pose = poses[static_cast<std::size_t>(2 * i)];
    if (own && gimbal) frame.own_gimbal = rotations[static_cast<std::size_t>(2 * i)].rotation;
    cv::Mat image(48, 64, seed % 2 ? CV_16UC1 : CV_8UC3);
    cv::theRNG().state = static_cast<std::uint64_t>(seed * 100 + i);
    cv::randu(image, 0, seed % 2 ? 65536 : 256);
    frame.load = [image](const ImageRequest&) -> Result<cv::Mat> { return image; };
    f.frames.push_back(frame);
  }
  if (!own) {
    f.trajectory = Trajectory::make(poses).value();
    if (gimbal) f.gimbal = RotationTrack::make(rotations).value();
  }
  const bool geoid = seed % 3 == 2;
  const double above = dice(-30, 30);
  f.sea_level =
      SeaLevel{[geoid, above](const Geodetic& p) -> Result<double> {
                 if (!geoid) return above;
                 WATERSKY_TRY(const double n, egm96_above_ellipsoid_m(p.latitude, p.longitude));
                 return n + above;
               },
               "given", seed % 2 ? 0.5 : 0.0};
  f.readout_s = seed % 2 ? 0.03 : 0.0;
  return f;
}

}  // namespace watersky::test
