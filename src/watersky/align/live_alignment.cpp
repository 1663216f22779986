// SPDX-License-Identifier: MIT
#include "watersky/align/live_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>

#include "watersky/align/detail/aligned_frame.hpp"
#include "watersky/align/detail/capture_clock.hpp"
#include "watersky/align/detail/delay_search.hpp"
#include "watersky/align/detail/estimates.hpp"
#include "watersky/align/detail/median.hpp"
#include "watersky/align/detail/sighting_geometry.hpp"
#include "watersky/align/detail/starting_priors.hpp"
#include "watersky/align/detail/tracker.hpp"
#include "watersky/base/cpu_time.hpp"

namespace watersky {

namespace {

using namespace align;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kWindow = 25;  ///< keyframes that are adjusted together
/// Places are hosted anew before their host leaves the window.
constexpr double kHostedShare = 0.8;
constexpr std::size_t kLeastToStart = 10;  ///< keyframes
constexpr std::size_t kSearchEvery = 5, kVariancesEvery = 5;
constexpr std::size_t kSearchPairs = 60;
constexpr std::size_t kJudged = 400, kLeastJudged = 10;  ///< ties
constexpr std::size_t kMostPending = 90;                 ///< frames that wait for poses
/// A new idea of the poses' sigmas is followed by this share of its logarithm.
constexpr double kFollowed = 0.3;
constexpr double kPosesKept_s = 5.0;

/// How far the last ones were apart.
class Lately {
 public:
  void add(double metres, double pixels) {
    m_.push_back(metres);
    px_.push_back(pixels);
    if (m_.size() > kJudged) m_.pop_front(), px_.pop_front();
  }
  [[nodiscard]] TieStatistics statistics() const {
    return {m_.size(), of(m_, 0.5), of(m_, 0.9), of(px_, 0.5)};
  }

 private:
  static double of(const std::deque<double>& values, double share) {
    return median({values.begin(), values.end()}, share);
  }
  std::deque<double> m_, px_;
};

}  // namespace

class LiveAligner::Impl {
 public:
  Impl(const Flight& setup, const AlignOptions& options)
      : setup_(setup),
        options_(options),
        geometry_(setup.camera),
        registrar_(make_registrar(RegistrationMethod::Klt)),
        tracker_(tracker_options(options), registrar_ ? registrar_->get() : nullptr),
        given_delay_s_(setup.delay_s.value_or(0.0)) {
    setup_.frames.clear();
  }

  Status add_pose(const StampedPose& pose);
  Status add_gimbal(const StampedRotation& rotation);
  void add_frame(std::size_t id, const FrameStamps& stamps, const cv::Mat& picture, int reduction);
  std::vector<LiveFrame> take(bool all);
  LiveStatus status() const;
  [[nodiscard]] const Adjustment* adjustment() const {
    return adjustment_ ? &*adjustment_ : nullptr;
  }

 private:
  struct Waiting {
    std::size_t id;
    FrameStamps stamps;
    cv::Mat picture;
    int reduction;
    AdjustedFrame frame;
    double received_s;
  };
  static TrackerOptions tracker_options(const AlignOptions& options) {
    TrackerOptions o;
    o.points = options.parameters.tracked_points;
    o.keyframe_interval_s = options.parameters.keyframe_interval_s;
    o.longest_host_s =
        kHostedShare * static_cast<double>(kWindow) * options.parameters.keyframe_interval_s;
    return o;
  }

  Status start_navigation(const StampedPose& pose);
  [[nodiscard]] double expected_delay_s(const AdjustedFrame& frame) const;
  void rebase();
  LiveFrame process(Waiting& waiting);
  void see(int index, int number, Waiting& waiting, Tracker::Step& step,
           std::vector<TieGroup>& groups);
  void keyframe(std::vector<TieGroup> groups);
  void begin();
  void release();
  /// How far the mean delay may wander, per root second.
  [[nodiscard]] double delay_walk_s() const {
    const double said_s = options_.parameters.delay_walk_s;
    const auto& clock = clock_.regular();
    return clock ? clock->walk_s(std::min(said_s, kClockWalk_s), window_s()) : said_s;
  }
  [[nodiscard]] double window_s() const {
    return static_cast<double>(kWindow) * options_.parameters.keyframe_interval_s;
  }
  void solve_window(bool cold, bool variances);
  void judge();
  Result<AlignedFrame> write(int index, const Waiting& waiting, const Matrix6& own);

