// SPDX-License-Identifier: MIT
#include "watersky/target_calibration/target_detection.hpp"
#include <gtest/gtest.h>
#include <chrono>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include "support/target_scene.hpp"
using namespace watersky;
using namespace watersky::test;
static double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
TEST(Probe, Detect) {
  const CameraModel cam = pinhole(560, {-0.25, 0.08, 0.0005, -0.0003});
  TargetRenderer r(cam);
  Scene s;
  auto kind = s.kind;
  auto poses = good_poses(cam, kind, s.size, 8);
  auto err = [&](const std::vector<cv::Point2f>& c, const ScenePose& p) {
    double sum = 0, mx = 0;
    for (auto& q : c) {
      double best = 1e9;
      for (auto& x : points_of(kind, s.size)) {
        auto px = cam.project(Vector<Camera>{p.rotation.leftCols<2>() * x + p.translation});
        best = std::min(best, std::hypot(px->u - q.x, px->v - q.y));
      }
      sum += best * best;
      mx = std::max(mx, best);
    }
    char b[60];
    snprintf(b, 60, "%.3f/%.3f", std::sqrt(sum / c.size()), mx);
    return std::string(b);
  };
  for (double blur : {0.5, 1.0, 1.8})
    for (double noise : {1.5, 6.0}) {
      s.blur_px = blur;
      s.noise = noise;
      for (int i : {0, 1, 3, 4, 7}) {
        auto img = as_8_bit(r.render(s, poses[i], 1));
        std::vector<cv::Point2f> c, a;
        double t0 = now();
        bool ok = cv::findChessboardCornersSB(img, {9, 6}, c, cv::CALIB_CB_NORMALIZE_IMAGE);
        double t1 = now();
        bool ok2 = cv::findChessboardCornersSB(
            img, {9, 6}, a, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY);
        double t2 = now();
        printf("blur %.1f noise %.1f view %d ok %d %d t %.2f %.2f SB %s SBacc %s", blur, noise, i,
               ok, ok2, t1 - t0, t2 - t1, ok ? err(c, poses[i]).c_str() : "",
               ok2 ? err(a, poses[i]).c_str() : "");
        if (!ok2) c = a;
        double nearest = 1e9;
        for (size_t k = 1; k < c.size(); ++k)
          nearest = std::min(nearest, (double)cv::norm(c[k] - c[k - 1]));
        for (size_t k = 9; k < c.size(); ++k)
          nearest = std::min(nearest, (double)cv::norm(c[k] - c[k - 9]));
        if (ok)
          for (double f : {0.15, 0.2, 0.25, 0.35, 0.5}) {
            auto d = c;
            int half = std::max(2, (int)(f * nearest));
            t0 = now();
            cv::cornerSubPix(img, d, {half, half}, {-1, -1},
                             {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 1e-4});
            printf("  w%d %s", half, err(d, poses[i]).c_str());
          }
        printf("\n");
      }
    }
}
