// SPDX-License-Identifier: MIT
/// From the oracle to the thesis's laboratory, one error at a time and all together.
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "algorithm1_map.hpp"
#include "drawing.hpp"
#include "preparations.hpp"
#include "recording.hpp"
#include "study.hpp"
#include "support/print_figure.hpp"
#include "watersky/io/files.hpp"

namespace watersky::study {

namespace {

struct Faults {
  double delay_ms = 0.0, jitter_ms = 0.0, mount_deg = 0.0;
};

struct Axis {
  const char* name;   ///< as figures spell it
  const char* title;  ///< as the drawing does
  std::vector<double> values;
  Faults (*faults)(double value);
};

std::vector<Axis> axes() {
  return {{"delay_ms",
           "delay of the images, ms",
           {0, 25, 50, 75, 100, 150, 200, 272, 350, 450, 600},
           [](double v) { return Faults{.delay_ms = v}; }},
          {"jitter_ms",
           "jitter about the true time, ms",
           {0, 10, 20, 35, 54, 80, 120, 200},
           [](double v) { return Faults{.jitter_ms = v}; }},
          {"mount_deg",
           "mount error, deg",
           {0, 0.5, 1, 1.5, 2, 3, 4, 6},
           [](double v) { return Faults{.mount_deg = v}; }},
          {"all",
           "all three, 1: 272 ms, 54 ms, 2 deg",
           {0, 0.1, 0.25, 0.5, 0.75, 1, 1.5, 2},
           [](double v) {
             return Faults{272.0 * v, 54.0 * v, 2.0 * v};
           }}};
}

/// The recording with these faults and no others.
Flight with_faults(const sim::Simulation& recording, const Faults& faults, int seed) {
  cv::RNG rng(static_cast<std::uint64_t>(seed));
  Flight flight = recording.flight;
  for (std::size_t i = 0; i < flight.frames.size(); ++i)
    flight.frames[i].received_at =
        recording.truth.frames[i].captured_at +
        seconds(1e-3 * (faults.delay_ms + rng.gaussian(faults.jitter_ms)));
  Eigen::Vector3d axis;
  for (double& x : axis) x = rng.gaussian(1.0);
  flight.mount = recording.truth.mount;
  flight.mount.rotation =
      flight.mount.rotation *
      Eigen::AngleAxisd(Angle::degrees(faults.mount_deg).radians(), axis.normalized());
  return flight;
}

struct Outcome {
  double found = 0.0, rms_mm = 0.0, iou = 0.0;
};

/// Found patches above, their error below, over each axis.
cv::Mat drawn_sweep(const std::vector<Axis>& all,
                    const std::vector<std::vector<Outcome>>& results) {
  constexpr int kWidth = 340, kHeight = 220, kLeft = 64, kTop = 78, kBetween = 84;
  constexpr double kMostRms_mm = 160.0;
  cv::Mat picture(kTop + 2 * (kHeight + kBetween), kLeft + 4 * (kWidth + kLeft), CV_8UC3, kPaper);
  write_text(picture, "Algorithm 1 with the latest pose, all else exact; mean over the flights",
             {kLeft, 28}, 0.6);
  for (std::size_t a = 0; a < all.size(); ++a)
    for (int row = 0; row < 2; ++row) {
      const int left = kLeft + static_cast<int>(a) * (kWidth + kLeft);
      const int top = kTop + row * (kHeight + kBetween);
      const double most_x = all[a].values.back(), most_y = row == 0 ? 8.0 : kMostRms_mm;
      const auto at = [&](double x, double y) {
        return cv::Point(left + static_cast<int>(std::lround(kWidth * x / most_x)),
                         top + kHeight - static_cast<int>(std::lround(kHeight * y / most_y)));
      };
      for (int i = 0; i <= 4; ++i) {
        const double y = most_y * i / 4;
        cv::line(picture, at(0, y), at(most_x, y), kFaint, 1);
        write_text(picture, std::to_string(std::lround(y)), at(0, y) + cv::Point(-8, 4), 0.42, kInk,
                   Align::Right);
        const double x = most_x * i / 4;
        char text[16];
        std::snprintf(text, sizeof text, "%g", x);
        write_text(picture, text, at(x, 0) + cv::Point(0, 18), 0.42, kInk, Align::Centre);
      }
      write_text(picture, row == 0 ? "patches found of 8" : "RMS of those found, mm",
                 {left, top - 8}, 0.48);
      write_text(picture, all[a].title, {left + kWidth / 2, top + kHeight + 38}, 0.48, kInk,
                 Align::Centre);
      const cv::Scalar colour = row == 0 ? kPath : kTruth;
      std::optional<cv::Point> before;
      for (std::size_t i = 0; i < results[a].size(); ++i) {
        const double y = row == 0 ? results[a][i].found : results[a][i].rms_mm;
        if (!std::isfinite(y)) {
          before.reset();
          continue;
        }
        const cv::Point here = at(all[a].values[i], std::min(y, most_y));
        if (before) cv::line(picture, *before, here, colour, 2, cv::LINE_AA);
        cv::circle(picture, here, 4, colour, cv::FILLED, cv::LINE_AA);
        before = here;
      }
      cv::rectangle(picture, {left, top, kWidth + 1, kHeight + 1}, kInk, 1);
    }
  return picture;
}

}  // namespace

Status sweep(int seeds, int step, const std::filesystem::path& out) {
  const std::vector<Axis> all = axes();
  std::vector<std::vector<Outcome>> sums;
  std::vector<std::vector<int>> with_patches;
  for (const Axis& axis : all) {
    sums.emplace_back(axis.values.size());
    with_patches.emplace_back(axis.values.size());
  }
  for (int seed = 1; seed <= seeds; ++seed) {
    WATERSKY_TRY(const sim::Simulation recording, record(laboratory(seed)));
    const std::vector<const ImageFrame*> frames = every(recording.flight, step);
    WATERSKY_CHECK(render(frames));
    WATERSKY_TRY(const std::vector<cv::Mat> masks, segmented(frames));
    for (std::size_t a = 0; a < all.size(); ++a)
      for (std::size_t i = 0; i < all[a].values.size(); ++i) {
        const Faults faults = all[a].faults(all[a].values[i]);
        WATERSKY_TRY(const Flight prepared, with_latest_pose(with_faults(recording, faults, seed)));
        WATERSKY_TRY(const RoomMap map, run_algorithm1(prepared, frames, masks));
        const Score score = judge(map, recording.truth.sea, recording.flight.datum);
        sums[a][i].found += static_cast<double>(score.found()) / seeds;
        sums[a][i].iou += score.iou / seeds;
        if (score.found() == 0) continue;
        sums[a][i].rms_mm += 1e3 * score.patch_rms_m();
        ++with_patches[a][i];
      }
  }
  std::string csv = "fault,value,patches_found,patch_rms_mm,iou\n";
  for (std::size_t a = 0; a < all.size(); ++a)
    for (std::size_t i = 0; i < all[a].values.size(); ++i) {
      Outcome& outcome = sums[a][i];
      outcome.rms_mm /= with_patches[a][i];  // none: not a number
      char value[24], line[200];
      std::snprintf(value, sizeof value, "%g", all[a].values[i]);
      const std::string name = std::string("lab.sweep.") + all[a].name + "_" + value + ".";
      print_figure(name + "patches_found", outcome.found);
      print_figure(name + "patch_rms_mm", outcome.rms_mm, "mm");
      print_figure(name + "iou", outcome.iou);
      std::snprintf(line, sizeof line, "%s,%s,%.2f,", all[a].name, value, outcome.found);
      csv += line;
      if (with_patches[a][i] > 0) {
        std::snprintf(line, sizeof line, "%.2f", outcome.rms_mm);
        csv += line;
      }
      std::snprintf(line, sizeof line, ",%.4f\n", outcome.iou);
      csv += line;
    }
  WATERSKY_CHECK(write_picture(out / "sweep.png", drawn_sweep(all, sums)));
  return write_file(out / "sweep.csv", csv);
}

}  // namespace watersky::study