  Flight setup_;
  AlignOptions options_;
  SightingGeometry geometry_;
  Result<std::unique_ptr<Registrar>> registrar_;
  Tracker tracker_;
  double given_delay_s_;
  std::optional<LocalFrame> local_;
  std::optional<Navigation> navigation_;
  std::optional<Adjustment> adjustment_;
  std::deque<StampedPose> recorded_;  ///< for a gimbal against north, east, down
  ArrivalClock clock_;
  std::deque<Waiting> waiting_;
  std::vector<LiveFrame> dropped_;

  /// Of each frame in the window: the tracker's number, and what its base time is made from.
  struct InWindow {
    int number;
    double received_s;
    std::optional<std::uint64_t> counter;
  };
  std::vector<InWindow> window_;
  int next_number_ = 0;
  std::optional<ModelCamera> previous_;
  bool delayed_ = false, started_ = false;
  bool held_ = false;  ///< mount and delay, until the camera has turned
  double free_delay_sigma_s_ = 0.0;
  Excitation turning_;
  std::optional<Adjustment::Knowledge> known_;
  Lately full_, constant_, given_;
  AlignMethod method_ = AlignMethod::AsGiven;
  std::size_t frames_ = 0, keyframes_ = 0, sightings_ = 0;
  Globals::Vector globals_before_ = Globals::Vector::Zero();
  double tracking_s_ = 0.0, solving_s_ = 0.0, longest_solve_s_ = 0.0;
  std::vector<std::string> notes_;
};

Status LiveAligner::Impl::start_navigation(const StampedPose& pose) {
  local_.emplace(setup_.datum, *setup_.sea_level,
                 setup_.datum.geodetic(pose.world_from_body.origin()));
  navigation_.emplace(pose.time, options_.parameters.align_max_pose_gap_s);
  adjustment_.emplace(*navigation_, setup_.mount, setup_.camera.focal_px(), setup_.readout_s);
  return {};
}

Status LiveAligner::Impl::add_pose(const StampedPose& pose) {
  if (!navigation_) WATERSKY_CHECK(start_navigation(pose));
  WATERSKY_CHECK(navigation_->add(setup_, *local_, pose));
  // Poses alone do not pile up while no frame comes in.
  if (adjustment_->frames.empty() && waiting_.empty())
    navigation_->forget_before(navigation_->until_s() - options_.parameters.max_delay_s -
                               kPosesKept_s);
  if (setup_.gimbal_reference == GimbalReference::NorthEastDown) {
    recorded_.push_back(pose);
    while (to_seconds(pose.time - recorded_.front().time) > kPosesKept_s) recorded_.pop_front();
  }
  return {};
}

Status LiveAligner::Impl::add_gimbal(const StampedRotation& rotation) {
  if (!navigation_) return {};  // of a time before any pose
  return navigation_->add(rotation);
}

double LiveAligner::Impl::expected_delay_s(const AdjustedFrame& frame) const {
  if (!frame.delayed) return 0.0;
  return started_ && !adjustment_->state.delay_s.empty() ? adjustment_->state.delay_s.front()
                                                         : given_delay_s_;
}

/// The regular clock has moved: frames are dated anew, and the delay holds their times where they
/// were on average.
void LiveAligner::Impl::rebase() {
  Adjustment& a = *adjustment_;
  double shift = 0.0;
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const double base = clock_.base_s(window_[i].received_s, window_[i].counter);
    shift += (base - a.frames[i].base_s) / static_cast<double>(a.frames.size());
    a.frames[i].base_s = a.knot_times_s[i] = base;
  }
  for (Waiting& w : waiting_)
    if (w.frame.delayed) w.frame.base_s = clock_.base_s(w.received_s, w.stamps.counter);
  const bool was_uneven = a.priors.jitter_s > 0.0;
  a.priors.jitter_s = clock_.jitter_s();
  if (was_uneven && clock_.regular()) notes_.push_back(counted_note(*clock_.regular()));
  if (!held_) a.priors.delay_walk_s = delay_walk_s();
  if (!started_) return;
  for (double& d : a.state.delay_s) d += shift;
  a.delay_start_s += shift;
  if (was_uneven != (a.priors.jitter_s > 0.0)) {
    a.before_first.reset();  // it is of other unknowns
    std::fill(a.state.jitter_s.begin(), a.state.jitter_s.end(), 0.0);
    if (!a.state.delay_s.empty()) a.delay_start_s = a.state.delay_s.front();
  } else if (a.before_first) {
    const Eigen::Index delay = 6 + (a.priors.jitter_s > 0.0 ? 1 : 0);
    a.before_first->mean[delay] += shift;
  }
}

