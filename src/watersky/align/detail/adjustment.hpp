// SPDX-License-Identifier: MIT
#pragma once
/// The estimator: what delay, mount and pose errors make the same places of the sea, seen from
/// many frames, fall together.
///
/// A place has no unknowns of its own. It is the pixel of its host, carried to the sea z = 0 by
/// the host's camera and from there into the other frame's; the residual is where it was seen
/// less where it should be. (A landmark on a known plane seen from its host without error, as
/// direct methods have it; there inverse depth remains, here the sea gives it.)
///
/// The camera of frame i, with the navigation p, A (reference), G (gimbal) at its time t:
///   t       = base - D(base) - j_i                 D: mean delay, slow; j: per frame
///   R       = exp(θ) A(t) exp(β) G(t - τ) R_m exp(μ)
///   p_c     = p(t) + ε + o + exp(θ) A exp(β) G (l + λ) - h e_z
/// ε, θ: errors of the navigation, first-order Gauss-Markov at knots, linear between them; μ, λ:
/// mount; β, τ: encoder offset and latency of a gimbal; h: height of the camera above what sea
/// level and navigation say; o: north and east by which the whole navigation is off. Both are seen
/// only by what is known from outside (known_points.hpp). Rows of a rolling shutter are displaced
/// by the camera's own motion.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "watersky/align/detail/known_points.hpp"
#include "watersky/align/detail/navigation.hpp"

namespace watersky::align {

/// The median length of two independent normal numbers of sigma 1, √(2 ln 2).
inline constexpr double kMedianOfTwo = 1.1774;

/// One frame as the estimator sees it.
struct AdjustedFrame {
  double base_s = 0.0;                  ///< captured, or received
  bool delayed = false;                 ///< `base_s` is when it was received
  std::optional<NavigationSample> own;  ///< a pose of its own: no time enters
  /// Its place among the knots: error = (1 - weight) knot + weight next knot.
  int knot = 0;
  double weight = 0.0;
};

/// One place in host and frame: directions over their z, without distortion, in camera axes.
struct Tie {
  Eigen::Vector2d host, frame;
  /// Where the pixels' rows lie in the readout, -0.5 to 0.5.
  double host_row = 0.0, frame_row = 0.0;
  /// What makes a residual in pixels one of unit covariance, but for `AdjustmentPriors::tie`.
  Eigen::Matrix2d whiten = Eigen::Matrix2d::Identity();
  int track = -1;         ///< ties of one place; -1: of none
  double scale = 1.0;     ///< of its residuals over those of most, from the last look at them
  double robust = 1.0;    ///< weight of the residual, from the last look at it
  bool held_out = false;  ///< takes no part: it judges
};

/// All ties of one pair of frames.
struct TieGroup {
  int host = 0, frame = 0;
  bool revisit = false;  ///< not neighbours in time
  /// Of its residuals over those between frames at knots: what the navigation's errors do between
  /// knots no tie can be held to. From the last look at them.
  double scale = 1.0;
  /// They are so much larger that the errors between knots are what they show. Those err on the
  /// sea, so a greater height would make them smaller in the picture: such a group takes no part
  /// but in solve_frames().
  bool astray = false;
  std::vector<Tie> ties;
};

/// What all frames share.
struct Globals {
  static constexpr int kMount = 0, kLever = 3, kFocal = 6, kHeight = 7, kEncoder = 8, kLatency = 11,
                       kDrift = 12, kOffset = 14, kSize = 16;
  using Vector = Eigen::Matrix<double, kSize, 1>;
};

struct AdjustmentState {
  std::vector<std::array<double, 6>> knots;  ///< ε [m], θ [rad], axes of Local
  std::vector<double> delay_s;               ///< D at delay knots
  std::vector<double> jitter_s;              ///< j of each frame
  std::vector<std::array<double, 6>> extra;  ///< of each frame alone, added to its knots'
  Globals::Vector globals = Globals::Vector::Zero();
};

/// One sigma of everything that is assumed.
struct AdjustmentPriors {
  Eigen::Matrix<double, 6, 1> knot = Eigen::Matrix<double, 6, 1>::Ones();  ///< stationary
  /// Residuals may make `knot` no larger: poses so bad are not what moves.
  Eigen::Matrix<double, 6, 1> knot_most =
      Eigen::Matrix<double, 6, 1>::Constant(std::numeric_limits<double>::infinity());
  double position_correlation_s = 30.0, attitude_correlation_s = 10.0;  ///< of Gauss-Markov errors
  Globals::Vector globals = Globals::Vector::Zero();                    ///< 0: fixed
  double delay_s = 0.1;         ///< of the first delay knot about its start
  double delay_walk_s = 0.004;  ///< per root second
  double delay_rate = 0.0;      ///< of the clock's rate, s/s, about which the delay walks; 0: none
  double jitter_s = 0.0;        ///< 0: none
  double tie = 1.0;             ///< of a whitened residual
};

/// What all that came before the first frame has told, in place of the priors on what it touches:
/// normal, of the first frame's knot (6), its own delay (where it has one), the first delay knot
/// (where there is one) and the globals that are free, in this order.
struct FirstFramePrior {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

struct AdjustmentOptions {
  int rounds = 4;  ///< of weights from residuals
  bool estimate_variances = true;
  int threads = 1;
  int iterations = 25;  ///< at most, of each round
  bool warm = false;    ///< the state is near already: residuals are believed from the start
};

/// A camera by the model, with how it moves.
struct ModelCamera {
  Eigen::Quaterniond rotation;  ///< local_from_camera
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_rad_s = Eigen::Vector3d::Zero();  ///< axes of Local
  /// With the shutter at `row` of its readout.
  [[nodiscard]] ModelCamera at_row(double row, double readout_s) const;
};

/// The platform (body or gimbal) and body by the model, for writing poses.
struct ModelPlatform {
  Eigen::Quaterniond reference;  ///< local_from_reference, corrected
  Eigen::Quaterniond gimbal;     ///< reference_from_platform, corrected
  Eigen::Vector3d position_m;    ///< of the body
  double t_s = 0.0;              ///< at which the navigation was asked
};

/// Of every frame at one state.
struct Cameras {
  std::vector<ModelCamera> camera;
  std::vector<double> time_s;
  double focal_scale = 0.0;  ///< less one
  Eigen::Vector2d drift_m_s = Eigen::Vector2d::Zero();
};

class Adjustment {
 public:
  Adjustment(const Navigation& navigation, const Mount& mount, double focal_px, double readout_s)
      : navigation_(&navigation), mount_(mount), focal_px_(focal_px), readout_s_(readout_s) {}

