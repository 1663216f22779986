// SPDX-License-Identifier: MIT
#include "watersky/align/alignment.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>
#include <future>
#include <limits>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "watersky/align/detail/aligned_frame.hpp"
#include "watersky/align/detail/capture_clock.hpp"
#include "watersky/align/detail/delay_search.hpp"
#include "watersky/align/detail/estimates.hpp"
#include "watersky/align/detail/median.hpp"
#include "watersky/align/detail/revisits.hpp"
#include "watersky/align/detail/sighting_geometry.hpp"
#include "watersky/align/detail/starting_priors.hpp"
#include "watersky/align/detail/tracker.hpp"
#include "watersky/align/live_alignment.hpp"
#include "watersky/base/cpu_time.hpp"

namespace watersky {

namespace align {
namespace {

constexpr double kDelayKnots_s = 5.0;
constexpr std::size_t kMostRevisits = 240;
/// Of the arrivals' jitter, after a line through 25 of them.
constexpr double kLeftAfterEvening = 0.3;
constexpr std::size_t kFirstLook = 300;  ///< frames
constexpr int kRevisitPoints = 30;
constexpr double kRevisit_px = 0.2;  ///< one sigma of a place found again, reduced pixels
/// An estimate this many times its prior sigma away from what was given is not believed.
constexpr double kMostPriorSigmas = 4.0;
/// Errors of poses that are together this many times the sigma that explains their steps are
/// drawn aside by what the model does not know.
constexpr double kMostRunaway = 3.0;
/// Places may be this much farther apart when the poses' common error is taken out.
constexpr double kMostObjection = 1.2;
/// Places along edges slide: they tie across the edge, and cannot judge.
constexpr double kJudge_px = 0.7;
/// What satellite navigation as a whole may be off by where the recording does not say, m.
constexpr double kOffsetSigma_m = 2.0;
/// What heights as a whole may be off by where a range finder tells them, of the height.
constexpr double kHeightSigma = 0.1, kMostHeightError = 0.3;

template <class... T>
std::string text(const char* format, T... values) {
  char out[400];
  std::snprintf(out, sizeof out, format, values...);
  return out;
}

class Aligner {
 public:
  Aligner(const Flight& flight, const AlignOptions& options, const Progress& progress)
      : flight_(flight), options_(options), progress_(progress), geometry_(flight.camera) {}
  Result<Alignment> run();

 private:
  struct Loaded {
    cv::Mat gray;
    int reduction = 1;
  };

  Status list_frames();
  void use_clock();
  void set_priors();
  Result<Loaded> load(std::size_t k) const;
  cv::Mat valid_for(const cv::Mat& image) const;
  [[nodiscard]] bool may_use(const Eigen::Vector2d& px) const;
  Status track(std::size_t most);
  void set_knots(const std::vector<int>& keyframes);
  void find_start();
  void solve(bool variances);
  void choose_navigation_sigma();
  void choose_correlation();
  void choose(const std::vector<std::function<void()>>& ideas, double same);
  [[nodiscard]] bool run_away() const;
  void find_regular_clock();
  /// What an idea changes, to come back to when it was not the better one.
  struct Snapshot {
    std::vector<AdjustedFrame> frames;
    std::vector<double> knot_times_s, delay_knot_times_s;
    AdjustmentPriors priors;
    AdjustmentState state;
    double delay_start_s;
    std::string clock_note;
  };
  [[nodiscard]] Snapshot snapshot() const;
  void restore(const Snapshot& s);
  void freeze_unobserved();
  void hold_what_nothing_tells();
  void centre_errors();
  void use_anchors();
  void say_anchors(const AnchorChoice& choice);
  [[nodiscard]] double known_disagreement_m() const;
  void write_known(const AdjustmentState& given);
  void revisit();
  [[nodiscard]] std::optional<Eigen::Matrix3d> expected(int from, int to) const {
    return geometry_.expected(adjustment_->camera(from), adjustment_->camera(to));
  }
  [[nodiscard]] TieStatistics judge(const AdjustmentState& s) const;
  void finish();
  void write_frames(const std::optional<Adjustment::Knowledge>& known);
  void write_estimates(const std::optional<Adjustment::Knowledge>& known);