void LiveAligner::Impl::add_frame(std::size_t id, const FrameStamps& stamps, const cv::Mat& picture,
                                  int reduction) {
  ++frames_;
  const auto refuse = [&](std::string why) {
    dropped_.push_back({id, Error{ErrorCode::OutOfRange, std::move(why)}, AlignMethod::AsGiven});
  };
  if (!navigation_ && stamps.own_pose) {
    if (const Status begun = start_navigation(*stamps.own_pose); !begun.ok())
      return refuse(begun.error().message);
  }
  if (!navigation_) return refuse("no pose has come in yet");
  Waiting w{id, stamps, picture, reduction, {}, 0.0};
  if (stamps.own_pose && (!setup_.gimbal_reference || stamps.own_gimbal)) {
    auto still = Navigation::still(setup_, *local_, *stamps.own_pose, stamps.own_gimbal);
    if (!still) return refuse(still.error().message);
    w.frame.base_s = navigation_->since_epoch_s(stamps.own_pose->time);
    w.frame.own = *still;
  } else if (stamps.captured_at) {
    w.frame.base_s = navigation_->since_epoch_s(*stamps.captured_at);
  } else if (stamps.received_at) {
    w.received_s = navigation_->since_epoch_s(*stamps.received_at);
    w.frame.delayed = delayed_ = true;
    if (clock_.add(w.received_s, stamps.counter)) rebase();
    if (!clock_.regular()) adjustment_->priors.jitter_s = clock_.jitter_s();
    w.frame.base_s = clock_.base_s(w.received_s, stamps.counter);
  } else {
    return refuse("it has neither a capture time nor an arrival time");
  }
  waiting_.push_back(std::move(w));
  if (waiting_.size() > kMostPending) {
    Waiting& oldest = waiting_.front();
    dropped_.push_back(
        {oldest.id,
         Error{ErrorCode::OutOfRange, "no poses came in for its time while " +
                                          std::to_string(kMostPending) + " more frames did"},
         AlignMethod::AsGiven});
    waiting_.pop_front();
  }
}

std::vector<LiveFrame> LiveAligner::Impl::take(bool all) {
  std::vector<LiveFrame> out = std::move(dropped_);
  dropped_.clear();
  while (!waiting_.empty()) {
    Waiting& next = waiting_.front();
    if (!next.frame.own) {
      const double t_s = next.frame.base_s - expected_delay_s(next.frame);
      const double slack_s = next.frame.delayed ? 2.0 * adjustment_->priors.jitter_s : 0.0;
      if (!all && navigation_->until_s() < t_s + slack_s) break;
      if (!navigation_->covers(t_s)) {
        const bool early = navigation_->until_s() < t_s;
        out.push_back({next.id,
                       Error{ErrorCode::OutOfRange,
                             early ? "no pose came in after its time"
                                   : "no poses bracket its time, or they are too far apart"},
                       AlignMethod::AsGiven});
        waiting_.pop_front();
        continue;
      }
    }
    out.push_back(process(next));
    waiting_.pop_front();
  }
  return out;
}