  std::vector<AdjustedFrame> frames;
  std::vector<double> knot_times_s;
  std::vector<double> delay_knot_times_s;  ///< of bases; one: a constant
  std::vector<TieGroup> groups;
  std::vector<KnownPoint> known_points;
  std::vector<KnownHeight> known_heights;
  AdjustmentPriors priors;
  std::optional<FirstFramePrior> before_first;
  AdjustmentState state;
  double delay_start_s = 0.0;  ///< the prior's mean

  /// Sizes the state, all zero but the delay. To be called when frames and knots are set.
  void reset();

  /// Minimises; sets weights, and where asked the sigmas in `priors`, from the residuals.
  struct Summary {
    bool usable = false;
    int iterations = 0;
    double seconds = 0.0;
  };
  Summary solve(const AdjustmentOptions& options);
  /// How well the assumptions in `priors` explain what was seen, at the present state: the
  /// logarithm of the probability of all ties (Laplace's approximation), up to a constant of the
  /// ties alone.
  [[nodiscard]] double log_evidence() const;
  /// Of all groups.
  [[nodiscard]] std::size_t tie_count() const;
  /// Each frame by itself, all else as it stands: what happens between knots.
  void solve_frames();
  /// How far the globals move with the places that tell them, one sigma: a jackknife over sixths of
  /// the places. All sightings of a place share its host's error, which the normal equations take
  /// for independent; this does not.
  [[nodiscard]] Globals::Vector globals_sigma_by_places(const AdjustmentOptions& options) const;
  /// One frame by itself: `extra` about zero by `sigma`, and its own delay, where `jitter_s` is
  /// not 0, about zero by that. `groups`: ties of hosts to it; `reweigh`: by their residuals.
  /// Returns the covariance of its camera (position, rotation vector) given all else.
  Eigen::Matrix<double, 6, 6> solve_frame(int frame, const std::vector<const TieGroup*>& groups,
                                          const Eigen::Matrix<double, 6, 1>& sigma, double jitter_s,
                                          bool reweigh);
  /// Lets go of the first frame and its knot, which no frame may share: what it and its ties to the
  /// second tell becomes `before_first`; its other ties are forgotten. `walk_s`: how far the delay
  /// may have wandered from frame to frame. Needs a knot a frame and no more than one delay knot.
  void forget_first(double walk_s);

