// SPDX-License-Identifier: MIT
#pragma once
/// The regular clock behind frames that carry a counter.
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace watersky::align {

/// captured = start + period counter, up to a constant delay.
struct CaptureClock {
  double start_s = 0.0, period_s = 0.0;
  double jitter_s = 0.0;    ///< one sigma of the arrivals about their middle course
  double rate_sigma = 0.0;  ///< of the period, as a share of it

  /// How far the delay may wander from frame to frame so that the period's error fits, per root
  /// second, over `window_s` at most; `own_s`: what it wanders by itself.
  [[nodiscard]] double walk_s(double own_s, double window_s) const {
    return std::hypot(own_s, rate_sigma * std::sqrt(window_s));
  }
};

/// One sigma of the period of a clock through `count` times that scatter by `scatter_s` about it,
/// as a share of it: of a straight line, with room for what is no white noise.
[[nodiscard]] double clock_rate_sigma(double scatter_s, double period_s, double count);

/// The line under the arrivals: nothing arrives before it was captured, so the earliest arrivals
/// tell the clock and the others how late they were. nullopt for fewer than 8 frames, or
/// counters that do not rise.
[[nodiscard]] std::optional<CaptureClock> fit_capture_clock(
    const std::vector<std::uint64_t>& counters, const std::vector<double>& received_s);

/// That frames were dated by it, a sentence.
[[nodiscard]] std::string counted_note(const CaptureClock& clock);

/// A time for each frame that runs evenly: a straight line through the arrivals around it. What
/// arrives unevenly was still taken evenly, but for frames that were lost.
[[nodiscard]] std::vector<double> even_times(const std::vector<double>& received_s);

/// One sigma of frames' own delays, from their arrivals and the even times under them.
[[nodiscard]] double arrival_jitter_s(const std::vector<double>& received_s,
                                      const std::vector<double>& even_s);

/// What arrivals tell of the times of frames that still come in: the regular clock of those that
/// are counted, of the others how unevenly they arrive.
class ArrivalClock {
 public:
  /// In order of arrival. True: base times have changed for all frames.
  bool add(double received_s, const std::optional<std::uint64_t>& counter);
  /// When it was captured, up to the delay.
  [[nodiscard]] double base_s(double received_s, const std::optional<std::uint64_t>& counter) const;
  [[nodiscard]] const std::optional<CaptureClock>& regular() const { return clock_; }
  /// One sigma of frames' own delays about their mean; 0 for a regular clock.
  [[nodiscard]] double jitter_s() const { return clock_ ? 0.0 : jitter_s_; }
  /// Enough has arrived to tell.
  [[nodiscard]] bool settled() const { return count_ >= kEnough; }

 private:
  static constexpr std::size_t kEnough = 30, kRemembered = 900;
  std::vector<double> received_s_;
  std::vector<std::uint64_t> counters_;
  bool counted_ = true;
  std::size_t count_ = 0;
  std::optional<CaptureClock> clock_;
  double jitter_s_ = 0.03;  ///< until it is known
};

/// The same clock found without a counter, from capture times that were estimated well (`sigma_s`
/// small) for a part of the frames: slots of one period, each frame in one of its own, in order.
/// Frames whose time is not known well lie in the slots between, nearest to `estimated_s`. nullopt
/// when the well-known times do not lie on such a grid.
struct Slots {
  CaptureClock clock;
  std::vector<std::int64_t> slot;  ///< of each frame
  double residual_s = 0.0;         ///< of the well-known times, robust sigma
};
[[nodiscard]] std::optional<Slots> find_slots(const std::vector<double>& estimated_s,
                                              const std::vector<double>& sigma_s);

}  // namespace watersky::align