/// Follows places into the frame at `index` and ties it to the window's.
void LiveAligner::Impl::see(int index, int number, Waiting& waiting, Tracker::Step& step,
                            std::vector<TieGroup>& groups) {
  const Adjustment& a = *adjustment_;
  std::map<int, int> index_of;  // of the tracker's numbers
  for (std::size_t i = 0; i < window_.size(); ++i)
    index_of[window_[i].number] = static_cast<int>(i);
  const ModelCamera camera = a.camera(index);
  std::map<int, Eigen::Matrix3d> plane;
  const auto local_map = [&](int host, const Eigen::Vector2d& px) -> Eigen::Matrix2d {
    auto found = plane.find(host);
    if (found == plane.end()) {
      const auto at = index_of.find(host);
      const auto h =
          at == index_of.end() ? std::nullopt : plane_homography(a.camera(at->second), camera);
      found = plane.emplace(host, h.value_or(Eigen::Matrix3d::Identity())).first;
    }
    return geometry_.step_between(found->second, px);
  };
  cv::Mat valid;
  if (!options_.camera_mask.empty())
    cv::resize(options_.camera_mask, valid, waiting.picture.size(), 0, 0, cv::INTER_NEAREST);
  auto tracked = tracker_.add(
      number, a.frames[static_cast<std::size_t>(index)].base_s, waiting.picture, waiting.reduction,
      valid, previous_ ? geometry_.expected(*previous_, camera) : std::nullopt, local_map);
  if (!tracked) return;
  step = *std::move(tracked);
  std::map<int, std::size_t> group_of;
  for (const Sighting& s : step.sightings) {
    const auto host = index_of.find(s.host);
    if (host == index_of.end()) continue;
    auto made = geometry_.tie(s.host_px, s.px, s.covariance_px2);
    if (!made) continue;
    made->track = s.track;
    made->held_out = judges(s.track);
    const auto [found, is_new] = group_of.try_emplace(host->second, groups.size());
    if (is_new) groups.push_back({host->second, index, false, 1.0, false, {}});
    groups[found->second].ties.push_back(*made);
    ++sightings_;
  }
}

LiveFrame LiveAligner::Impl::process(Waiting& waiting) {
  Adjustment& a = *adjustment_;
  const double started_s = thread_cpu_s();
  if (a.knot_times_s.empty()) {
    // What the poses' sigmas and the height are is known with the first frame.
    const NavigationSample at =
        waiting.frame.own ? *waiting.frame.own : navigation_->at(waiting.frame.base_s);
    const double jitter_s = a.priors.jitter_s;
    a.priors = starting_priors(setup_, options_.parameters, navigation_->typical_sigma(),
                               std::max(1e-3, -at.position_m.z()));
    a.priors.globals[Globals::kFocal] = 0.0;  // poses are told apart from the calibration
    globals_before_ = a.priors.globals;
    a.priors.jitter_s = jitter_s;
    a.priors.delay_walk_s = delay_walk_s();
    if (delayed_) {
      a.delay_knot_times_s = {0.0};
      a.delay_start_s = given_delay_s_;
    }
    a.reset();
    a.state.delay_s.assign(a.delay_knot_times_s.size(), given_delay_s_);
  }
  const int index = static_cast<int>(a.frames.size());
  const bool very_first = a.frames.empty();
  AdjustedFrame frame = waiting.frame;
  frame.knot = std::max(0, index - 1);
  a.frames.push_back(frame);
  a.state.jitter_s.push_back(0.0);
  a.state.extra.push_back({});
  if (very_first) {
    a.state.knots.push_back({});
    a.knot_times_s.push_back(frame.base_s);
  }
  const int number = next_number_++;
  Tracker::Step step;
  std::vector<TieGroup> groups;
  const double tracking_s = thread_cpu_s();
  see(index, number, waiting, step, groups);
  const double solving_s = thread_cpu_s();
  tracking_s_ += solving_s - tracking_s;

  Matrix6 own = Matrix6::Zero();
  const auto i = static_cast<std::size_t>(index);
  const bool was_started = started_;
  if (started_ && !very_first) {
    std::vector<const TieGroup*> of_frame;
    for (const TieGroup& g : groups) of_frame.push_back(&g);
    const double since_s = std::max(0.02, frame.base_s - a.knot_times_s[i - 1]);
    Eigen::Matrix<double, 6, 1> sigma;
    for (int c = 0; c < 6; ++c)
      sigma[c] =
          a.priors.knot[c] * std::sqrt(1.0 - std::exp(-2.0 * since_s /
                                                      (c < 3 ? a.priors.position_correlation_s
                                                             : a.priors.attitude_correlation_s)));
    own = a.solve_frame(index, of_frame, sigma, frame.delayed ? a.priors.jitter_s : 0.0, true);
  }
  bool kept = very_first;
  if (step.keyframe || very_first) {
    if (!very_first) {
      auto knot = a.state.knots.back();
      for (std::size_t c = 0; c < 6; ++c) knot[c] += a.state.extra.back()[c];
      a.state.knots.push_back(knot);
      a.knot_times_s.push_back(frame.base_s);
    }
    a.state.extra.back() = {};
    a.frames.back().knot = index;
    window_.push_back({number, waiting.received_s, waiting.stamps.counter});
    keyframe(std::move(groups));
    kept = true;
  }
  const int now_at = static_cast<int>(a.frames.size()) - 1;
  LiveFrame out{waiting.id, write(now_at, waiting, own), method_};
  previous_ = a.camera(now_at);
  if (!kept) {
    a.frames.pop_back();
    a.state.jitter_s.pop_back();
    a.state.extra.pop_back();
  }
  if (navigation_ && frame.base_s > kPosesKept_s)
    navigation_->forget_before(a.frames.front().base_s - options_.parameters.max_delay_s - 1.0);
  const double ended_s = thread_cpu_s();
  const double solved_s = (tracking_s - started_s) + (ended_s - solving_s);
  solving_s_ += solved_s;
  if (was_started) longest_solve_s_ = std::max(longest_solve_s_, solved_s);
  return out;
}