  const Flight& flight_;
  const AlignOptions& options_;
  const Progress& progress_;
  SightingGeometry geometry_;
  Alignment out_;
  std::vector<std::size_t> of_;  ///< Flight::frames of each frame of ours, in order of time
  std::optional<LocalFrame> local_;
  std::optional<Navigation> navigation_;
  std::optional<Adjustment> adjustment_;
  std::vector<double> received_s_;
  std::vector<KnownPoint> sighted_;  ///< sightings of anchors, before they are judged
  std::vector<int> keyframes_;
  bool delayed_ = false;
  bool held_ = false;           ///< mount and delay, for want of turns
  std::string clock_note_;      ///< of a regular clock that images told; empty: none
  double jitter_seen_s_ = 0.0;  ///< one sigma of the arrivals' unevenness
  int reduction_ = 1;           ///< full pixels of one that was tracked
  double given_delay_s_ = 0.0;
  double height_m_ = 0.0, gsd_m_ = 0.0;
  Globals::Vector globals_before_ = Globals::Vector::Zero();
  Globals::Vector sigma_by_places_ = Globals::Vector::Zero();
};

Status Aligner::list_frames() {
  if (!flight_.sea_level || !flight_.sea_level->height_ellipsoid_m)
    return Error{ErrorCode::NotFound, "the height of the sea is not known"};
  // Any place amid the flight.
  std::optional<Point<World>> middle;
  const auto& poses = flight_.trajectory.poses();
  if (!poses.empty()) middle = poses[poses.size() / 2].world_from_body.origin();
  for (const ImageFrame& f : flight_.frames)
    if (!middle && f.own_pose) middle = f.own_pose->world_from_body.origin();
  if (!middle)
    return Error{ErrorCode::NotFound, "there are neither recorded poses nor frames with their own"};
  local_.emplace(flight_.datum, *flight_.sea_level, flight_.datum.geodetic(*middle));
  WATERSKY_TRY(navigation_,
               Navigation::make(flight_, *local_, options_.parameters.align_max_pose_gap_s));
  adjustment_.emplace(*navigation_, flight_.mount, flight_.camera.focal_px(), flight_.readout_s);
  given_delay_s_ = flight_.delay_s.value_or(0.0);

  struct Listed {
    std::size_t index;
    AdjustedFrame frame;
    double received_s;
  };
  std::vector<Listed> listed;
  for (std::size_t i = 0; i < flight_.frames.size(); ++i) {
    const ImageFrame& f = flight_.frames[i];
    AdjustedFrame frame;
    if (f.own_pose && (!flight_.gimbal_reference || f.own_gimbal)) {
      auto still = Navigation::still(flight_, *local_, *f.own_pose, f.own_gimbal);
      if (!still) {
        out_.left_out.push_back({f.name, still.error().message});
        continue;
      }
      frame.base_s = navigation_->since_epoch_s(f.own_pose->time);
      frame.own = *still;
    } else if (f.captured_at) {
      frame.base_s = navigation_->since_epoch_s(*f.captured_at);
    } else if (f.received_at) {
      frame.base_s = navigation_->since_epoch_s(*f.received_at);
      frame.delayed = true;
    } else {
      out_.left_out.push_back({f.name, "it has neither a capture time nor an arrival time"});
      continue;
    }
    const double slack_s = frame.delayed ? options_.parameters.max_delay_s : 0.0;
    if (!frame.own && !navigation_->covers(frame.base_s) &&
        !navigation_->covers(frame.base_s - slack_s)) {
      const auto at = flight_.trajectory.at(frame.delayed ? *f.received_at : *f.captured_at,
                                            seconds(options_.parameters.align_max_pose_gap_s));
      out_.left_out.push_back({f.name, at ? "no pose at its time" : at.error().message});
      continue;
    }
    listed.push_back({i, frame, frame.base_s});
  }
  std::stable_sort(listed.begin(), listed.end(), [](const Listed& a, const Listed& b) {
    return a.frame.base_s < b.frame.base_s;
  });
  for (Listed& l : listed) {
    of_.push_back(l.index);
    received_s_.push_back(l.received_s);
    delayed_ = delayed_ || l.frame.delayed;
    adjustment_->frames.push_back(std::move(l.frame));
  }
  std::vector<double> heights;
  for (const auto& f : adjustment_->frames)
    heights.push_back(-(f.own ? f.own->position_m : navigation_->at(f.base_s).position_m).z());
  height_m_ = median(heights);
  gsd_m_ = height_m_ / flight_.camera.focal_px();
  if (!of_.empty() && !(height_m_ > 0))
    return Error{ErrorCode::Degenerate,
                 text("the flight is %.1f m below the sea; check the sea level", -height_m_)};
  KnownPoints points = known_points_of(flight_, *local_, *navigation_, of_, adjustment_->frames);
  sighted_ = std::move(points.points);
  KnownHeights ranged = known_heights_of(
      flight_, *local_, *navigation_, seconds(options_.parameters.align_max_pose_gap_s),
      options_.parameters.range_sigma_m, kMostHeightError * height_m_);
  adjustment_->known_heights = std::move(ranged.heights);
  for (const auto* notes : {&points.notes, &ranged.notes})
    out_.notes.insert(out_.notes.end(), notes->begin(), notes->end());
  return {};
}

/// Where all delayed frames carry a counter, their regular clock takes the place of arrival.
void Aligner::use_clock() {
  std::vector<std::uint64_t> counters;
  std::vector<double> received;
  for (std::size_t k = 0; k < of_.size(); ++k) {
    const ImageFrame& f = flight_.frames[of_[k]];
    if (!adjustment_->frames[k].delayed || !f.counter) return;
    counters.push_back(*f.counter);
    received.push_back(adjustment_->frames[k].base_s);
  }
  const auto clock = fit_capture_clock(counters, received);
  if (!clock) {
    if (!counters.empty())
      out_.notes.emplace_back(
          "The frames carry counters, but those do not rise with time; each frame's delay was "
          "estimated by itself.");
    return;
  }
  for (std::size_t k = 0; k < of_.size(); ++k)
    adjustment_->frames[k].base_s =
        clock->start_s + clock->period_s * static_cast<double>(counters[k]);
  adjustment_->priors.jitter_s = 0.0;
  adjustment_->priors.delay_walk_s = std::min(adjustment_->priors.delay_walk_s, kClockWalk_s);
  adjustment_->priors.delay_rate = clock->rate_sigma;
  out_.notes.push_back(counted_note(*clock));
}

void Aligner::set_priors() {
  AdjustmentPriors& priors = adjustment_->priors;
  priors = starting_priors(flight_, options_.parameters, navigation_->typical_sigma(), height_m_);
  if (flight_.gimbal.rotations().empty()) priors.globals[Globals::kLatency] = 0.0;
  if (!adjustment_->known_heights.empty())
    priors.globals[Globals::kHeight] =
        std::hypot(priors.globals[Globals::kHeight], kHeightSigma * height_m_);
  globals_before_ = priors.globals;
  if (!delayed_) return;
  // How unevenly the frames of an even camera arrived.
  const std::vector<double> even = even_times(received_s_);
  std::vector<double> arrivals, evens;
  for (std::size_t k = 0; k < even.size(); ++k)
    if (adjustment_->frames[k].delayed) {
      arrivals.push_back(received_s_[k]);
      evens.push_back(even[k]);
    }
  priors.jitter_s = arrival_jitter_s(arrivals, evens);
}

Result<Aligner::Loaded> Aligner::load(std::size_t k) const {
  const int reduction = reduction_for_tracking(flight_.camera);
  WATERSKY_TRY(cv::Mat image,
               flight_.frames[of_[k]].load({.color = false, .reduction = reduction}));
  for (const int r : {reduction, 1}) {
    const CameraModel model = flight_.camera.reduced_by(r);
    if (image.cols == model.width_px() && image.rows == model.height_px())
      return Loaded{std::move(image), r};
  }
  return Error{ErrorCode::InvalidInput, "its image does not have the calibration's " +
                                            std::to_string(flight_.camera.width_px()) + "x" +
                                            std::to_string(flight_.camera.height_px()) + " pixels"};
}

cv::Mat Aligner::valid_for(const cv::Mat& image) const {
  if (options_.camera_mask.empty()) return {};
  cv::Mat valid;
  cv::resize(options_.camera_mask, valid, image.size(), 0, 0, cv::INTER_NEAREST);
  return valid;
}

/// Whether the camera's mask leaves a full-size pixel.
bool Aligner::may_use(const Eigen::Vector2d& px) const {
  const cv::Mat& mask = options_.camera_mask;
  if (mask.empty()) return true;
  const cv::Point at(static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y())));
  return cv::Rect({0, 0}, mask.size()).contains(at) && mask.at<uchar>(at) != 0;
}

Status Aligner::track(std::size_t most) {
  adjustment_->groups.clear();
  out_.sightings = 0;
  out_.tracking_s = 0.0;

  WATERSKY_TRY(const auto registrar, make_registrar(RegistrationMethod::Klt));
  const AlignParameters& p = options_.parameters;
  TrackerOptions tracker_options;
  tracker_options.points = p.tracked_points;
  tracker_options.keyframe_interval_s = p.keyframe_interval_s;
  Tracker tracker(tracker_options, registrar.get());
  std::map<std::pair<int, int>, std::size_t> group_of;
  std::vector<int> keyframes;
  std::map<std::string, int> lost;
  const std::size_t n = std::min(most, of_.size());
  std::deque<std::future<Result<Loaded>>> ahead;
  const std::size_t window = static_cast<std::size_t>(std::max(1, options_.threads)) + 1;
  std::size_t next = 0;
  int before = -1;
  for (std::size_t k = 0; k < n; ++k) {
    report(progress_, "tracking", k, n);
    for (; next < n && next < k + window; ++next)
      ahead.push_back(std::async(options_.threads > 1 ? std::launch::async : std::launch::deferred,
                                 [this, next] { return load(next); }));
    const auto image = ahead.front().get();
    ahead.pop_front();
    if (!image) continue;  // mapping meets it again and says so
    const int frame = static_cast<int>(k);
    reduction_ = std::max(1, (std::max(flight_.camera.width_px(), flight_.camera.height_px()) +
                              tracker_options.longest_side_px - 1) /
                                 tracker_options.longest_side_px);
    const double started = thread_cpu_s();
    std::map<int, Eigen::Matrix3d> plane;
    const auto local_map = [&](int host, const Eigen::Vector2d& px) {
      auto found = plane.find(host);
      if (found == plane.end()) {
        const auto h = plane_homography(adjustment_->camera(host), adjustment_->camera(frame));
        found = plane.emplace(host, h.value_or(Eigen::Matrix3d::Identity())).first;
      }
      return geometry_.step_between(found->second, px);
    };
    const auto step = tracker.add(frame, adjustment_->frames[k].base_s, image->gray,
                                  image->reduction, valid_for(image->gray),
                                  before < 0 ? std::nullopt : expected(before, frame), local_map);
    out_.tracking_s += thread_cpu_s() - started;
    before = frame;
    if (!step) continue;
    if (step->keyframe) keyframes.push_back(frame);
    if (!step->lost.empty()) ++lost[step->lost];
    for (const Sighting& s : step->sightings) {
      auto made = geometry_.tie(s.host_px, s.px, s.covariance_px2);
      if (!made) continue;
      made->track = s.track;
      made->held_out = judges(s.track);
      const auto [found, is_new] =
          group_of.try_emplace({s.host, frame}, adjustment_->groups.size());
      if (is_new) adjustment_->groups.push_back({s.host, frame, false, 1.0, false, {}});
      adjustment_->groups[found->second].ties.push_back(*made);
      ++out_.sightings;
    }
  }
  report(progress_, "tracking", n, n);
  set_knots(keyframes);
  if (adjustment_->groups.empty() && !lost.empty()) {
    const auto commonest = std::max_element(
        lost.begin(), lost.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    out_.method_reason = "no frame could be tied to another (" + commonest->first + ")";
  }
  return {};
}

void Aligner::set_knots(const std::vector<int>& keyframes) {
  keyframes_ = keyframes;
  out_.keyframes = keyframes.size();
  auto& frames = adjustment_->frames;
  std::vector<double> times;
  const auto add = [&](double t_s) {
    if (times.empty() || t_s > times.back() + 1e-6) times.push_back(t_s);
  };
  add(frames.front().base_s);
  for (const int k : keyframes) add(frames[static_cast<std::size_t>(k)].base_s);
  add(frames.back().base_s);
  adjustment_->knot_times_s = times;
  for (AdjustedFrame& f : frames) {
    const auto after = std::upper_bound(times.begin(), times.end(), f.base_s + 1e-9);
    const auto i = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
        after - times.begin() - 1, 0, static_cast<std::ptrdiff_t>(times.size()) - 1));
    f.knot = static_cast<int>(i);
    f.weight = i + 1 < times.size()
                   ? std::clamp((f.base_s - times[i]) / (times[i + 1] - times[i]), 0.0, 1.0)
                   : 0.0;
    if (f.weight < 1e-6) f.weight = 0.0;
  }
  adjustment_->delay_knot_times_s.clear();
  if (delayed_) {
    const double first = frames.front().base_s, last = frames.back().base_s;
    const int pieces = std::max(1, static_cast<int>(std::lround((last - first) / kDelayKnots_s)));
    if (last - first < kDelayKnots_s) {
      adjustment_->delay_knot_times_s = {first};
    } else {
      for (int k = 0; k <= pieces; ++k)
        adjustment_->delay_knot_times_s.push_back(first + (last - first) * k / pieces);
    }
  }
}

