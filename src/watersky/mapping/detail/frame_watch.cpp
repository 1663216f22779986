// SPDX-License-Identifier: MIT
#include "watersky/mapping/detail/frame_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace watersky::detail {
namespace {

constexpr int kReduction = 8;
constexpr int kColumns = 24, kRows = 18;
/// Fewer places tell nothing.
constexpr int kLeastPlaces = 40;
/// Frames further apart in time may see changed light.
constexpr double kLongest_s = 3.0;
/// A jump moves the level by at least this part of the picture's spread, and by so many levels.
constexpr double kLeastJump = 0.3;
constexpr double kLeastLevels = 6.0;
/// Places that are the same agree in what they show so far; else the pose is not good enough.
constexpr double kLeastCorrelation = 0.6;
/// A shutter leaves at most this part of the spread, and stands outside what was seen.
constexpr double kMostSpread = 0.25;
/// A picture that stands still for so long is the camera's doing, not a recorder's.
constexpr double kLeastStill_s = 0.3;

double quantile(std::vector<float>& values, double q) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

cv::Mat reduced_levels(const cv::Mat& image) {
  cv::Mat small, gray, level;
  const cv::Size size(image.cols / kReduction, image.rows / kReduction);
  if (size.empty()) return {};
  cv::resize(image({0, 0, size.width * kReduction, size.height * kReduction}), small, size, 0, 0,
             cv::INTER_AREA);
  if (small.channels() == 3)
    cv::cvtColor(small, gray, cv::COLOR_BGR2GRAY);
  else
    gray = small;
  gray.convertTo(level, CV_32F);
  return level;
}

LevelChange level_change(const LevelView& earlier, const LevelView& later) {
  std::vector<float> a, b;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      // A lattice on the plane: what lies in both pictures is found by projecting it twice.
      const CellBox& box = later.view.box;
      const Eigen::Vector3d place(box.first_column + (column + 0.5) * box.columns / kColumns,
                                  box.first_row + (row + 0.5) * box.rows / kRows, 1.0);
      const auto level_at = [&place](const LevelView& frame) -> std::optional<float> {
        const Eigen::Vector3d direction = frame.view.camera_from_grid * place;
        if (!(direction.z() > 0)) return std::nullopt;
        const auto pixel = frame.view.camera.project(Vector<Camera>{direction});
        if (!pixel) return std::nullopt;
        const double u = std::round(pixel->u), v = std::round(pixel->v);
        if (!(u >= 0 && v >= 0 && u < frame.level.cols && v < frame.level.rows))
          return std::nullopt;
        return frame.level.at<float>(static_cast<int>(v), static_cast<int>(u));
      };
      const auto before = level_at(earlier), after = level_at(later);
      if (!before || !after) continue;
      a.push_back(*before);
      b.push_back(*after);
    }
  LevelChange change;
  change.places = static_cast<int>(a.size());
  if (a.size() < 2) return change;
  const cv::Mat ma(1, change.places, CV_32F, a.data()), mb(1, change.places, CV_32F, b.data());
  const cv::Mat da = ma - cv::mean(ma)[0], db = mb - cv::mean(mb)[0];
  const double energy = da.dot(da) * db.dot(db);
  change.correlation = energy > 0 ? da.dot(db) / std::sqrt(energy) : 0.0;
  change.before = quantile(a, 0.5);
  change.after = quantile(b, 0.5);
  change.spread_before = quantile(a, 0.9) - quantile(a, 0.1);
  change.spread_after = quantile(b, 0.9) - quantile(b, 0.1);
  return change;
}

FrameWatch::Seen FrameWatch::seen(const cv::Mat& image, bool duplicates, bool levels) {
  Seen seen;
  seen.depth = image.depth();
  if (duplicates)
    if (auto sample = FrameSample::of(image)) seen.sample = *std::move(sample);
  if (levels) seen.level = reduced_levels(image);
  return seen;
}