void LiveAligner::Impl::keyframe(std::vector<TieGroup> groups) {
  Adjustment& a = *adjustment_;
  ++keyframes_;
  for (TieGroup& g : groups) a.groups.push_back(std::move(g));
  while (a.frames.size() > kWindow) {
    const double dt = std::max(0.0, a.frames[1].base_s - a.frames[0].base_s);
    a.forget_first(a.priors.delay_walk_s * std::sqrt(dt));
    if (!started_) a.before_first.reset();
    window_.erase(window_.begin());
  }
  if (!started_) {
    begin();
  } else {
    turning_.add(a, static_cast<int>(a.frames.size()) - 1);
    if (held_ && turning_.tells()) release();
    solve_window(false, keyframes_ % kVariancesEvery == 0);
  }
  if (started_) judge();
}

/// Looks for the delay, where one is to be found, and begins.
void LiveAligner::Impl::begin() {
  Adjustment& a = *adjustment_;
  if (a.frames.size() < kLeastToStart || keyframes_ % kSearchEvery != 0 || a.groups.empty()) return;
  if (delayed_) {
    if (!clock_.settled()) return;
    DelaySearch how;
    how.given_s = given_delay_s_;
    how.to_s = options_.parameters.max_delay_s;
    how.most_pairs = kSearchPairs;
    if (setup_.delay_s) {
      how.from_s = given_delay_s_ - 0.3;
      how.to_s = given_delay_s_ + 0.3;
    }
    const auto found = search_delay(a, how);
    // A delay that was given needs no valley.
    if (!found && !setup_.delay_s) return;
    a.delay_start_s = found.value_or(given_delay_s_);
    a.state.delay_s.assign(1, a.delay_start_s);
  }
  started_ = true;
  const PoseSigma& said = navigation_->typical_sigma();
  const bool known =
      said.position_north_east_down_m.norm() > 0 && said.roll_pitch_yaw_rad.norm() > 0;
  const AdjustmentState state = a.state;
  const AdjustmentPriors priors = a.priors;
  double best = -std::numeric_limits<double>::infinity();
  AdjustmentState best_state = state;
  AdjustmentPriors best_priors = priors;
  for (const double scale : kNavigationIdeas) {
    if (known && scale != 1.0) continue;
    a.state = state;
    a.priors = priors;
    a.priors.knot *= scale;
    solve_window(true, false);
    // Ideas are in order: see kSameNavigation.
    const double evidence = a.log_evidence();
    if (evidence >= best - kSameNavigation * static_cast<double>(a.tie_count())) {
      best = std::max(best, evidence);
      best_state = a.state;
      best_priors = a.priors;
    }
  }
  a.state = best_state;
  a.priors = best_priors;
  for (std::size_t i = 0; i < a.frames.size(); ++i) turning_.add(a, static_cast<int>(i));
  if (!turning_.tells()) {
    held_ = true;
    notes_.emplace_back(
        "The camera has hardly turned yet: mount and delay stay as they were given or first seen.");
    const Eigen::Matrix<double, 6, 1> sigma = a.priors.knot;
    const double delay_s = delayed_ ? a.delay_start_s : 0.0;
    a.priors = priors;
    a.priors.knot = sigma;
    free_delay_sigma_s_ = a.priors.delay_s;
    hold_for_want_of_turns(a, delay_s);
    solve_window(true, false);
  }
  solve_window(false, false);
}