void Aligner::find_start() {
  adjustment_->delay_start_s = given_delay_s_;
  adjustment_->reset();
  if (!delayed_) return;
  DelaySearch how;
  how.given_s = given_delay_s_;
  how.to_s = options_.parameters.max_delay_s;
  if (flight_.delay_s) {
    how.from_s = *flight_.delay_s - 0.3;
    how.to_s = *flight_.delay_s + 0.3;
  }
  adjustment_->delay_start_s = search_delay(*adjustment_, how).value_or(given_delay_s_);
  adjustment_->reset();
}

/// Where the recording does not say how good its poses are, several ideas of it are tried: exact
/// poses under uneven times look like bad poses under even ones, and small steps from one idea
/// do not lead to the other.
void Aligner::choose_navigation_sigma() {
  const PoseSigma& said = navigation_->typical_sigma();
  const bool known =
      said.position_north_east_down_m.norm() > 0 && said.roll_pitch_yaw_rad.norm() > 0;
  std::vector<std::function<void()>> ideas;
  for (const double scale : kNavigationIdeas)
    if (!known || scale == 1.0)
      ideas.emplace_back([this, scale] {
        adjustment_->priors.knot *= scale;
        solve(false);
        find_regular_clock();
      });
  choose(ideas, kSameNavigation);
}