  [[nodiscard]] double delay_of(int frame) const;  ///< D + j; 0 where not delayed
  [[nodiscard]] ModelCamera camera(int frame) const { return camera(frame, state); }
  [[nodiscard]] ModelCamera camera(int frame, const AdjustmentState& s) const;
  [[nodiscard]] ModelPlatform platform(int frame) const;
  /// All cameras at a state, worked out once for the many ties that ask for them.
  [[nodiscard]] Cameras cameras(const AdjustmentState& s) const;
  /// Residual of a tie, px; nullopt where a ray does not meet the sea.
  [[nodiscard]] std::optional<Eigen::Vector2d> residual_px(const TieGroup& group, const Tie& tie,
                                                           const Cameras& cameras) const;
  /// Distance on the sea between the two frames' ideas of a tie's place, m.
  [[nodiscard]] std::optional<double> disagreement_m(const TieGroup& group, const Tie& tie,
                                                     const Cameras& cameras) const;
  /// An anchor as a frame should see it.
  struct SeenPoint {
    Eigen::Vector2d residual_px;  ///< less where it was seen
    Eigen::Matrix<double, 2, 3> by_point;
    Eigen::Matrix<double, 2, 6> by_camera;  ///< position, then left rotation
  };
  [[nodiscard]] std::optional<SeenPoint> see_known(const KnownPoint& point,
                                                   const AdjustmentState& s) const;
  /// How much higher than the navigation says the body is at a time.
  [[nodiscard]] double height_error_m(double t_s, const AdjustmentState& s) const;
  /// Times between a tie's frames, for moving ice.
  [[nodiscard]] double time_s(int frame, const AdjustmentState& s) const;

  /// What is known after solving: covariances of the state.
  class Knowledge;
  [[nodiscard]] std::optional<Knowledge> knowledge() const;

  /// The camera's platform by the navigation alone, at a frame's time.
  [[nodiscard]] NavigationSample recorded(int frame) const;
  [[nodiscard]] const Mount& mount() const { return mount_; }
  [[nodiscard]] double focal_px() const { return focal_px_; }
  [[nodiscard]] double readout_s() const { return readout_s_; }

 private:
  friend class TieCost;
  friend class KnownPointCost;
  struct Slot;
  struct Evaluated;
  class Problem;
  struct Linear;
  [[nodiscard]] double log_evidence(const Linear& linear) const;
  [[nodiscard]] std::pair<int, double> delay_place(double base_s) const;
  [[nodiscard]] std::pair<int, double> knot_place(double t_s) const;
  void evaluate(int frame, const AdjustmentState& s, bool derivatives, Evaluated& out) const;
  /// Which of a cost's blocks a camera's slots are.
  [[nodiscard]] static std::array<std::size_t, 6> places(const Evaluated& camera,
                                                         const std::vector<int>& blocks);
  static void add_rows(const Evaluated& camera, const std::array<std::size_t, 6>& at,
                       const Eigen::Matrix<double, 2, 6>& by, int row, double** jacobians);
  void look_at_residuals(bool first, bool forgiving);
  /// What `before_first` is of, in its order.
  [[nodiscard]] std::vector<int> first_blocks() const;

  const Navigation* navigation_;
  Mount mount_;
  double focal_px_;
  double readout_s_;
};

/// How much the camera turned by the navigation, about its mean attitude at the knots, and how much
/// of that the adjustment took for error: variances of all three axes together.
class Excitation {
 public:
  /// A frame at its knot; called in order of time.
  void add(const Adjustment& adjustment, int frame);
  [[nodiscard]] double recorded_rad2() const { return variance(recorded_); }
  [[nodiscard]] double error_rad2() const { return variance(errors_); }
  /// Whether turns tell anything: at least half of their size is not error.
  [[nodiscard]] bool tells() const { return recorded_rad2() > 4.0 * error_rad2(); }

 private:
  struct Sums {
    double n = 0.0, square = 0.0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  };
  static double variance(const Sums& s) {
    return s.n > 0 ? std::max(0.0, s.square / s.n - (s.sum / s.n).squaredNorm()) : 0.0;
  }
  Sums recorded_, errors_;
  std::optional<Eigen::Quaterniond> first_;
};
[[nodiscard]] Excitation excitation_of(const Adjustment& adjustment);

/// Holds what only turns can tell at what was given: the mount, the lever arm, and the delay at
/// `delay_s`. Starts the state anew.
void hold_for_want_of_turns(Adjustment& adjustment, double delay_s);

/// Covariances of an adjustment's state by its normal equations.
class Adjustment::Knowledge {
 public:
  Globals::Vector globals_sigma = Globals::Vector::Zero();
  std::vector<double> delay_sigma_s;
  std::vector<double> jitter_sigma_s;  ///< of each frame; infinite where it is no unknown
  /// Of a frame's camera: position and rotation (axes of Local) given the mean place on the sea
  /// of all pictures' middles.
  std::vector<Eigen::Matrix<double, 6, 6>> camera;
  /// Of that mean place.
  Eigen::Matrix2d shared_m2 = Eigen::Matrix2d::Zero();
};

}  // namespace watersky::align