/// The camera has turned enough to tell the mount and the delay.
void LiveAligner::Impl::release() {
  Adjustment& a = *adjustment_;
  held_ = false;
  notes_.emplace_back("The camera has turned enough to tell mount and delay.");
  a.priors.globals = globals_before_;
  a.priors.delay_s = free_delay_sigma_s_;
  a.priors.delay_walk_s = delay_walk_s();
  if (!a.state.delay_s.empty()) a.delay_start_s = a.state.delay_s.front();
  a.before_first.reset();  // it is of fewer unknowns
  solve_window(true, false);
}

void LiveAligner::Impl::solve_window(bool cold, bool variances) {
  Adjustment& a = *adjustment_;
  AdjustmentOptions o;
  o.rounds = cold ? 4 : variances ? 2 : 1;
  o.iterations = cold ? 15 : 4;
  o.warm = !cold;
  o.estimate_variances = variances && !cold;
  const Eigen::Matrix<double, 6, 1> sigma = a.priors.knot;
  const double jitter_s = a.priors.jitter_s;
  a.solve(o);
  if (variances) {
    a.priors.knot =
        (sigma.array() * (a.priors.knot.array() / sigma.array()).pow(kFollowed)).matrix();
    if (jitter_s > 0.0) a.priors.jitter_s = jitter_s;  // arrivals tell that
  }
  if (!cold) known_ = a.knowledge();
}

/// Do places that took no part agree better with all that was found than without?
void LiveAligner::Impl::judge() {
  const Adjustment& a = *adjustment_;
  const double mean_delay_s = a.state.delay_s.empty() ? 0.0 : a.state.delay_s.front();
  const Cameras full = a.cameras(a.state), constant = a.cameras(without_errors(a, mean_delay_s)),
                given = a.cameras(without_errors(a, given_delay_s_));
  const int newest = static_cast<int>(a.frames.size()) - 1;
  for (const TieGroup& g : a.groups) {
    if (g.frame != newest) continue;
    for (const Tie& t : g.ties) {
      if (!t.held_out) continue;
      const auto f = a.disagreement_m(g, t, full), c = a.disagreement_m(g, t, constant),
                 n = a.disagreement_m(g, t, given);
      if (!f || !c || !n) continue;
      const auto px = [&](const Cameras& cameras) {
        const auto r = a.residual_px(g, t, cameras);
        return r ? r->norm() : 0.0;
      };
      full_.add(*f, px(full));
      constant_.add(*c, px(constant));
      given_.add(*n, px(given));
    }
  }
  const TieStatistics by_full = full_.statistics(), by_constant = constant_.statistics(),
                      by_given = given_.statistics();
  const bool few = by_full.ties < kLeastJudged;
  const bool constant_better = delayed_ && (few || by_constant.median_m < by_given.median_m);
  const double best = constant_better ? by_constant.median_m : by_given.median_m;
  method_ = !few && by_full.median_m <= best ? AlignMethod::Full
            : constant_better                ? AlignMethod::ConstantDelay
                                             : AlignMethod::AsGiven;
}

Result<AlignedFrame> LiveAligner::Impl::write(int index, const Waiting& waiting,
                                              const Matrix6& own) {
  Adjustment& a = *adjustment_;
  const auto i = static_cast<std::size_t>(index);
  FrameWriting how;
  how.local = &*local_;
  how.gimbal_reference = setup_.gimbal_reference;
  how.fold_mount = true;
  const AdjustmentState kept = a.state;
  if (method_ != AlignMethod::Full)
    a.state = without_errors(a, method_ == AlignMethod::ConstantDelay && !a.state.delay_s.empty()
                                    ? a.state.delay_s.front()
                                    : given_delay_s_);
  const double t_s = a.time_s(index, a.state);
  Time captured = navigation_->epoch() + seconds(t_s);
  if (waiting.frame.own)
    captured = waiting.stamps.own_pose->time;
  else if (waiting.stamps.captured_at)
    captured = *waiting.stamps.captured_at;
  if (waiting.frame.own) how.recorded = waiting.stamps.own_pose->world_from_body;
  for (const StampedPose& p : recorded_)
    if (!waiting.frame.own && p.time <= captured) how.recorded = p.world_from_body;
  const ModelCamera camera = a.camera(index);
  if (method_ == AlignMethod::Full && known_ && !known_->camera.empty()) {
    how.covariance = own + known_->camera.back();
    how.shared_m2 = known_->shared_m2;
  } else {
    how.covariance.diagonal() = a.priors.knot.cwiseAbs2();
    for (int c = 0; c < 3; ++c)
      how.covariance(3 + c, 3 + c) += std::pow(a.priors.globals[Globals::kMount + c], 2);
    if (waiting.frame.delayed) {
      Eigen::Matrix<double, 6, 1> by_delay;
      by_delay << camera.velocity_m_s, camera.rate_rad_s;
      const double sigma_s =
          std::hypot(a.priors.jitter_s, started_ && known_ && !known_->delay_sigma_s.empty()
                                            ? known_->delay_sigma_s.front()
                                            : a.priors.delay_s);
      how.covariance += sigma_s * sigma_s * by_delay * by_delay.transpose();
    }
  }
  auto made = aligned_frame(a, index, how);
  a.state = kept;
  if (!made) return made.error();
  made->index = waiting.id;
  made->captured = made->pose.time = captured;
  made->delay_s = a.frames[i].delayed ? waiting.received_s - t_s : 0.0;
  for (const TieGroup& g : a.groups)
    if (g.frame == index) made->ties += g.ties.size();
  return made;
}