/// Errors that wander within seconds, as an attitude filter's indoors, look like large slow ones,
/// which would leave the mount and the height too free: the evidence tells them apart. Leaves the
/// adjustment solved with its variances.
void Aligner::choose_correlation() {
  std::vector<std::function<void()>> ideas;
  for (const auto& [position_s, attitude_s] : kCorrelationIdeas_s)
    ideas.emplace_back([this, position = position_s, attitude = attitude_s] {
      adjustment_->priors.position_correlation_s = position;
      adjustment_->priors.attitude_correlation_s = attitude;
      solve(true);
    });
  choose(ideas, 0.0);
}

/// The last idea with as much evidence as any, to within `same` a tie; one whose errors of poses
/// have run away only for want of another.
void Aligner::choose(const std::vector<std::function<void()>>& ideas, double same) {
  const Snapshot start = snapshot();
  struct Outcome {
    bool holds;
    double evidence;
    Snapshot found;
  };
  std::vector<Outcome> outcomes;
  for (const auto& idea : ideas) {
    restore(start);
    idea();
    outcomes.push_back({!run_away(), adjustment_->log_evidence(), snapshot()});
  }
  const auto best =
      std::max_element(outcomes.begin(), outcomes.end(), [](const Outcome& a, const Outcome& b) {
        return std::pair(a.holds, a.evidence) < std::pair(b.holds, b.evidence);
      });
  const double enough = best->evidence - same * static_cast<double>(adjustment_->tie_count());
  const auto last = std::find_if(outcomes.rbegin(), outcomes.rend(), [&](const Outcome& o) {
    return o.holds == best->holds && o.evidence >= enough;
  });
  restore(last->found);
}

bool Aligner::run_away() const {
  const auto& a = *adjustment_;
  Eigen::Matrix<double, 6, 1> square = Eigen::Matrix<double, 6, 1>::Zero();
  for (const auto& knot : a.state.knots)
    square += Eigen::Map<const Eigen::Matrix<double, 6, 1>>(knot.data()).cwiseAbs2() /
              static_cast<double>(a.state.knots.size());
  return (square.array() > (kMostRunaway * a.priors.knot.array()).square()).any();
}

/// A camera runs evenly even where nothing counts its frames. Once the images have told when most
/// frames were taken, the grid they lie on tells it of all, and better.
void Aligner::find_regular_clock() {
  auto& a = *adjustment_;
  if (!delayed_ || !(a.priors.jitter_s > 0.0)) return;
  for (const AdjustedFrame& f : a.frames)
    if (!f.delayed || f.own) return;
  const auto known = a.knowledge();
  if (!known) return;
  std::vector<double> estimated, sigma;
  double mean_s = 0.0;
  for (const double d : a.state.delay_s) mean_s += d / static_cast<double>(a.state.delay_s.size());
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    estimated.push_back(a.time_s(static_cast<int>(k), a.state));
    // What was not told by images has kept the sigma it began with.
    const double s = known->jitter_sigma_s[k];
    sigma.push_back(s < 0.5 * a.priors.jitter_s ? s : std::numeric_limits<double>::infinity());
  }
  const auto slots = find_slots(estimated, sigma);
  if (!slots) return;
  const Snapshot before = snapshot();
  const double evidence_before = a.log_evidence();
  for (std::size_t k = 0; k < a.frames.size(); ++k)
    a.frames[k].base_s =
        slots->clock.start_s + slots->clock.period_s * static_cast<double>(slots->slot[k]) + mean_s;
  set_knots(keyframes_);
  a.delay_start_s = mean_s;
  if (a.knot_times_s.size() == before.state.knots.size() &&
      a.delay_knot_times_s.size() == before.state.delay_s.size()) {
    a.state = before.state;
    std::fill(a.state.delay_s.begin(), a.state.delay_s.end(), mean_s);
    std::fill(a.state.jitter_s.begin(), a.state.jitter_s.end(), 0.0);
  } else {
    a.reset();
  }
  a.priors.jitter_s = 0.0;
  // On a grid the delay is one number: what wandered is in the arrivals.
  a.priors.delay_walk_s = std::min(a.priors.delay_walk_s, kClockWalk_s);
  a.priors.delay_rate = slots->clock.rate_sigma;
  solve(false);
  if (a.log_evidence() > evidence_before) {
    clock_note_ = text(
        "The frames were taken every %.3f ms (no counter says so; their images do, to %.1f ms): "
        "%.0f ms of jitter in their arrivals was taken out.",
        1e3 * slots->clock.period_s, 1e3 * slots->residual_s, 1e3 * jitter_seen_s_);
    return;
  }
  restore(before);
}

Aligner::Snapshot Aligner::snapshot() const {
  const Adjustment& a = *adjustment_;
  return {a.frames, a.knot_times_s,  a.delay_knot_times_s, a.priors,
          a.state,  a.delay_start_s, clock_note_};
}