void FrameWatch::end_of_still() {
  const double still_s = to_seconds(still_until_ - kept_time_);
  if (still_s >= kLeastStill_s)
    events_.push_back({kept_file_, kept_time_, SensorEvent::Kind::Freeze, still_s});
}

std::optional<std::string> FrameWatch::judge(const std::string& file, Time time,
                                             const GridView& grid, const CameraModel& camera,
                                             const Seen& seen) {
  char text[160];
  if (seen.sample) {
    const auto difference = duplicates_.judge(*seen.sample);
    if (difference && difference->duplicate) {
      still_until_ = time;
      std::snprintf(text, sizeof text, " (Hellinger distance %.4f, rms difference %.3g levels)",
                    difference->hellinger, difference->rms);
      return "it repeats the pixels of " + kept_file_ + text;
    }
    end_of_still();
    kept_file_ = file;
    kept_time_ = still_until_ = time;
  }
  if (seen.level.empty()) return std::nullopt;
  const auto event =
      level_event({file, time, seen.level, grid.with(camera.reduced_by(kReduction))}, seen.depth);
  if (!event) return std::nullopt;
  events_.push_back(*event);
  if (event->kind != SensorEvent::Kind::Shutter) return std::nullopt;
  std::snprintf(text, sizeof text,
                "it shows the camera's closed shutter (flat-field correction): no detail, %+.4g "
                "levels off the sea seen just before",
                event->size);
  return text;
}

std::optional<SensorEvent> FrameWatch::level_event(LevelView frame, int depth) {
  std::optional<SensorEvent> event;
  if (last_ && std::abs(to_seconds(frame.time - last_->time)) <= kLongest_s) {
    const LevelChange change = level_change(*last_, frame);
    const double step = change.after - change.before;
    const bool enough = change.places >= kLeastPlaces && std::abs(step) > kLeastLevels;
    // Thermal counts only: 8 bit follow the picture, and colour has no such shutter.
    if (enough && depth == CV_16U && change.spread_before > kLeastLevels &&
        change.spread_after < kMostSpread * change.spread_before &&
        std::abs(step) > change.spread_before && std::abs(change.correlation) < kLeastCorrelation)
      return SensorEvent{frame.file, frame.time, SensorEvent::Kind::Shutter, step};
    if (enough && std::abs(step) > kLeastJump * change.spread_before &&
        change.correlation >= kLeastCorrelation)
      event = SensorEvent{frame.file, frame.time, SensorEvent::Kind::GainJump, step};
  }
  last_ = std::move(frame);
  return event;
}

std::vector<SensorEvent> FrameWatch::events() {
  end_of_still();
  kept_time_ = still_until_;
  return events_;
}

std::vector<std::string> notes_on(const std::vector<SensorEvent>& events) {
  std::vector<std::string> notes;
  const auto add = [&](SensorEvent::Kind kind, const char* format) {
    int count = 0;
    const SensorEvent* largest = nullptr;
    for (const SensorEvent& event : events) {
      if (event.kind != kind) continue;
      ++count;
      if (!largest || std::abs(event.size) > std::abs(largest->size)) largest = &event;
    }
    if (!largest) return;
    char text[240];
    std::snprintf(text, sizeof text, format, count, count == 1 ? "" : "s", std::abs(largest->size),
                  largest->file.c_str());
    notes.emplace_back(text);
  };
  add(SensorEvent::Kind::Freeze, "The picture stood still %d time%s, longest for %.2g s from %s.");
  add(SensorEvent::Kind::Shutter,
      "The camera's shutter was closed in %d frame%s, up to %.4g levels off the sea (%s); they "
      "were left out.");
  add(SensorEvent::Kind::GainJump,
      "The camera's level or gain jumped %d time%s between frames of the same sea, most by %.3g "
      "levels at %s.");
  return notes;
}

}  // namespace watersky::detail