LiveStatus LiveAligner::Impl::status() const {
  LiveStatus s;
  s.started = started_;
  s.mount = setup_.mount;
  s.frames = frames_;
  s.keyframes = keyframes_;
  s.pending = waiting_.size();
  s.tracking_s = tracking_s_;
  s.solving_s = solving_s_;
  s.longest_solve_s = longest_solve_s_;
  s.sightings = sightings_;
  s.after = full_.statistics();
  s.constant_delay = constant_.statistics();
  s.as_given = given_.statistics();
  s.method = method_;
  s.notes = notes_;
  if (!adjustment_ || !started_) return s;
  const Adjustment& a = *adjustment_;
  if (!a.state.delay_s.empty()) s.delay_s = a.state.delay_s.front();
  const Adjustment::Knowledge* known = known_ ? &*known_ : nullptr;
  s.mount = corrected_mount(setup_.mount, a, known);
  s.estimates = estimates_of(setup_, a, globals_before_, known);
  s.navigation_sigma.position_north_east_down_m = a.priors.knot.head<3>();
  s.navigation_sigma.roll_pitch_yaw_rad = a.priors.knot.tail<3>();
  s.pixel_sigma = s.after.median_px / kMedianOfTwo;
  if (known_) {
    if (!known_->delay_sigma_s.empty()) s.delay_sigma_s = known_->delay_sigma_s.front();
    s.shared_covariance_m2 = known_->shared_m2;
  }
  return s;
}

int reduction_for_tracking(const CameraModel& camera) {
  const int side = std::max(camera.width_px(), camera.height_px());
  int reduction = 1;
  while (reduction < 8 && side / (2 * reduction) >= TrackerOptions{}.longest_side_px)
    reduction *= 2;
  return reduction;
}

LiveAligner::LiveAligner(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveAligner::LiveAligner(LiveAligner&&) noexcept = default;
LiveAligner& LiveAligner::operator=(LiveAligner&&) noexcept = default;
LiveAligner::~LiveAligner() = default;

Result<LiveAligner> LiveAligner::make(const Flight& setup, const AlignOptions& options) {
  WATERSKY_CHECK(validate(options.parameters));
  if (!setup.sea_level || !setup.sea_level->height_ellipsoid_m)
    return Error{ErrorCode::NotFound, "the height of the sea is not known"};
  return LiveAligner(std::make_unique<Impl>(setup, options));
}

Status LiveAligner::add_pose(const StampedPose& pose) { return impl_->add_pose(pose); }
Status LiveAligner::add_gimbal(const StampedRotation& rotation) {
  return impl_->add_gimbal(rotation);
}
void LiveAligner::add_frame(std::size_t id, const FrameStamps& stamps, const cv::Mat& picture,
                            int reduction) {
  impl_->add_frame(id, stamps, picture, reduction);
}
std::vector<LiveFrame> LiveAligner::take() { return impl_->take(false); }
std::vector<LiveFrame> LiveAligner::finish() { return impl_->take(true); }
LiveStatus LiveAligner::status() const { return impl_->status(); }

}  // namespace watersky