void Aligner::restore(const Snapshot& s) {
  Adjustment& a = *adjustment_;
  a.frames = s.frames;
  a.knot_times_s = s.knot_times_s;
  a.delay_knot_times_s = s.delay_knot_times_s;
  a.priors = s.priors;
  a.state = s.state;
  a.delay_start_s = s.delay_start_s;
  clock_note_ = s.clock_note;
}

void Aligner::solve(bool variances) {
  AdjustmentOptions o;
  o.rounds = 4;
  o.estimate_variances = variances;
  o.threads = options_.threads;
  const double started = thread_cpu_s();
  adjustment_->solve(o);
  out_.solving_s += thread_cpu_s() - started;
}

/// Where the camera hardly turns, most of the turning that the navigation reports is its own error.
/// What lessens the effect of turns in the picture (a mount far off, a long lever arm) would then
/// explain best why the picture shows none of it. So all that only turns can tell stays as given.
void Aligner::hold_what_nothing_tells() {
  const Excitation turning = excitation_of(*adjustment_);
  if (turning.tells()) return;
  held_ = true;
  hold_for_want_of_turns(*adjustment_, given_delay_s_);
  constexpr double kDegree = 180 / std::numbers::pi;
  out_.notes.push_back(
      text("The recorded attitude varies by %.2f°, and most of that (%.2f°) is its own error: so "
           "little turning tells neither the mount nor %s, which stay as they were given.",
           kDegree * std::sqrt(turning.recorded_rad2()), kDegree * std::sqrt(turning.error_rad2()),
           delayed_ ? "the delay" : "the lever arm"));
  choose_navigation_sigma();
}

/// Pictures that hardly move cannot tell an error that all of them share, however far it is drawn:
/// what all poses have in common is taken out of their errors, as far as places do not object. (In
/// straight flight they do object to the heading: it is the direction of motion.)
void Aligner::centre_errors() {
  AdjustmentState& state = adjustment_->state;
  const AdjustmentState full = state;
  const double before_m = judge(full).median_m;
  std::array<double, 6> mean{};
  for (const auto& knot : full.knots)
    for (std::size_t c = 0; c < 6; ++c) mean[c] += knot[c] / static_cast<double>(full.knots.size());
  for (const std::size_t components : {6, 5}) {  // with the heading, and without
    state = full;
    for (auto& knot : state.knots)
      for (std::size_t c = 0; c < components; ++c) knot[c] -= mean[c];
    if (judge(state).median_m <= kMostObjection * before_m) return;
  }
  state = full;
}

/// What has not become much better known than it was stays as given: what moves it then is what the
/// model does not know, not what the images show.
void Aligner::freeze_unobserved() {
  const auto known = adjustment_->knowledge();
  if (!known) return;
  AdjustmentOptions options;
  options.threads = options_.threads;
  const double started = thread_cpu_s();
  sigma_by_places_ = adjustment_->globals_sigma_by_places(options);
  out_.solving_s += thread_cpu_s() - started;
  auto& prior = adjustment_->priors.globals;
  bool frozen = false;
  for (int k = 0; k < Globals::kSize; ++k)
    if (prior[k] > 0.0 &&
        (std::max(known->globals_sigma[k], sigma_by_places_[k]) > kObserved * prior[k] ||
         std::abs(adjustment_->state.globals[k]) > kMostPriorSigmas * prior[k])) {
      prior[k] = 0.0;
      adjustment_->state.globals[k] = 0.0;
      frozen = true;
      held_ = held_ || k < Globals::kMount + 2;  // a tilt
    }
  if (frozen) solve(false);
}

void Aligner::revisit() {
  if (!options_.parameters.revisits || keyframes_.size() < 3) return;
  const auto made = make_registrar(RegistrationMethod::Klt);
  if (!made) return;
  const Registrar& registrar = **made;
  // How long places are followed without a gap: what that ties need not be tied again.
  double longest_s = 0.0;
  for (const TieGroup& g : adjustment_->groups)
    longest_s =
        std::max(longest_s, adjustment_->frames[static_cast<std::size_t>(g.frame)].base_s -
                                adjustment_->frames[static_cast<std::size_t>(g.host)].base_s);
  std::vector<Revisitable> list;
  const double half = 0.5 * std::min(flight_.camera.width_px(), flight_.camera.height_px()) /
                      flight_.camera.focal_px();
  for (const int k : keyframes_) {
    const ModelCamera camera = adjustment_->camera(k);
    const Eigen::Vector3d ray = camera.rotation * Eigen::Vector3d::UnitZ();
    if (!(ray.z() > 0.15)) continue;
    const Eigen::Vector2d middle =
        (camera.position_m - camera.position_m.z() / ray.z() * ray).head<2>();
    const double reach = -camera.position_m.z() / ray.z() * half;
    if (!list.empty() && (middle - list.back().middle_m).norm() < 0.4 * reach) continue;
    list.push_back({k, adjustment_->frames[static_cast<std::size_t>(k)].base_s, middle, reach});
  }
  const double apart_s = std::max(1.2 * longest_s, 2.0 * options_.parameters.keyframe_interval_s);
  auto pairs = revisit_pairs(list, apart_s, kMostRevisits);
  const double sigma_px = std::hypot(adjustment_->priors.knot.head<2>().norm(),
                                     adjustment_->priors.knot.segment<2>(3).norm() * height_m_) /
                          gsd_m_;
  const double reach_px = std::clamp(3.0 * sigma_px, 4.0, 40.0);

  std::map<int, Loaded> cache;
  constexpr std::size_t kCached = 300;
  const auto picture = [&](int k) -> const Loaded* {
    if (const auto found = cache.find(k); found != cache.end()) return &found->second;
    auto loaded = load(static_cast<std::size_t>(k));
    if (!loaded) return nullptr;
    constexpr int kSide_px = 1024;
    int more = 1;
    while (std::max(loaded->gray.cols, loaded->gray.rows) / more > kSide_px) ++more;
    if (more > 1) {
      const cv::Size size(loaded->gray.cols / more, loaded->gray.rows / more);
      cv::resize(loaded->gray(cv::Rect(0, 0, size.width * more, size.height * more)), loaded->gray,
                 size, 0, 0, cv::INTER_AREA);
      loaded->reduction *= more;
    }
    if (cache.size() >= kCached) cache.erase(cache.begin());
    return &(cache[k] = *std::move(loaded));
  };
  std::size_t done = 0;
  for (const RevisitPair& pair : pairs) {
    report(progress_, "revisits", done++, pairs.size());
    const auto b_from_a = expected(pair.a, pair.b);
    const Loaded* a = picture(pair.a);
    if (!a || !b_from_a) continue;
    const Loaded a_kept = *a;  // the cache may let go of it
    const Loaded* b = picture(pair.b);
    if (!b || b->reduction != a_kept.reduction) continue;
    const double started = thread_cpu_s();
    const auto found = find_again(a_kept.gray, b->gray, a_kept.reduction, *b_from_a, reach_px,
                                  registrar, kRevisitPoints);
    out_.tracking_s += thread_cpu_s() - started;
    const Eigen::Matrix2d revisit_covariance =
        Eigen::Matrix2d::Identity() * std::pow(kRevisit_px * b->reduction, 2);
    TieGroup group{pair.a, pair.b, true, 1.0, false, {}};
    int at = 0;
    for (const PixelPair& p : found) {
      if (!may_use(p.a) || !may_use(p.b)) continue;
      if (auto made_tie = geometry_.tie(p.a, p.b, revisit_covariance)) {
        made_tie->held_out = judges(at++);
        group.ties.push_back(*made_tie);
      }
    }
    if (group.ties.empty()) continue;
    adjustment_->groups.push_back(std::move(group));
    ++out_.revisits;
  }
}

