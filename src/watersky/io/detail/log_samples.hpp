// SPDX-License-Identifier: MIT
#pragma once
/// What the readers of autopilots' logs share.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "watersky/io/autopilot_log.hpp"

namespace watersky::detail {

/// By strictly rising time: of samples of one time the first stays.
template <class Sample>
void sort_by_time(std::vector<Sample>& samples) {
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.time < b.time; });
  samples.erase(std::unique(samples.begin(), samples.end(),
                            [](const Sample& a, const Sample& b) { return a.time == b.time; }),
                samples.end());
}

/// Of at least one number.
[[nodiscard]] inline double median(std::vector<double> x) {
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

/// One clock by another: the line under all (its time, how far the other is ahead of it), for
/// what arrives is never early. Sorts the points, of which there is at least one.
[[nodiscard]] inline LowerLine fit_clock(std::vector<std::pair<double, double>>& points) {
  // Crystals are within 100 ppm; a shorter log cannot tell drift from jitter.
  constexpr double kMinSpan_s = 120.0, kMaxDrift = 200e-6;
  std::sort(points.begin(), points.end());
  return fit_lower_line(points, kMinSpan_s, kMaxDrift);
}

/// Tells the runs of a clock apart that was set back or started anew, and single times that a
/// damaged record made up.
class ClockRuns {
 public:
  /// The run that a record of this time belongs to; nullopt for one that stands alone: far from
  /// the records before it, and those after it do not agree.
  std::optional<std::size_t> add(double time_s) {
    constexpr double kBack_s = 10.0, kAhead_s = 3600.0;
    constexpr int kAgreeing = 4;
    if (!std::isfinite(time_s)) return std::nullopt;
    if (!last_s_) last_s_ = time_s;
    if (time_s >= *last_s_ - kBack_s && time_s <= *last_s_ + kAhead_s) {
      last_s_ = std::max(*last_s_, time_s);
      agreeing_ = 0;
      return run_;
    }
    agreeing_ = agreeing_ > 0 && std::abs(time_s - stray_s_) < kBack_s ? agreeing_ + 1 : 1;
    stray_s_ = time_s;
    if (agreeing_ < kAgreeing) {
      ++strays_;
      return std::nullopt;
    }
    if (time_s < *last_s_) ++run_;
    last_s_ = time_s;
    agreeing_ = 0;
    return run_;
  }
  [[nodiscard]] std::size_t runs() const { return run_ + 1; }
  [[nodiscard]] std::size_t strays() const { return strays_; }

 private:
  std::optional<double> last_s_;
  double stray_s_ = 0.0;
  int agreeing_ = 0;
  std::size_t run_ = 0;
  std::size_t strays_ = 0;
};

/// What a log's reader says of bytes that it could not use.
inline void note_damage(std::vector<std::string>& notes, const std::string& name,
                        const std::string& format, std::size_t skipped, std::size_t gaps,
                        std::size_t first_at, std::size_t truncated) {
  if (skipped > 0)
    notes.push_back(name + ": " + std::to_string(skipped) + " bytes in " + std::to_string(gaps) +
                    " places, the first at byte " + std::to_string(first_at) + ", are no " +
                    format + " and were skipped");
  if (truncated > 0)
    notes.push_back(name + ": ends in the middle of a record, whose " + std::to_string(truncated) +
                    " bytes were left out");
}

}  // namespace watersky::detail
