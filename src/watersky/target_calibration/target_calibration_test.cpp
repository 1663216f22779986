// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <chrono>
#include <cstdio>
#include "support/target_scene.hpp"
#include "watersky/target_calibration/calibrate_images.hpp"
using namespace watersky;
using namespace watersky::test;
static double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
static void show(const Result<TargetCalibration>& r, const CameraModel& cam, double t) {
  if (!r) {
    printf("  FAIL %s (%.2f s)\n", r.error().message.c_str(), t);
    return;
  }
  printf(
      "  %.2f s rms %.3f sigma %.3f used %zu/%zu kind %s size %s cover %.2f corner %.3f mid %.3f "
      "tilt %.0f\n",
      t, r->rms_px, r->sigma_px, r->used_views(), r->views.size(),
      std::string(name_of(r->kind)).c_str(), to_string(r->size).c_str(), r->coverage.share,
      r->corner_sigma_px, r->middle_sigma_px, r->tilt_spread_deg);
  for (auto& p : r->parameters) {
    double truth;
    const auto& a = cam.camera_matrix();
    int i = &p - &r->parameters[0];
    truth = i == 0   ? a(0, 0)
            : i == 1 ? a(1, 1)
            : i == 2 ? a(0, 2)
            : i == 3 ? a(1, 2)
                     : cam.distortion()[i - 4];
    printf("    %s %.5f +- %.5f truth %.5f z %.1f\n", p.name.c_str(), p.value, p.sigma, truth,
           p.sigma > 0 ? (p.value - truth) / p.sigma : 0);
  }
  for (auto& c : r->candidates)
    printf("    %-24s rms %.4f cv %.4f worse %.1f %s %s\n", c.name.c_str(), c.rms_px,
           c.left_out_rms_px, c.worse_by_sigmas, c.fault.c_str(), c.chosen ? "<-" : "");
  for (auto& v : r->views)
    if (!v.used) printf("    - %s: %s\n", v.name.c_str(), v.reason.c_str());
  for (auto& n : r->notes) printf("    note %s\n", n.c_str());
}
TEST(Probe, Bare) {
  struct C {
    const char* name;
    CameraModel cam;
  };
  std::vector<C> cams{
      {"pin k1k2p1p2", pinhole(560, {-0.25, 0.08, 0.002, -0.0015})},
      {"pin k1", pinhole(800, {-0.15, 0, 0, 0})},
      {"pin rational", pinhole(420, {0.2, -0.1, 0.001, 0.001, 0.01, 0.55, 0.05, 0.02})},
      {"fisheye", fisheye(260, {0.03, -0.01, 0.002, -0.0005})}};
  for (auto& c : cams) {
    printf("%s\n", c.name);
    auto poses = good_poses(c.cam, TargetKind::Chessboard, {9, 6}, 15);
    auto v = bare_views(c.cam, poses, {9, 6}, 0.08, 3);
    double t = now();
    auto r = calibrate_views(v, 640, 480);
    show(r, c.cam, now() - t);
  }
}
TEST(Probe, Images) {
  for (auto kind : {TargetKind::Chessboard, TargetKind::Circles, TargetKind::AsymmetricCircles,
                    TargetKind::Holes}) {
    const CameraModel cam = pinhole(560, {-0.25, 0.08, 0.0005, -0.0003});
    TargetRenderer r(cam);
    Scene s;
    s.kind = kind;
    s.size = kind == TargetKind::AsymmetricCircles ? TargetSize{4, 11} : TargetSize{9, 6};
    if (kind == TargetKind::AsymmetricCircles) s.radius = 0.45;
    if (kind == TargetKind::Holes) {
      s.board = 60;
      s.pattern = 90;
      s.around = 95;
      s.gradient = 120;
      s.noise = 2;
    }
    auto poses = good_poses(cam, kind, s.size, 12);
    std::vector<CalibrationImage> images;
    for (size_t i = 0; i < poses.size(); ++i) {
      Scene q = s;
      if (i == 5) q.motion_px = 9;
      auto levels = r.render(q, poses[i], i);
      cv::Mat img = kind == TargetKind::Holes ? as_16_bit(levels, 2) : as_8_bit(levels);
      images.push_back({"img" + std::to_string(i), [img] { return Result<cv::Mat>(img); }});
    }
    images.push_back({"empty", [] {
                        cv::Mat m(480, 640, CV_8U, cv::Scalar(90));
                        cv::randn(m, 90, 3);
                        return Result<cv::Mat>(m);
                      }});
    double t = now();
    auto res = calibrate_images(images, {});
    show(res, cam, now() - t);
  }
}