TieStatistics Aligner::judge(const AdjustmentState& s) const {
  std::vector<double> metres, pixels;
  const Cameras cameras = adjustment_->cameras(s);
  for (const TieGroup& g : adjustment_->groups)
    for (const Tie& t : g.ties) {
      if (!t.held_out || t.whiten.determinant() < 1.0 / std::pow(kJudge_px * reduction_, 2))
        continue;
      const auto m = adjustment_->disagreement_m(g, t, cameras);
      const auto r = adjustment_->residual_px(g, t, cameras);
      if (!m || !r) continue;
      metres.push_back(*m);
      pixels.push_back(r->norm());
    }
  return {metres.size(), median(metres), median(metres, 0.9), median(pixels)};
}

/// How far poses and what is known from outside disagree on the sea: anchors, and at a picture's
/// edge the heights of the range finder.
double Aligner::known_disagreement_m() const {
  const Adjustment& a = *adjustment_;
  std::vector<double> points, heights;
  for (const KnownPoint& p : a.known_points)
    if (const auto e = anchor_error_m(a, p)) points.push_back(e->norm());
  for (const KnownHeight& h : a.known_heights)
    heights.push_back(std::abs(h.error_m - a.height_error_m(h.t_s, a.state)));
  const double edge = 0.5 * flight_.camera.width_px() / flight_.camera.focal_px();
  return std::max(median(points), edge * median(heights));
}

/// Anchors say where all of the flight lies. They come in when everything else is known: what they
/// are to be judged by, and a wrong one must not draw delay or mount after it.
void Aligner::use_anchors() {
  if (sighted_.empty()) return;
  auto& a = *adjustment_;
  const double said_m =
      navigation_->typical_sigma().position_north_east_down_m.head<2>().maxCoeff();
  const double sigma_m = said_m > 0 ? said_m : kOffsetSigma_m;
  const AnchorChoice choice = choose_anchors(a, sighted_, sigma_m);
  say_anchors(choice);
  if (choice.used.empty()) return;
  a.known_points = choice.used;
  // Relative errors of the navigation are no measure of what it is off by as a whole.
  a.priors.globals.segment<2>(Globals::kOffset).setConstant(sigma_m);
  globals_before_.segment<2>(Globals::kOffset).setConstant(sigma_m);
  a.state.globals.segment<2>(Globals::kOffset) = -choice.offset_m;
  whiten(a, a.known_points);
  solve(false);
}

void Aligner::say_anchors(const AnchorChoice& choice) {
  out_.anchors.clear();
  for (const Anchor& anchor : flight_.anchors) {
    AnchorOutcome outcome;
    outcome.name = anchor.name;
    outcome.sightings = anchor.sightings.size();
    out_.anchors.push_back(std::move(outcome));
  }
  for (const KnownPoint& p : choice.used) ++out_.anchors[p.anchor].used;
  for (const AnchorChoice::Rejected& r : choice.rejected) {
    AnchorOutcome& outcome = out_.anchors[r.point.anchor];
    const std::string& frame = flight_.anchors[r.point.anchor].sightings[r.point.sighting].frame;
    std::string why =
        choice.undecided
            ? text(
                  "it and another anchor contradict each other by metres, and nothing tells which "
                  "is wrong")
        : choice.against_navigation
            ? text(
                  "in %s it lies %.1f m (%.0f px) from where the navigation puts it, more than "
                  "five times what that may be off by",
                  frame.c_str(), r.off_m, r.off_px)
            : text("in %s it lies %.1f m (%.0f px) from where the others put it", frame.c_str(),
                   r.off_m, r.off_px);
    if (outcome.left_out.empty()) outcome.left_out = std::move(why);
  }
  for (const AnchorOutcome& outcome : out_.anchors)
    if (!outcome.left_out.empty())
      out_.notes.push_back("Anchor " + outcome.name + ": " +
                           (outcome.used == 0
                                ? std::string("left out")
                                : text("%d of its %d sightings left out",
                                       static_cast<int>(outcome.sightings - outcome.used),
                                       static_cast<int>(outcome.sightings))) +
                           ": " + outcome.left_out + "; check its place and its pixels.");
}

/// What became of anchors and ranges, at the state that is returned.
void Aligner::write_known(const AdjustmentState& given) {
  auto& a = *adjustment_;
  const AdjustmentState after = a.state;
  const auto look = [&](const AdjustmentState& s, Eigen::Vector2d AnchorOutcome::*mean,
                        double AnchorOutcome::*rms) {
    a.state = s;
    for (const KnownPoint& p : a.known_points) {
      AnchorOutcome& o = out_.anchors[p.anchor];
      const auto e = anchor_error_m(a, p);
      if (!e) continue;
      o.*mean += *e / static_cast<double>(o.used);
      o.*rms += e->squaredNorm() / static_cast<double>(o.used);
    }
    for (AnchorOutcome& o : out_.anchors) o.*rms = std::sqrt(o.*rms);
    std::vector<double> heights;
    for (const KnownHeight& h : a.known_heights)
      heights.push_back(h.error_m - a.height_error_m(h.t_s, s));
    return median(heights);
  };
  out_.ranges.ranges = flight_.ranges.size();
  for (const KnownHeight& h : a.known_heights) out_.ranges.used += h.samples;
  out_.ranges.as_given_m = look(given, &AnchorOutcome::as_given_m, &AnchorOutcome::as_given_rms_m);
  out_.ranges.after_m = look(after, &AnchorOutcome::after_m, &AnchorOutcome::after_rms_m);
  a.state = after;
  const bool full = out_.method == AlignMethod::Full;
  for (const AnchorOutcome& o : out_.anchors)
    if (o.used > 0)
      out_.notes.push_back(
          full ? text("Anchor %s was used, seen in %d frames: they put it %.2f m from where it is, "
                      "as given %.2f m. It shows the offset that all frames share.",
                      o.name.c_str(), static_cast<int>(o.used), o.after_rms_m, o.as_given_rms_m)
               : text("Anchor %s is %.2f m from where the frames put it; it was not used.",
                      o.name.c_str(), o.as_given_rms_m));
  if (out_.ranges.used > 0)
    out_.notes.push_back(text(
        "A range finder measured the height %d times: the recorded heights are %.2f m too %s by "
        "it, after alignment %.2f m.",
        static_cast<int>(out_.ranges.used), std::abs(out_.ranges.as_given_m),
        out_.ranges.as_given_m > 0 ? "low" : "high", std::abs(out_.ranges.after_m)));
}

void Aligner::finish() {
  auto& a = *adjustment_;
  if (!clock_note_.empty()) out_.notes.push_back(clock_note_);
  const AdjustmentState full = a.state;
  double mean_delay_s = 0.0;
  for (const double d : full.delay_s) mean_delay_s += d / static_cast<double>(full.delay_s.size());
  const AdjustmentState given = without_errors(a, given_delay_s_);
  const AdjustmentState constant = without_errors(a, mean_delay_s);
  out_.as_given = judge(given);
  out_.constant_delay = delayed_ ? judge(constant) : out_.as_given;
  out_.after = judge(full);
  out_.pixel_sigma = out_.after.median_px / kMedianOfTwo;
  out_.method = AlignMethod::Full;
  const double best = std::min(out_.as_given.median_m, out_.constant_delay.median_m);
  // Known points are evidence as well, but not at the price of frames that no longer fit together:
  // ties may lose half of what known points win, and no more than they were apart. Without ties
  // they do not tell a delay.
  const auto known_at = [&](const AdjustmentState& s) {
    a.state = s;
    const double m = known_disagreement_m();
    a.state = full;
    return m;
  };
  const bool constant_better = delayed_ && out_.constant_delay.median_m < out_.as_given.median_m;
  const double known_gain_m = known_at(constant_better ? constant : given) - known_at(full);
  const bool timed = !delayed_ || flight_.delay_s;
  if (out_.after.ties < 10 && known_gain_m > 0 && timed) {
    out_.method_reason.clear();
  } else if (out_.after.ties < 10) {
    out_.method = AlignMethod::AsGiven;
    out_.method_reason = text(
        "only %d places were seen in more than one frame; at least 10 must "
        "be there to judge by",
        static_cast<int>(out_.after.ties));
  } else if (out_.after.median_m - best > std::min(0.5 * std::max(0.0, known_gain_m), best)) {
    out_.method = constant_better ? AlignMethod::ConstantDelay : AlignMethod::AsGiven;
    out_.method_reason = text(
        "places that took no part disagree by %.3f m after the full "
        "adjustment, and by %.3f m without it",
        out_.after.median_m, best);
  }
  if (out_.method == AlignMethod::AsGiven) a.state = given;
  if (out_.method == AlignMethod::ConstantDelay) a.state = constant;
  if (out_.method != AlignMethod::Full) out_.after = judge(a.state);
  std::optional<Adjustment::Knowledge> known;
  if (out_.method == AlignMethod::Full) known = a.knowledge();
  if (known) known->globals_sigma = known->globals_sigma.cwiseMax(sigma_by_places_);
  write_known(given);
  write_estimates(known);
  write_frames(known);
}

void Aligner::write_estimates(const std::optional<Adjustment::Knowledge>& known) {
  const auto& a = *adjustment_;
  out_.estimates = estimates_of(flight_, a, globals_before_, known ? &*known : nullptr);
  // The poses' covariances hold what is left of the mount's uncertainty.
  out_.mount = corrected_mount(flight_.mount, a, known ? &*known : nullptr);
  out_.focal_scale = 1.0 + a.state.globals[Globals::kFocal];
  out_.navigation_sigma.position_north_east_down_m = a.priors.knot.head<3>();
  out_.navigation_sigma.roll_pitch_yaw_rad = a.priors.knot.tail<3>();
  if (known) out_.shared_covariance_m2 = known->shared_m2;
  out_.delay_estimated = delayed_ && out_.method != AlignMethod::AsGiven;
  if (out_.delay_estimated)
    for (std::size_t k = 0; k < a.state.delay_s.size(); ++k)
      out_.delay.push_back(
          {navigation_->epoch() + seconds(a.delay_knot_times_s[k]), a.state.delay_s[k],
           known && k < known->delay_sigma_s.size() ? known->delay_sigma_s[k] : 0});
}

void Aligner::write_frames(const std::optional<Adjustment::Knowledge>& known) {
  auto& a = *adjustment_;
  std::vector<std::size_t> ties(a.frames.size(), 0);
  for (const TieGroup& g : a.groups)
    for (const int f : {g.host, g.frame}) ties[static_cast<std::size_t>(f)] += g.ties.size();
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    const ImageFrame& f = flight_.frames[of_[k]];
    const int frame = static_cast<int>(k);
    const ModelPlatform platform = a.platform(frame);
    if (!a.frames[k].own && !navigation_->covers(platform.t_s)) {
      out_.left_out.push_back({f.name, "no poses bracket its time less the delay"});
      continue;
    }
    FrameWriting how;
    how.local = &*local_;
    how.gimbal_reference = flight_.gimbal_reference;
    Time captured = navigation_->epoch() + seconds(platform.t_s);
    if (f.captured_at && !a.frames[k].own) captured = *f.captured_at;
    if (a.frames[k].own) captured = f.own_pose->time;
    if (const auto at = flight_.trajectory.at(captured, Duration::max()); a.frames[k].own)
      how.recorded = f.own_pose->world_from_body;
    else if (at)
      how.recorded = at->world_from_body;
    if (known && k < known->camera.size()) {
      how.covariance = known->camera[k];
    } else {
      how.covariance.diagonal() = a.priors.knot.cwiseAbs2();
      for (int c = 0; c < 3; ++c)
        how.covariance(3 + c, 3 + c) += std::pow(globals_before_[Globals::kMount + c], 2);
    }
    how.shared_m2 = out_.shared_covariance_m2;
    auto made = aligned_frame(a, frame, how);
    if (!made) {
      out_.left_out.push_back({f.name, made.error().message});
      continue;
    }
    made->index = of_[k];
    made->captured = made->pose.time = captured;
    made->delay_s = a.frames[k].delayed ? received_s_[k] - platform.t_s : 0.0;
    made->ties = ties[k];
    out_.frames.push_back(*std::move(made));
  }
  std::stable_sort(
      out_.frames.begin(), out_.frames.end(),
      [](const AlignedFrame& x, const AlignedFrame& y) { return x.captured < y.captured; });
}

Result<Alignment> Aligner::run() {
  WATERSKY_CHECK(list_frames());
  if (of_.empty()) {
    out_.method_reason = "no frame has both a time and poses around it";
    return std::move(out_);
  }
  set_priors();
  use_clock();
  adjustment_->knot_times_s = {0.0};
  adjustment_->delay_start_s = flight_.delay_s.value_or(0.2);
  if (delayed_) adjustment_->delay_knot_times_s = {0.0};
  // Tracking asks where the next frame should be: by even times, or jitter would point elsewhere.
  // A camera runs evenly whatever its arrivals do.
  if (delayed_ && adjustment_->priors.jitter_s > 0.0) {
    std::vector<double> bases;
    for (const AdjustedFrame& f : adjustment_->frames) bases.push_back(f.base_s);
    const std::vector<double> even = even_times(bases);
    for (std::size_t k = 0; k < even.size(); ++k)
      if (adjustment_->frames[k].delayed) adjustment_->frames[k].base_s = even[k];
    jitter_seen_s_ = adjustment_->priors.jitter_s;
    adjustment_->priors.jitter_s *= kLeftAfterEvening;
  }
  adjustment_->reset();
  // Where windows lie in a frame, and how they are turned, is told by the poses: those of a delay
  // that is a tenth of a second off would draw them aside. So a first look is for the delay alone.
  if (delayed_ && !flight_.delay_s) {
    WATERSKY_CHECK(track(kFirstLook));
    find_start();
    out_.method_reason.clear();
    const double delay_s = adjustment_->delay_start_s;
    adjustment_->knot_times_s = {0.0};
    adjustment_->delay_knot_times_s = {0.0};
    for (AdjustedFrame& f : adjustment_->frames) f.knot = 0, f.weight = 0.0;
    adjustment_->reset();
    adjustment_->state.delay_s = {delay_s};
  }
  WATERSKY_CHECK(track(of_.size()));
  find_start();
  if (!adjustment_->groups.empty()) {
    report(progress_, "adjusting", 0, 3);
    choose_navigation_sigma();
    hold_what_nothing_tells();
    if (delayed_) {
      // Now that time is known windows can be laid right.
      const AdjustmentState told = adjustment_->state;
      WATERSKY_CHECK(track(of_.size()));
      adjustment_->reset();
      adjustment_->state.globals = told.globals;
      adjustment_->state.jitter_s = told.jitter_s;
      for (double& d : adjustment_->state.delay_s)
        d = std::accumulate(told.delay_s.begin(), told.delay_s.end(), 0.0) /
            static_cast<double>(told.delay_s.size());
      set_navigation_priors(adjustment_->priors, navigation_->typical_sigma(), height_m_);
      choose_navigation_sigma();
    }
    choose_correlation();
    find_regular_clock();
    report(progress_, "adjusting", 1, 3);
    revisit();
    if (out_.revisits > 0) solve(true);
    find_regular_clock();
    report(progress_, "adjusting", 2, 3);
    use_anchors();
    freeze_unobserved();
    if (held_) centre_errors();
    adjustment_->solve_frames();
    report(progress_, "adjusting", 3, 3);
  } else if (!sighted_.empty() || !adjustment_->known_heights.empty()) {
    solve(false);
    use_anchors();
    freeze_unobserved();
  }
  finish();
  return std::move(out_);
}

}  // namespace
}  // namespace align

Result<Alignment> align_flight(const Flight& flight, const AlignOptions& options,
                               const Progress& progress) {
  WATERSKY_CHECK(validate(options.parameters));
  if (options.parameters.causal) return align_flight_causally(flight, options, progress);
  return align::Aligner(flight, options, progress).run();
}

}  // namespace watersky
