// SPDX-License-Identifier: MIT
#include "watersky/align/detail/adjustment.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>

#include "watersky/geo/rotation.hpp"

namespace watersky::align {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

/// Of a ray's down over its length: flatter than 3° it says nothing, and its derivatives explode.
constexpr double kFlattest = 0.05;
/// In front of a camera, along its axis.
constexpr double kNearest_m = 1e-6;

/// exp(w + dw) = exp(J dw) exp(w), to first order in w.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) {
  return Eigen::Matrix3d::Identity() + 0.5 * skew(w);
}

/// The sea under a ray, and its derivatives by the camera's place and left rotation.
struct SeaHit {
  Eigen::Vector3d at;
  Eigen::Matrix3d by_direction;  ///< by the ray's direction
  Eigen::Matrix3d by_position;
  Eigen::Vector3d ray;
};

std::optional<SeaHit> hit_sea(const ModelCamera& camera, const Eigen::Vector3d& direction) {
  SeaHit hit;
  hit.ray = camera.rotation * direction;
  if (!(hit.ray.z() > kFlattest * hit.ray.norm()) || !(camera.position_m.z() < 0))
    return std::nullopt;
  const double along = -camera.position_m.z() / hit.ray.z();
  hit.at = camera.position_m + along * hit.ray;
  hit.by_position = Eigen::Matrix3d::Identity();
  hit.by_position.col(2) -= hit.ray / hit.ray.z();
  hit.by_direction = along * hit.by_position;
  return hit;
}

/// A point seen by a camera: direction over z, and derivatives.
struct Seen {
  Eigen::Vector2d at;
  Eigen::Matrix<double, 2, 3> by_point;
  Matrix26 by_camera;
};

std::optional<Seen> see(const ModelCamera& camera, const Eigen::Vector3d& point) {
  const Eigen::Vector3d from = point - camera.position_m;
  const Eigen::Matrix3d camera_from_local = camera.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d y = camera_from_local * from;
  if (!(y.z() > kNearest_m)) return std::nullopt;
  Seen seen;
  seen.at = y.hnormalized();
  Eigen::Matrix<double, 2, 3> divide;
  divide << 1, 0, -seen.at.x(), 0, 1, -seen.at.y();
  seen.by_point = divide / y.z() * camera_from_local;
  seen.by_camera.leftCols<3>() = -seen.by_point;
  seen.by_camera.rightCols<3>() = seen.by_point * skew(from);
  return seen;
}

Eigen::Vector3d with_focal(const Eigen::Vector2d& direction, double focal_scale) {
  return (direction / (1.0 + focal_scale)).homogeneous();
}

/// The place alone.
std::optional<Eigen::Vector2d> sea_under(const ModelCamera& camera,
                                         const Eigen::Vector3d& direction) {
  const Eigen::Vector3d ray = camera.rotation * direction;
  if (!(ray.z() > kFlattest * ray.norm()) || !(camera.position_m.z() < 0)) return std::nullopt;
  return (camera.position_m - camera.position_m.z() / ray.z() * ray).head<2>();
}

/// Where a frame sees the place that its host sees in a direction: over z.
std::optional<Eigen::Vector2d> sent(const ModelCamera& host, const ModelCamera& frame,
                                    const Eigen::Vector2d& host_direction, double focal_scale,
                                    const Eigen::Vector2d& moved_m) {
  const auto place = sea_under(host, with_focal(host_direction, focal_scale));
  if (!place) return std::nullopt;
  Eigen::Vector3d point;
  point << *place + moved_m, 0.0;
  const Eigen::Vector3d y = frame.rotation.conjugate() * (point - frame.position_m);
  if (!(y.z() > kNearest_m)) return std::nullopt;
  return y.hnormalized();
}

/// Everything a tie's residual depends on.
struct Transfer {
  Eigen::Vector2d residual;  ///< in units of the focal length
  Matrix26 by_host, by_frame;
  Eigen::Vector2d by_focal;
  Eigen::Matrix2d by_drift;
};

std::optional<Transfer> transfer(const ModelCamera& host, const ModelCamera& frame,
                                 const Eigen::Vector2d& host_direction,
                                 const Eigen::Vector2d& frame_direction, double focal_scale,
                                 const Eigen::Vector2d& drift_m_s, double elapsed_s) {
  const Eigen::Vector3d direction = with_focal(host_direction, focal_scale);
  const auto hit = hit_sea(host, direction);
  if (!hit) return std::nullopt;
  Eigen::Vector3d point = hit->at;
  point.head<2>() += elapsed_s * drift_m_s;
  const auto seen = see(frame, point);
  if (!seen) return std::nullopt;
  Transfer t;
  t.residual = (1.0 + focal_scale) * seen->at - frame_direction;
  const double scale = 1.0 + focal_scale;
  const Eigen::Matrix<double, 2, 3> by_point = scale * seen->by_point;
  t.by_host.leftCols<3>() = by_point * hit->by_position;
  t.by_host.rightCols<3>() = -by_point * hit->by_direction * skew(hit->ray);
  t.by_frame = scale * seen->by_camera;
  const Eigen::Vector3d ray_by_focal =
      host.rotation * Eigen::Vector3d(-host_direction.x() / (scale * scale),
                                      -host_direction.y() / (scale * scale), 0.0);
  t.by_focal = seen->at + by_point * hit->by_direction * ray_by_focal;
  t.by_drift = elapsed_s * by_point.leftCols<2>();
  return t;
}

/// What the residual of a known point depends on.
struct SeenKnown {
  Eigen::Vector2d residual;  ///< in units of the focal length
  Eigen::Matrix<double, 2, 3> by_point;
  Matrix26 by_camera;
  Eigen::Vector2d by_focal;
};

/// `camera` is at the row of the sighting, at `t_s`. That the point's own motion shifts it with the
/// camera's delay is left out of the derivatives: ice is slow against an aircraft.
std::optional<SeenKnown> see_known_point(const ModelCamera& camera, const KnownPoint& known,
                                         double focal_scale, double t_s) {
  const auto seen = see(camera, known.point_m + (t_s - known.at_s) * known.velocity_m_s);
  if (!seen) return std::nullopt;
  const double scale = 1.0 + focal_scale;
  return SeenKnown{scale * seen->at - known.direction, scale * seen->by_point,
                   scale * seen->by_camera, seen->at};
}

/// The piece of a broken line over rising `times` that holds `t`, and how far along it.
std::pair<int, double> piece_of(const std::vector<double>& times, double t) {
  if (times.size() < 2) return {0, 0.0};
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  const auto i = std::clamp<std::ptrdiff_t>(after - times.begin() - 1, 0,
                                            static_cast<std::ptrdiff_t>(times.size()) - 2);
  const auto k = static_cast<std::size_t>(i);
  return {static_cast<int>(i), std::clamp((t - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0)};
}

}  // namespace

ModelCamera ModelCamera::at_row(double row, double readout_s) const {
  if (row == 0.0 || readout_s == 0.0) return *this;
  const double dt = row * readout_s;
  return {exp_rotation(rate_rad_s * dt) * rotation, position_m + dt * velocity_m_s, velocity_m_s,
          rate_rad_s};
}

/// Where a frame's parameters are.
struct Adjustment::Slot {
  int block = -1;
  int size = 0;
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, Globals::kSize> by;
};

struct Adjustment::Evaluated {
  ModelCamera camera;
  double t_s = 0.0;
  std::array<Slot, 6> slots;
  int count = 0;
};

namespace {

/// Blocks in one row: knots, delay knots, jitters, globals.
struct Blocks {
  int knots = 0, delays = 0, frames = 0;
  [[nodiscard]] int delay(int i) const { return knots + i; }
  [[nodiscard]] int jitter(int i) const { return knots + delays + i; }
  [[nodiscard]] int globals() const { return knots + delays + frames; }
  [[nodiscard]] int count() const { return globals() + 1; }
  [[nodiscard]] int size(int block) const {
    if (block < knots) return 6;
    return block == globals() ? Globals::kSize : 1;
  }
};

Blocks blocks_of(const AdjustmentState& s) {
  return {static_cast<int>(s.knots.size()), static_cast<int>(s.delay_s.size()),
          static_cast<int>(s.jitter_s.size())};
}

/// A state of its own with just these blocks filled in: the frames ask for no others.
const AdjustmentState& state_with(const Adjustment& adjustment, const std::vector<int>& blocks,
                                  double const* const* parameters,
                                  std::initializer_list<int> frames) {
  thread_local AdjustmentState s;
  const AdjustmentState& shape = adjustment.state;
  s.knots.resize(shape.knots.size());
  s.delay_s.resize(shape.delay_s.size());
  s.jitter_s.resize(shape.jitter_s.size());
  for (const int f : frames) s.jitter_s[static_cast<std::size_t>(f)] = 0.0;
  s.extra.resize(shape.extra.size());
  const Blocks all = blocks_of(shape);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const int b = blocks[k];
    const double* p = parameters[k];
    if (b < all.knots)
      std::copy(p, p + 6, s.knots[static_cast<std::size_t>(b)].begin());
    else if (b < all.knots + all.delays)
      s.delay_s[static_cast<std::size_t>(b - all.knots)] = *p;
    else if (b < all.globals())
      s.jitter_s[static_cast<std::size_t>(b - all.knots - all.delays)] = *p;
    else
      s.globals = Eigen::Map<const Globals::Vector>(p);
  }
  for (const int f : frames)
    s.extra[static_cast<std::size_t>(f)] = shape.extra[static_cast<std::size_t>(f)];
  return s;
}

}  // namespace

void Adjustment::reset() {
  state.knots.assign(knot_times_s.size(), {});
  state.delay_s.assign(delay_knot_times_s.size(), delay_start_s);
  state.jitter_s.assign(frames.size(), 0.0);
  state.extra.assign(frames.size(), {});
  state.globals.setZero();
}

std::pair<int, double> Adjustment::delay_place(double base_s) const {
  return piece_of(delay_knot_times_s, base_s);
}

std::pair<int, double> Adjustment::knot_place(double t_s) const {
  return piece_of(knot_times_s, t_s);
}

void Adjustment::evaluate(int index, const AdjustmentState& s, bool derivatives,
                          Evaluated& out) const {
  const auto i = static_cast<std::size_t>(index);
  const AdjustedFrame& frame = frames[i];
  const Globals::Vector& g = s.globals;
  const Blocks blocks = blocks_of(s);

  double delay_s = 0.0;
  std::pair<int, double> place{0, 0.0};
  const bool delayed = frame.delayed && !frame.own && !s.delay_s.empty();
  if (delayed) {
    place = delay_place(frame.base_s);
    const auto k = static_cast<std::size_t>(place.first);
    delay_s = s.delay_s[k] + s.jitter_s[i];
    if (place.second > 0.0) delay_s += place.second * (s.delay_s[k + 1] - s.delay_s[k]);
  }
  out.t_s = frame.base_s - delay_s;
  const NavigationSample nav =
      frame.own ? *frame.own : navigation_->at(out.t_s, g[Globals::kLatency]);

  Eigen::Matrix<double, 6, 1> error = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
      s.knots[static_cast<std::size_t>(frame.knot)].data());
  if (frame.weight > 0.0)
    error += frame.weight * (Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
                                 s.knots[static_cast<std::size_t>(frame.knot) + 1].data()) -
                             error);
  error += Eigen::Map<const Eigen::Matrix<double, 6, 1>>(s.extra[i].data());

  const Eigen::Vector3d turn = error.tail<3>();
  const Eigen::Vector3d encoder = g.segment<3>(Globals::kEncoder);
  const Eigen::Vector3d boresight = g.segment<3>(Globals::kMount);
  const Eigen::Quaterniond reference = exp_rotation(turn) * nav.reference;
  const Eigen::Quaterniond geared = reference * exp_rotation(encoder);
  const Eigen::Quaterniond platform = geared * nav.gimbal;
  const Eigen::Vector3d arm = platform * (mount_.lever_arm_m + g.segment<3>(Globals::kLever));
  ModelCamera& camera = out.camera;
  camera.rotation = platform * mount_.rotation * exp_rotation(boresight);
  camera.position_m = nav.position_m + error.head<3>() + arm;
  camera.position_m.z() -= g[Globals::kHeight];
  camera.position_m.head<2>() += g.segment<2>(Globals::kOffset);
  const Eigen::Vector3d gimbal_rate = geared * nav.gimbal_rate_rad_s;
  camera.rate_rad_s = exp_rotation(turn) * nav.reference_rate_rad_s + gimbal_rate;
  camera.velocity_m_s = nav.velocity_m_s + camera.rate_rad_s.cross(arm);
  out.count = 0;
  if (!derivatives) return;

  const auto slot = [&](int block, int size) -> auto& {
    Slot& made = out.slots[static_cast<std::size_t>(out.count++)];
    made.block = block;
    made.size = size;
    made.by.setZero(6, size);
    return made.by;
  };
  const Eigen::Matrix3d turns_arm = -skew(arm);  // δp of a left rotation of the platform
  Matrix6 by_error = Matrix6::Identity();
  by_error.bottomRightCorner<3, 3>() = left_jacobian(turn);
  by_error.topRightCorner<3, 3>() = turns_arm * left_jacobian(turn);
  slot(frame.knot, 6) = (1.0 - frame.weight) * by_error;
  if (frame.weight > 0.0) slot(frame.knot + 1, 6) = frame.weight * by_error;
  if (delayed) {
    Eigen::Matrix<double, 6, 1> by_delay;
    by_delay << -camera.velocity_m_s, -camera.rate_rad_s;
    slot(blocks.delay(place.first), 1) = (1.0 - place.second) * by_delay;
    if (place.second > 0.0) slot(blocks.delay(place.first + 1), 1) = place.second * by_delay;
    if (priors.jitter_s > 0.0) slot(blocks.jitter(index), 1) = by_delay;
  }
  auto& by_globals = slot(blocks.globals(), Globals::kSize);
  by_globals.block<3, 3>(3, Globals::kMount) =
      camera.rotation.toRotationMatrix() * left_jacobian(boresight).transpose();
  by_globals.block<3, 3>(0, Globals::kLever) = platform.toRotationMatrix();
  by_globals(2, Globals::kHeight) = -1.0;
  by_globals.block<2, 2>(0, Globals::kOffset).setIdentity();
  const Eigen::Matrix3d encoder_turn = reference.toRotationMatrix() * left_jacobian(encoder);
  by_globals.block<3, 3>(3, Globals::kEncoder) = encoder_turn;
  by_globals.block<3, 3>(0, Globals::kEncoder) = turns_arm * encoder_turn;
  by_globals.block<3, 1>(3, Globals::kLatency) = -gimbal_rate;
  by_globals.block<3, 1>(0, Globals::kLatency) = -gimbal_rate.cross(arm);
}

double Adjustment::delay_of(int index) const {
  const auto i = static_cast<std::size_t>(index);
  return frames[i].base_s - time_s(index, state);
}

double Adjustment::time_s(int index, const AdjustmentState& s) const {
  const auto i = static_cast<std::size_t>(index);
  const AdjustedFrame& frame = frames[i];
  if (!frame.delayed || frame.own || s.delay_s.empty()) return frame.base_s;
  const auto [k, f] = delay_place(frame.base_s);
  const auto at = static_cast<std::size_t>(k);
  double delay_s = s.delay_s[at] + s.jitter_s[i];
  if (f > 0.0) delay_s += f * (s.delay_s[at + 1] - s.delay_s[at]);
  return frame.base_s - delay_s;
}

ModelCamera Adjustment::camera(int frame, const AdjustmentState& s) const {
  Evaluated e;
  evaluate(frame, s, false, e);
  return e.camera;
}

ModelPlatform Adjustment::platform(int index) const {
  const auto i = static_cast<std::size_t>(index);
  const AdjustedFrame& frame = frames[i];
  ModelPlatform out;
  out.t_s = time_s(index, state);
  const NavigationSample nav =
      frame.own ? *frame.own : navigation_->at(out.t_s, state.globals[Globals::kLatency]);
  Eigen::Matrix<double, 6, 1> error = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
      state.knots[static_cast<std::size_t>(frame.knot)].data());
  if (frame.weight > 0.0)
    error += frame.weight * (Eigen::Map<const Eigen::Matrix<double, 6, 1>>(
                                 state.knots[static_cast<std::size_t>(frame.knot) + 1].data()) -
                             error);
  error += Eigen::Map<const Eigen::Matrix<double, 6, 1>>(state.extra[i].data());
  out.reference = exp_rotation(error.tail<3>()) * nav.reference;
  out.gimbal = exp_rotation(state.globals.segment<3>(Globals::kEncoder)) * nav.gimbal;
  out.position_m = nav.position_m + error.head<3>();
  out.position_m.z() -= state.globals[Globals::kHeight];
  out.position_m.head<2>() += state.globals.segment<2>(Globals::kOffset);
  return out;
}

Cameras Adjustment::cameras(const AdjustmentState& s) const {
  Cameras out;
  out.camera.reserve(frames.size());
  out.time_s.reserve(frames.size());
  out.focal_scale = s.globals[Globals::kFocal];
  out.drift_m_s = s.globals.segment<2>(Globals::kDrift);
  Evaluated e;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    evaluate(static_cast<int>(i), s, false, e);
    out.camera.push_back(e.camera);
    out.time_s.push_back(e.t_s);
  }
  return out;
}

std::optional<Adjustment::SeenPoint> Adjustment::see_known(const KnownPoint& point,
                                                           const AdjustmentState& s) const {
  const auto seen = see_known_point(camera(point.frame, s).at_row(point.row, readout_s_), point,
                                    s.globals[Globals::kFocal], time_s(point.frame, s));
  if (!seen) return std::nullopt;
  return SeenPoint{focal_px_ * seen->residual, focal_px_ * seen->by_point,
                   focal_px_ * seen->by_camera};
}

double Adjustment::height_error_m(double t_s, const AdjustmentState& s) const {
  const auto [k, f] = knot_place(t_s);
  double down_m = s.knots[static_cast<std::size_t>(k)][2];
  if (f > 0.0) down_m += f * (s.knots[static_cast<std::size_t>(k) + 1][2] - down_m);
  return s.globals[Globals::kHeight] - down_m;
}

std::optional<Eigen::Vector2d> Adjustment::residual_px(const TieGroup& group, const Tie& tie,
                                                       const Cameras& cameras) const {
  const auto h = static_cast<std::size_t>(group.host), f = static_cast<std::size_t>(group.frame);
  const auto seen =
      sent(cameras.camera[h].at_row(tie.host_row, readout_s_),
           cameras.camera[f].at_row(tie.frame_row, readout_s_), tie.host, cameras.focal_scale,
           cameras.drift_m_s * (cameras.time_s[f] - cameras.time_s[h]));
  if (!seen) return std::nullopt;
  return Eigen::Vector2d(focal_px_ * ((1.0 + cameras.focal_scale) * *seen - tie.frame));
}

std::optional<double> Adjustment::disagreement_m(const TieGroup& group, const Tie& tie,
                                                 const Cameras& cameras) const {
  const auto h = static_cast<std::size_t>(group.host), f = static_cast<std::size_t>(group.frame);
  const auto a = sea_under(cameras.camera[h].at_row(tie.host_row, readout_s_),
                           with_focal(tie.host, cameras.focal_scale));
  const auto b = sea_under(cameras.camera[f].at_row(tie.frame_row, readout_s_),
                           with_focal(tie.frame, cameras.focal_scale));
  if (!a || !b) return std::nullopt;
  return (*b - *a - (cameras.time_s[f] - cameras.time_s[h]) * cameras.drift_m_s).norm();
}

/// To two rows of jacobians what they owe to a camera's parameters.
std::array<std::size_t, 6> Adjustment::places(const Evaluated& camera,
                                              const std::vector<int>& blocks) {
  std::array<std::size_t, 6> at{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(camera.count); ++k)
    at[k] = static_cast<std::size_t>(
        std::find(blocks.begin(), blocks.end(), camera.slots[k].block) - blocks.begin());
  return at;
}

void Adjustment::add_rows(const Evaluated& camera, const std::array<std::size_t, 6>& at,
                          const Matrix26& by, int row, double** jacobians) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(camera.count); ++k) {
    const Slot& slot = camera.slots[k];
    double* j = jacobians[at[k]];
    if (!j) continue;
    for (int c = 0; c < slot.size; ++c) {
      const Eigen::Vector2d column = by * slot.by.col(c);
      j[row * slot.size + c] += column.x();
      j[(row + 1) * slot.size + c] += column.y();
    }
  }
}

/// The residuals of one pair of frames.
class TieCost final : public ceres::CostFunction {
 public:
  TieCost(const Adjustment& adjustment, const TieGroup& group, std::vector<int> blocks)
      : adjustment_(&adjustment), group_(&group), blocks_(std::move(blocks)) {
    const Blocks all = blocks_of(adjustment.state);
    int rows = 0;
    for (const Tie& t : group.ties) rows += t.held_out ? 0 : 2;
    set_num_residuals(rows);
    for (const int b : blocks_) mutable_parameter_block_sizes()->push_back(all.size(b));
    globals_ = static_cast<std::size_t>(std::find(blocks_.begin(), blocks_.end(), all.globals()) -
                                        blocks_.begin());
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const AdjustmentState& s =
        state_with(*adjustment_, blocks_, parameters, {group_->host, group_->frame});
    const Blocks all = blocks_of(adjustment_->state);
    Adjustment::Evaluated host, frame;
    const bool derive = jacobians != nullptr;
    adjustment_->evaluate(group_->host, s, derive, host);
    adjustment_->evaluate(group_->frame, s, derive, frame);
    const double focal = s.globals[Globals::kFocal];
    const Eigen::Vector2d drift = s.globals.segment<2>(Globals::kDrift);
    const double elapsed_s = frame.t_s - host.t_s;
    const int rows = num_residuals();
    if (derive)
      for (std::size_t k = 0; k < blocks_.size(); ++k)
        if (jacobians[k]) std::fill_n(jacobians[k], rows * all.size(blocks_[k]), 0.0);

    const auto host_at = Adjustment::places(host, blocks_),
               frame_at = Adjustment::places(frame, blocks_);
    int row = 0;
    for (const Tie& tie : group_->ties) {
      if (tie.held_out) continue;
      const Eigen::Matrix2d scale = adjustment_->focal_px() /
                                    (adjustment_->priors.tie * tie.scale * group_->scale) *
                                    std::sqrt(tie.robust) * tie.whiten;
      const auto t = transfer(host.camera.at_row(tie.host_row, adjustment_->readout_s()),
                              frame.camera.at_row(tie.frame_row, adjustment_->readout_s()),
                              tie.host, tie.frame, focal, drift, elapsed_s);
      if (!t) {
        // Off the sea for a trial step: as bad as can be, without a direction.
        residuals[row] = residuals[row + 1] = tie.robust > 0.0 ? 1e3 : 0.0;
        row += 2;
        continue;
      }
      const Eigen::Vector2d residual = scale * t->residual;
      residuals[row] = residual.x();
      residuals[row + 1] = residual.y();
      if (derive) {
        Adjustment::add_rows(host, host_at, scale * t->by_host, row, jacobians);
        Adjustment::add_rows(frame, frame_at, scale * t->by_frame, row, jacobians);
        if (double* j = jacobians[globals_]) {
          const Eigen::Vector2d by_focal = scale * t->by_focal;
          const Eigen::Matrix2d by_drift = scale * t->by_drift;
          for (int r = 0; r < 2; ++r) {
            double* line = j + (row + r) * Globals::kSize;
            line[Globals::kFocal] += by_focal[r];
            for (int c = 0; c < 2; ++c) line[Globals::kDrift + c] += by_drift(r, c);
          }
        }
      }
      row += 2;
    }
    return true;
  }

 private:
  const Adjustment* adjustment_;
  const TieGroup* group_;
  std::vector<int> blocks_;
  std::size_t globals_ = 0;
};

/// The residual of one sighting of an anchor.
class KnownPointCost final : public ceres::CostFunction {
 public:
  KnownPointCost(const Adjustment& adjustment, const KnownPoint& point, std::vector<int> blocks)
      : adjustment_(&adjustment), point_(&point), blocks_(std::move(blocks)) {
    const Blocks all = blocks_of(adjustment.state);
    set_num_residuals(2);
    for (const int b : blocks_) mutable_parameter_block_sizes()->push_back(all.size(b));
    globals_ = static_cast<std::size_t>(std::find(blocks_.begin(), blocks_.end(), all.globals()) -
                                        blocks_.begin());
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const AdjustmentState& s = state_with(*adjustment_, blocks_, parameters, {point_->frame});
    const Blocks all = blocks_of(adjustment_->state);
    Adjustment::Evaluated frame;
    adjustment_->evaluate(point_->frame, s, jacobians != nullptr, frame);
    if (jacobians)
      for (std::size_t k = 0; k < blocks_.size(); ++k)
        if (jacobians[k]) std::fill_n(jacobians[k], 2 * all.size(blocks_[k]), 0.0);
    const auto seen = see_known_point(frame.camera.at_row(point_->row, adjustment_->readout_s()),
                                      *point_, s.globals[Globals::kFocal], frame.t_s);
    if (!seen) {
      residuals[0] = residuals[1] = 1e3;  // behind the camera for a trial step
      return true;
    }
    const Eigen::Matrix2d scale = adjustment_->focal_px() * point_->whiten;
    Eigen::Map<Eigen::Vector2d>(residuals, 2) = scale * seen->residual;
    if (!jacobians) return true;
    Adjustment::add_rows(frame, Adjustment::places(frame, blocks_), scale * seen->by_camera, 0,
                         jacobians);
    if (double* j = jacobians[globals_]) {
      const Eigen::Vector2d by_focal = scale * seen->by_focal;
      for (int r = 0; r < 2; ++r) j[r * Globals::kSize + Globals::kFocal] += by_focal[r];
    }
    return true;
  }

 private:
  const Adjustment* adjustment_;
  const KnownPoint* point_;
  std::vector<int> blocks_;
  std::size_t globals_ = 0;
};

namespace {

/// The residual of one known height, linear in the knots around it and the height of all.
class KnownHeightCost final : public ceres::CostFunction {
 public:
  /// With blocks of `weight` 0 the second knot is not asked for.
  KnownHeightCost(const KnownHeight& height, double weight)
      : scale_(std::sqrt(height.robust) / height.sigma_m),
        error_m_(height.error_m),
        weight_(weight) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(Globals::kSize);
    mutable_parameter_block_sizes()->push_back(6);
    if (weight > 0.0) mutable_parameter_block_sizes()->push_back(6);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    double up_m = parameters[0][Globals::kHeight] - (1.0 - weight_) * parameters[1][2];
    if (weight_ > 0.0) up_m -= weight_ * parameters[2][2];
    residuals[0] = scale_ * (up_m - error_m_);
    if (!jacobians) return true;
    const auto set = [&](int block, int size, int at, double by) {
      if (!jacobians[block]) return;
      std::fill_n(jacobians[block], size, 0.0);
      jacobians[block][at] = scale_ * by;
    };
    set(0, Globals::kSize, Globals::kHeight, 1.0);
    set(1, 6, 2, weight_ - 1.0);
    if (weight_ > 0.0) set(2, 6, 2, -weight_);
    return true;
  }

 private:
  double scale_, error_m_, weight_;
};

/// (after - keep before) / sigma, element by element; without `before` a plain prior about `mean`.
class LinkCost final : public ceres::CostFunction {
 public:
  LinkCost(Eigen::VectorXd keep, Eigen::VectorXd sigma, Eigen::VectorXd mean, bool linked)
      : keep_(std::move(keep)), sigma_(std::move(sigma)), mean_(std::move(mean)), linked_(linked) {
    const int n = static_cast<int>(sigma_.size());
    set_num_residuals(n);
    mutable_parameter_block_sizes()->push_back(n);
    if (linked_) mutable_parameter_block_sizes()->push_back(n);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const int n = num_residuals();
    for (int k = 0; k < n; ++k) {
      const double expected = linked_ ? keep_[k] * parameters[1][k] : mean_[k];
      residuals[k] = (parameters[0][k] - expected) / sigma_[k];
    }
    if (!jacobians) return true;
    for (int b = 0; b < (linked_ ? 2 : 1); ++b)
      if (jacobians[b]) {
        std::fill_n(jacobians[b], n * n, 0.0);
        for (int k = 0; k < n; ++k)
          jacobians[b][k * n + k] = (b == 0 ? 1.0 : -keep_[k]) / sigma_[k];
      }
    return true;
  }

 private:
  Eigen::VectorXd keep_, sigma_, mean_;
  bool linked_;
};

}  // namespace

namespace {

/// root (x - mean) of blocks laid one behind the other.
class FirstFrameCost final : public ceres::CostFunction {
 public:
  /// `columns`: of each block, which elements of x its own are; -1: of none.
  FirstFrameCost(const FirstFramePrior& prior, std::vector<std::vector<int>> columns)
      : mean_(prior.mean), columns_(std::move(columns)) {
    const Eigen::LLT<Eigen::MatrixXd> covariance(prior.covariance);
    root_ = covariance.matrixL().solve(
        Eigen::MatrixXd::Identity(prior.covariance.rows(), prior.covariance.cols()));
    set_num_residuals(static_cast<int>(mean_.size()));
    for (const auto& c : columns_)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(c.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::VectorXd x = mean_;
    for (std::size_t b = 0; b < columns_.size(); ++b)
      for (std::size_t k = 0; k < columns_[b].size(); ++k)
        if (columns_[b][k] >= 0) x[columns_[b][k]] = parameters[b][k];
    const Eigen::Index n = mean_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = root_ * (x - mean_);
    if (!jacobians) return true;
    for (std::size_t b = 0; b < columns_.size(); ++b) {
      if (!jacobians[b]) continue;
      const auto size = static_cast<Eigen::Index>(columns_[b].size());
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> j(
          jacobians[b], n, size);
      for (Eigen::Index k = 0; k < size; ++k) {
        const int column = columns_[b][static_cast<std::size_t>(k)];
        if (column >= 0)
          j.col(k) = root_.col(column);
        else
          j.col(k).setZero();
      }
    }
    return true;
  }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd root_;
  std::vector<std::vector<int>> columns_;
};

}  // namespace

/// Rows and columns at the present state.
struct Adjustment::Linear {
  Eigen::SparseMatrix<double> jacobian;
  Eigen::VectorXd residuals;
  std::vector<int> kind;          ///< of each row
  std::vector<int> component;     ///< of a knot's row: 0 to 5
  std::vector<int> first_column;  ///< of each block; -1: not in it
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> normal;
  bool good = false;
};

/// The Ceres problem, and its rows by what they assume.
class Adjustment::Problem {
 public:
  enum Kind { Ties, Knots, Delays, Jitters, Shared, Known, First };

  Problem(const Adjustment& adjustment, AdjustmentState& state)
      : adjustment_(adjustment), state_(state), blocks_(blocks_of(state)) {
    ceres::Problem::Options options;
    options.enable_fast_removal = false;
    problem_ = std::make_unique<ceres::Problem>(options);
    used_.assign(static_cast<std::size_t>(blocks_.count()), 0);
    add_ties();
    add_known();
    add_priors();
  }

  [[nodiscard]] double* pointer(int block) const {
    if (block < blocks_.knots) return state_.knots[static_cast<std::size_t>(block)].data();
    if (block < blocks_.knots + blocks_.delays)
      return &state_.delay_s[static_cast<std::size_t>(block - blocks_.knots)];
    if (block < blocks_.globals())
      return &state_.jitter_s[static_cast<std::size_t>(block - blocks_.knots - blocks_.delays)];
    return state_.globals.data();
  }

  Summary solve(const AdjustmentOptions& options) {
    ceres::Solver::Options o;
    o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    // As fast as others at this size and structure, and without threads of its own.
    o.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    o.max_num_iterations = options.iterations;
    o.function_tolerance = 1e-6;
    o.num_threads = std::max(1, options.threads);
    o.logging_type = ceres::SILENT;
    o.use_nonmonotonic_steps = false;
    ceres::Solver::Summary s;
    ceres::Solve(o, problem_.get(), &s);
    return {s.IsSolutionUsable(), static_cast<int>(s.iterations.size()), s.total_time_in_seconds};
  }

  std::unique_ptr<Linear> linearise() const {
    auto out = std::make_unique<Linear>();
    ceres::Problem::EvaluateOptions o;
    out->first_column.assign(used_.size(), -1);
    int column = 0;
    for (int b = 0; b < blocks_.count(); ++b) {
      if (!used_[static_cast<std::size_t>(b)]) continue;
      o.parameter_blocks.push_back(pointer(b));
      out->first_column[static_cast<std::size_t>(b)] = column;
      column += b == blocks_.globals() ? static_cast<int>(free_globals_.size()) : blocks_.size(b);
    }
    for (const auto& r : rows_) {
      o.residual_blocks.push_back(r.id);
      for (int k = 0; k < r.size; ++k) {
        out->kind.push_back(r.kind);
        out->component.push_back(r.kind == Knots ? k % 6 : 0);
      }
    }
    ceres::CRSMatrix crs;
    std::vector<double> residuals;
    double cost = 0.0;
    if (!const_cast<ceres::Problem&>(*problem_).Evaluate(o, &cost, &residuals, nullptr, &crs))
      return out;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(crs.values.size());
    for (int r = 0; r < crs.num_rows; ++r)
      for (int k = crs.rows[static_cast<std::size_t>(r)];
           k < crs.rows[static_cast<std::size_t>(r) + 1]; ++k)
        if (crs.values[static_cast<std::size_t>(k)] != 0.0)
          entries.emplace_back(r, crs.cols[static_cast<std::size_t>(k)],
                               crs.values[static_cast<std::size_t>(k)]);
    out->jacobian.resize(crs.num_rows, crs.num_cols);
    out->jacobian.setFromTriplets(entries.begin(), entries.end());
    out->residuals = Eigen::Map<const Eigen::VectorXd>(residuals.data(),
                                                       static_cast<Eigen::Index>(residuals.size()));
    const Eigen::SparseMatrix<double> normal = out->jacobian.transpose() * out->jacobian;
    out->normal.compute(normal);
    out->good = out->normal.info() == Eigen::Success;
    return out;
  }

  [[nodiscard]] const std::vector<int>& free_globals() const { return free_globals_; }
  [[nodiscard]] const Blocks& blocks() const { return blocks_; }

 private:
  struct Rows {
    ceres::ResidualBlockId id;
    int size;
    Kind kind;
  };

  void add(ceres::CostFunction* cost, const std::vector<int>& blocks, Kind kind) {
    std::vector<double*> pointers;
    for (const int b : blocks) {
      pointers.push_back(pointer(b));
      used_[static_cast<std::size_t>(b)] = 1;
    }
    const int size = cost->num_residuals();
    rows_.push_back({problem_->AddResidualBlock(cost, nullptr, pointers), size, kind});
  }

  std::vector<int> blocks_of_frames(std::initializer_list<int> frames) const {
    std::vector<int> blocks;
    Evaluated e;
    for (const int f : frames) {
      adjustment_.evaluate(f, state_, true, e);
      for (int k = 0; k < e.count; ++k) {
        const int b = e.slots[static_cast<std::size_t>(k)].block;
        if (std::find(blocks.begin(), blocks.end(), b) == blocks.end()) blocks.push_back(b);
      }
    }
    return blocks;
  }

  void add_ties() {
    for (const TieGroup& group : adjustment_.groups) {
      if (group.astray || std::all_of(group.ties.begin(), group.ties.end(),
                                      [](const Tie& t) { return t.held_out; }))
        continue;
      std::vector<int> blocks = blocks_of_frames({group.host, group.frame});
      auto* cost = new TieCost(adjustment_, group, blocks);
      add(cost, blocks, Ties);
    }
  }

  void add_known() {
    for (const KnownPoint& point : adjustment_.known_points) {
      const std::vector<int> blocks = blocks_of_frames({point.frame});
      add(new KnownPointCost(adjustment_, point, blocks), blocks, Known);
    }
    for (const KnownHeight& height : adjustment_.known_heights) {
      if (!(height.robust > 0.0)) continue;
      const auto [knot, weight] = adjustment_.knot_place(height.t_s);
      std::vector<int> blocks{blocks_.globals(), knot};
      if (weight > 0.0) blocks.push_back(knot + 1);
      add(new KnownHeightCost(height, weight), blocks, Known);
    }
  }

  void add_priors() {
    const AdjustmentPriors& p = adjustment_.priors;
    const bool first = adjustment_.before_first.has_value();
    const auto& t = adjustment_.knot_times_s;
    for (std::size_t k = 0; k < t.size(); ++k) {
      const int block = static_cast<int>(k);
      Eigen::VectorXd keep = Eigen::VectorXd::Zero(6), sigma = p.knot;
      if (k > 0) {
        const double dt = t[k] - t[k - 1];
        for (int c = 0; c < 6; ++c) {
          keep[c] = std::exp(-dt / (c < 3 ? p.position_correlation_s : p.attitude_correlation_s));
          sigma[c] *= std::sqrt(std::max(1e-12, 1.0 - keep[c] * keep[c]));
        }
        add(new LinkCost(keep, sigma, Eigen::VectorXd::Zero(6), true), {block, block - 1}, Knots);
      } else if (!first) {
        add(new LinkCost(keep, sigma, Eigen::VectorXd::Zero(6), false), {block}, Knots);
      }
    }
    const auto one = [](double x) { return Eigen::VectorXd(Eigen::VectorXd::Constant(1, x)); };
    const bool any_delayed =
        std::any_of(adjustment_.frames.begin(), adjustment_.frames.end(),
                    [](const AdjustedFrame& f) { return f.delayed && !f.own; });
    if (any_delayed && !adjustment_.delay_knot_times_s.empty()) {
      const auto& d = adjustment_.delay_knot_times_s;
      for (std::size_t k = 0; k < d.size(); ++k) {
        const int block = blocks_.delay(static_cast<int>(k));
        if (k == 0 && first) continue;
        if (k == 0)
          add(new LinkCost(one(0), one(p.delay_s), one(adjustment_.delay_start_s), false), {block},
              Delays);
        else
          add(new LinkCost(one(1), one(p.delay_walk_s * std::sqrt(d[k] - d[k - 1])), one(0), true),
              {block, block - 1}, Delays);
      }
    }
    for (int f = 0; f < blocks_.frames; ++f) {
      const int block = blocks_.jitter(f);
      if (!used_[static_cast<std::size_t>(block)] || (first && f == 0)) continue;
      add(new LinkCost(one(0), one(p.jitter_s), one(0), false), {block}, Jitters);
    }
    const int globals = blocks_.globals();
    std::vector<int> fixed;
    Eigen::VectorXd sigma(Globals::kSize);
    free_globals_.clear();
    for (int k = 0; k < Globals::kSize; ++k) {
      if (p.globals[k] > 0.0)
        free_globals_.push_back(k);
      else
        fixed.push_back(k);
      sigma[k] = p.globals[k] > 0.0 ? p.globals[k] : 1.0;
    }
    if (first)
      add_first();
    else
      add(new LinkCost(Eigen::VectorXd::Zero(Globals::kSize), sigma,
                       Eigen::VectorXd::Zero(Globals::kSize), false),
          {globals}, Shared);
    if (free_globals_.empty())
      problem_->SetParameterBlockConstant(pointer(globals));
    else if (!fixed.empty())
      problem_->SetManifold(pointer(globals), new ceres::SubsetManifold(Globals::kSize, fixed));
    if (free_globals_.empty()) used_[static_cast<std::size_t>(globals)] = 0;
  }

  /// In the order of FirstFramePrior.
  void add_first() {
    std::vector<int> blocks;
    std::vector<std::vector<int>> columns;
    int column = 0;
    const auto lay = [&](int block) {
      std::vector<int> own;
      for (int k = 0; k < blocks_.size(block); ++k)
        own.push_back(
            block == blocks_.globals() && adjustment_.priors.globals[k] <= 0.0 ? -1 : column++);
      blocks.push_back(block);
      columns.push_back(std::move(own));
    };
    for (const int block : adjustment_.first_blocks()) lay(block);
    add(new FirstFrameCost(*adjustment_.before_first, std::move(columns)), blocks, First);
  }

  const Adjustment& adjustment_;
  AdjustmentState& state_;
  Blocks blocks_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<Rows> rows_;
  std::vector<char> used_;
  std::vector<int> free_globals_;
};

std::vector<int> Adjustment::first_blocks() const {
  const Blocks blocks = blocks_of(state);
  std::vector<int> out{0};
  const bool delayed = !frames.empty() && frames.front().delayed && !frames.front().own;
  if (delayed && priors.jitter_s > 0.0) out.push_back(blocks.jitter(0));
  if (delayed && blocks.delays > 0) out.push_back(blocks.delay(0));
  out.push_back(blocks.globals());
  return out;
}

void Adjustment::forget_first(double walk_s) {
  // Of the first two frames alone: all that touches the first, and what the second has for itself.
  Adjustment pair(*navigation_, mount_, focal_px_, readout_s_);
  pair.frames = {frames[0], frames[1]};
  pair.knot_times_s = {knot_times_s[0], knot_times_s[1]};
  pair.delay_knot_times_s = delay_knot_times_s;
  pair.delay_start_s = delay_start_s;
  pair.priors = priors;
  pair.before_first = before_first;
  pair.state = state;
  pair.state.knots.resize(2);
  pair.state.jitter_s.resize(2);
  pair.state.extra.resize(2);
  for (const TieGroup& g : groups)
    if (g.host == 0 && g.frame == 1) pair.groups.push_back(g);
  const Blocks blocks = blocks_of(pair.state);
  const Problem problem(pair, pair.state);
  const auto linear = problem.linearise();
  before_first.reset();
  if (linear->good) {
    // Of the second frame it is what `before_first` holds, in that order.
    std::vector<int> kept{1};
    const bool delayed = frames[1].delayed && !frames[1].own;
    if (delayed && priors.jitter_s > 0.0) kept.push_back(blocks.jitter(1));
    if (delayed && blocks.delays > 0) kept.push_back(blocks.delay(0));
    kept.push_back(blocks.globals());
    std::vector<Eigen::Index> columns;  // -1: what nothing told of has its prior
    std::vector<double> mean;
    Eigen::Index walks = -1;
    for (const int b : kept) {
      const int column = linear->first_column[static_cast<std::size_t>(b)];
      const double* at = problem.pointer(b);
      if (blocks.delays > 0 && b == blocks.delay(0))
        walks = static_cast<Eigen::Index>(columns.size());
      if (b == blocks.globals()) {
        for (std::size_t k = 0; column >= 0 && k < problem.free_globals().size(); ++k) {
          columns.push_back(column + static_cast<Eigen::Index>(k));
          mean.push_back(at[problem.free_globals()[k]]);
        }
      } else {
        for (int k = 0; k < blocks.size(b); ++k) {
          columns.push_back(column < 0 ? -1 : column + k);
          mean.push_back(column < 0 ? 0.0 : at[k]);
        }
      }
    }
    const auto n = static_cast<Eigen::Index>(columns.size());
    const Eigen::VectorXd step =
        linear->normal.solve(-(linear->jacobian.transpose() * linear->residuals));
    FirstFramePrior made{Eigen::VectorXd(n), Eigen::MatrixXd::Zero(n, n)};
    for (Eigen::Index c = 0; c < n; ++c) {
      const auto column = columns[static_cast<std::size_t>(c)];
      made.mean[c] = mean[static_cast<std::size_t>(c)];
      if (column < 0) {
        // A frame's own delay is all that may have no row.
        made.covariance(c, c) = priors.jitter_s * priors.jitter_s;
        continue;
      }
      made.mean[c] += step[column];
      Eigen::VectorXd unit = Eigen::VectorXd::Zero(linear->jacobian.cols());
      unit[column] = 1.0;
      const Eigen::VectorXd solved = linear->normal.solve(unit);
      for (Eigen::Index r = 0; r < n; ++r)
        if (const auto row = columns[static_cast<std::size_t>(r)]; row >= 0)
          made.covariance(r, c) = solved[row];
    }
    made.covariance = 0.5 * (made.covariance + made.covariance.transpose()).eval();
    if (walks >= 0) made.covariance(walks, walks) += walk_s * walk_s;
    if (made.mean.allFinite() && made.covariance.allFinite() &&
        made.covariance.llt().info() == Eigen::Success)
      before_first = std::move(made);
  }
  frames.erase(frames.begin());
  for (AdjustedFrame& f : frames) --f.knot;
  knot_times_s.erase(knot_times_s.begin());
  state.knots.erase(state.knots.begin());
  state.jitter_s.erase(state.jitter_s.begin());
  state.extra.erase(state.extra.begin());
  std::erase_if(groups, [](const TieGroup& g) { return g.host == 0 || g.frame == 0; });
  for (TieGroup& g : groups) --g.host, --g.frame;
}

NavigationSample Adjustment::recorded(int index) const {
  const AdjustedFrame& frame = frames[static_cast<std::size_t>(index)];
  return frame.own ? *frame.own
                   : navigation_->at(time_s(index, state), state.globals[Globals::kLatency]);
}

void Excitation::add(const Adjustment& adjustment, int frame) {
  const NavigationSample nav = adjustment.recorded(frame);
  const Eigen::Quaterniond platform = nav.reference * nav.gimbal;
  if (!first_) first_ = platform;
  const auto& knot =
      adjustment.state
          .knots[static_cast<std::size_t>(adjustment.frames[static_cast<std::size_t>(frame)].knot)];
  const auto count = [](Sums& s, const Eigen::Vector3d& turn) {
    s.n += 1.0;
    s.sum += turn;
    s.square += turn.squaredNorm();
  };
  count(recorded_, log_rotation(platform * first_->conjugate()));
  count(errors_, Eigen::Vector3d(knot[3], knot[4], knot[5]));
}

Excitation excitation_of(const Adjustment& adjustment) {
  Excitation out;
  for (std::size_t i = 0; i < adjustment.frames.size(); ++i)
    if (adjustment.frames[i].weight == 0.0) out.add(adjustment, static_cast<int>(i));
  return out;
}

void hold_for_want_of_turns(Adjustment& adjustment, double delay_s) {
  constexpr double kHeldDelay_s = 1e-5;
  adjustment.priors.globals.segment<3>(Globals::kMount).setZero();
  adjustment.priors.globals.segment<3>(Globals::kLever).setZero();
  adjustment.priors.delay_s = adjustment.priors.delay_walk_s = kHeldDelay_s;
  adjustment.delay_start_s = delay_s;
  adjustment.reset();
}

void Adjustment::look_at_residuals(bool first, bool forgiving) {
  std::vector<double> height_residuals_m;
  for (const KnownHeight& h : known_heights)
    height_residuals_m.push_back(h.error_m - height_error_m(h.t_s, state));
  weigh_heights(known_heights, height_residuals_m);
  std::vector<double> sizes;
  const Cameras now = cameras(state);
  for (TieGroup& group : groups)
    for (Tie& tie : group.ties) {
      const auto r = residual_px(group, tie, now);
      tie.robust = r ? (tie.whiten * *r).norm() : -1.0;  // for the moment
      if (r && !tie.held_out) sizes.push_back(tie.robust);
    }
  if (sizes.empty()) return;
  const auto middle_of = [](std::vector<double>& v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
  };
  std::vector<double> at_knots, between;
  const auto is_between = [this](const TieGroup& g) {
    return frames[static_cast<std::size_t>(g.host)].weight > 0.0 ||
           frames[static_cast<std::size_t>(g.frame)].weight > 0.0;
  };
  for (const TieGroup& group : groups)
    for (const Tie& tie : group.ties)
      if (tie.robust >= 0.0 && !tie.held_out)
        (is_between(group) ? between : at_knots).push_back(tie.robust);
  constexpr std::size_t kEnough = 20;
  constexpr double kMostApart = 1.5;
  const double apart =
      at_knots.size() < kEnough || between.size() < kEnough
          ? 1.0
          : std::clamp(middle_of(between) / std::max(1e-3, middle_of(at_knots)), 1.0, 100.0);
  sizes.clear();
  for (TieGroup& group : groups) {
    group.scale = is_between(group) ? apart : 1.0;
    group.astray = group.scale > kMostApart;
    for (Tie& tie : group.ties) {
      if (tie.robust < 0.0) continue;
      tie.robust /= group.scale;
      if (!tie.held_out) sizes.push_back(tie.robust);
    }
  }
  // Places differ: the corner of a floe is found to a tenth of what a smudge is. Each is weighed by
  // its own residuals, drawn towards those of all where there are few.
  const double all = std::max(1e-3, middle_of(sizes));
  std::map<int, std::vector<double>> of_track;
  if (!first)
    for (const TieGroup& group : groups)
      for (const Tie& tie : group.ties)
        if (tie.track >= 0 && tie.robust >= 0.0) of_track[tie.track].push_back(tie.robust);
  constexpr double kDrawn = 4.0;
  std::map<int, double> scale_of_track;
  for (auto& [track, residuals] : of_track) {
    const auto n = static_cast<double>(residuals.size());
    const double own = middle_of(residuals) / all;
    scale_of_track[track] =
        std::clamp(std::sqrt((n * own * own + kDrawn) / (n + kDrawn)), 0.1, 10.0);
  }
  sizes.clear();
  for (TieGroup& group : groups)
    for (Tie& tie : group.ties) {
      const auto found = scale_of_track.find(tie.track);
      tie.scale = found == scale_of_track.end() ? 1.0 : found->second;
      if (tie.robust < 0.0) continue;
      tie.robust /= tie.scale;
      if (!tie.held_out) sizes.push_back(tie.robust);
    }
  const double sigma = std::max(0.1, middle_of(sizes) / kMedianOfTwo);
  priors.tie = first ? std::max(sigma, 2.0) : sigma;
  for (TieGroup& group : groups) {
    // A frame whose time or pose is still wrong is off as a whole: that is what is to be found, and
    // only what strays from the others of its pair is to be doubted.
    double own = priors.tie;
    if (forgiving) {
      sizes.clear();
      for (const Tie& tie : group.ties)
        if (tie.robust >= 0.0) sizes.push_back(tie.robust);
      if (!sizes.empty()) own = std::max(own, middle_of(sizes) / kMedianOfTwo);
    }
    for (Tie& tie : group.ties) {
      const double x = tie.robust / (3.0 * own);
      tie.robust = tie.robust < 0.0 || (x > 4.0 && !first) ? 0.0 : 1.0 / (1.0 + x * x);
    }
  }
}

double Adjustment::log_evidence() const {
  AdjustmentState copy = state;
  return log_evidence(*Problem(*this, copy).linearise());
}

double Adjustment::log_evidence(const Linear& linear_at) const {
  const Linear* linear = &linear_at;
  if (!linear->good) return -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  // Ties by the heavy-tailed density whose weights they have; other rows are normal.
  const Cameras now = cameras(state);
  for (const TieGroup& group : groups)
    for (const Tie& tie : group.ties) {
      if (tie.held_out) continue;
      const auto r = residual_px(group, tie, now);
      const double sigma = priors.tie * tie.scale * group.scale;
      const double x2 = r ? (tie.whiten * *r).squaredNorm() / std::pow(3.0 * sigma, 2) : 1e4;
      sum -= 4.5 * std::log1p(x2) + 2.0 * std::log(sigma);
    }
  for (std::size_t r = 0; r < linear->kind.size(); ++r)
    if (linear->kind[r] != Problem::Ties) {
      const double x = linear->residuals[static_cast<Eigen::Index>(r)];
      sum -= 0.5 * x * x;
    }
  // What each prior's width costs: the determinant of its rows by their unknowns.
  for (std::size_t k = 0; k < knot_times_s.size(); ++k)
    for (int c = 0; c < 6; ++c) {
      double sigma = priors.knot[c];
      if (k > 0) {
        const double tau = c < 3 ? priors.position_correlation_s : priors.attitude_correlation_s;
        sigma *= std::sqrt(
            std::max(1e-12, 1.0 - std::exp(-2.0 * (knot_times_s[k] - knot_times_s[k - 1]) / tau)));
      }
      sum -= std::log(sigma);
    }
  if (priors.jitter_s > 0.0)
    sum -= static_cast<double>(
               std::count(linear->kind.begin(), linear->kind.end(), Problem::Jitters)) *
           std::log(priors.jitter_s);
  const Eigen::SparseMatrix<double> factor = linear->normal.matrixL();
  for (Eigen::Index k = 0; k < factor.rows(); ++k) sum -= std::log(factor.coeff(k, k));
  return sum;
}

Adjustment::Summary Adjustment::solve(const AdjustmentOptions& options) {
  Summary total;
  // Sigmas from residuals can run away where the data tell little of them: the evidence decides.
  struct Best {
    double evidence = -std::numeric_limits<double>::infinity();
    AdjustmentPriors priors;
    AdjustmentState state;
  } best;
  for (int round = 0; round < options.rounds; ++round) {
    look_at_residuals(round == 0 && !options.warm, round + 1 < options.rounds);
    Problem problem(*this, state);
    const Summary s = problem.solve(options);
    total.usable = s.usable;
    total.iterations += s.iterations;
    total.seconds += s.seconds;
    if (!s.usable) return total;
    if (!options.estimate_variances) continue;
    // Variance components (Förstner 1979): what the residuals of a kind of rows weigh, over the
    // share of them that the solution did not use up. The trace is by random signs (Hutchinson).
    look_at_residuals(false, round + 1 < options.rounds);
    Problem again(*this, state);
    const auto linear = again.linearise();
    if (!linear->good) continue;
    if (const double evidence = log_evidence(*linear); evidence > best.evidence)
      best = {evidence, priors, state};
    if (round + 1 == options.rounds) break;
    std::mt19937 random(17);
    struct Component {
      double squares = 0.0, rows = 0.0, used = 0.0;
    };
    std::array<Component, 3> part;  // position, attitude, jitter
    const auto part_of = [&](Eigen::Index r) {
      const auto at = static_cast<std::size_t>(r);
      if (linear->kind[at] == Problem::Knots) return linear->component[at] < 3 ? 0 : 1;
      return linear->kind[at] == Problem::Jitters ? 2 : -1;
    };
    for (Eigen::Index r = 0; r < linear->residuals.size(); ++r)
      if (const int k = part_of(r); k >= 0) {
        part[static_cast<std::size_t>(k)].squares += linear->residuals[r] * linear->residuals[r];
        part[static_cast<std::size_t>(k)].rows += 1.0;
      }
    constexpr int kProbes = 8;
    for (int k = 0; k < 3; ++k) {
      if (part[static_cast<std::size_t>(k)].rows == 0.0) continue;
      for (int probe = 0; probe < kProbes; ++probe) {
        Eigen::VectorXd z = Eigen::VectorXd::Zero(linear->residuals.size());
        for (Eigen::Index r = 0; r < z.size(); ++r)
          if (part_of(r) == k) z[r] = (random() & 1U) != 0 ? 1.0 : -1.0;
        const Eigen::VectorXd jz = linear->jacobian.transpose() * z;
        const Eigen::VectorXd x = linear->normal.solve(jz);
        part[static_cast<std::size_t>(k)].used += jz.dot(x) / kProbes;
      }
    }
    const auto factor = [&](int k) {
      const Component& c = part[static_cast<std::size_t>(k)];
      // Where nearly all is used up the residuals say nothing of it.
      const double redundancy = c.rows - c.used;
      if (c.rows < 6 || redundancy < 0.02 * c.rows) return 1.0;
      return std::clamp(std::sqrt(c.squares / redundancy), 0.2, 5.0);
    };
    priors.knot.head<3>() *= factor(0);
    priors.knot.tail<3>() *= factor(1);
    priors.knot = priors.knot.cwiseMin(priors.knot_most);
    if (priors.jitter_s > 0.0) priors.jitter_s = std::max(1e-5, priors.jitter_s * factor(2));
  }
  if (std::isfinite(best.evidence)) {
    priors = best.priors;
    state = best.state;
    look_at_residuals(false, false);
  }
  return total;
}

Globals::Vector Adjustment::globals_sigma_by_places(const AdjustmentOptions& options) const {
  constexpr int kParts = 6;
  std::vector<Globals::Vector> found;
  for (int part = 0; part < kParts; ++part) {
    Adjustment without = *this;
    for (TieGroup& g : without.groups)
      for (Tie& t : g.ties)
        // By a step that has no divisor in common with that of the places which judge.
        if (t.track >= 0 && (t.track / 7) % kParts == part) t.held_out = true;
    Problem problem(without, without.state);
    if (!problem.solve(options).usable) continue;
    found.push_back(without.state.globals);
  }
  Globals::Vector mean = Globals::Vector::Zero(), square = Globals::Vector::Zero();
  if (found.size() < 2) return square;
  const auto n = static_cast<double>(found.size());
  for (const Globals::Vector& g : found) mean += g / n;
  for (const Globals::Vector& g : found) square += (g - mean).cwiseAbs2();
  return ((n - 1.0) / n * square).cwiseSqrt();
}

void Adjustment::solve_frames() {
  std::vector<std::vector<const TieGroup*>> groups_of(frames.size());
  for (const TieGroup& g : groups) groups_of[static_cast<std::size_t>(g.frame)].push_back(&g);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const AdjustedFrame& frame = frames[i];
    if (frame.weight <= 0.0) continue;
    const double dt = knot_times_s[static_cast<std::size_t>(frame.knot) + 1] -
                      knot_times_s[static_cast<std::size_t>(frame.knot)];
    Eigen::Matrix<double, 6, 1> sigma;
    for (int c = 0; c < 6; ++c) {
      const double tau = c < 3 ? priors.position_correlation_s : priors.attitude_correlation_s;
      sigma[c] = priors.knot[c] *
                 std::sqrt(2.0 * dt / tau * std::max(0.02, frame.weight * (1 - frame.weight)));
    }
    solve_frame(static_cast<int>(i), groups_of[i], sigma, 0.0, false);
  }
}

Eigen::Matrix<double, 6, 6> Adjustment::solve_frame(int frame,
                                                    const std::vector<const TieGroup*>& of_frame,
                                                    const Eigen::Matrix<double, 6, 1>& sigma,
                                                    double jitter_s, bool reweigh) {
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  const auto i = static_cast<std::size_t>(frame);
  const int steps = reweigh ? 4 : 2;
  std::vector<ModelCamera> hosts;
  for (const TieGroup* g : of_frame) hosts.push_back(camera(g->host));
  Vector7 information;
  information << sigma.cwiseAbs2().cwiseInverse(),
      jitter_s > 0.0 ? 1.0 / (jitter_s * jitter_s) : 1.0;
  Eigen::Map<Eigen::Matrix<double, 6, 1>> extra(state.extra[i].data());
  Matrix7 normal;
  Eigen::Matrix<double, 6, 7> by;
  for (int step = 0; step < steps; ++step) {
    Evaluated e;
    evaluate(frame, state, true, e);
    // Of the frame's own error its knot's derivative is the whole, where it has but one.
    by.leftCols<6>() = e.slots[0].by.leftCols<6>() / (1.0 - frames[i].weight);
    by.col(6).setZero();
    if (jitter_s > 0.0) by.col(6) << -e.camera.velocity_m_s, -e.camera.rate_rad_s;
    normal = information.asDiagonal();
    Vector7 right;
    right << -(information.head<6>().cwiseProduct(extra)),
        (jitter_s > 0.0 ? -information[6] * state.jitter_s[i] : 0.0);
    for (std::size_t g = 0; g < of_frame.size(); ++g) {
      const double elapsed_s = e.t_s - time_s(of_frame[g]->host, state);
      for (const Tie& tie : of_frame[g]->ties) {
        if (tie.held_out || tie.robust <= 0.0) continue;
        const auto t = transfer(hosts[g].at_row(tie.host_row, readout_s_),
                                e.camera.at_row(tie.frame_row, readout_s_), tie.host, tie.frame,
                                state.globals[Globals::kFocal],
                                state.globals.segment<2>(Globals::kDrift), elapsed_s);
        if (!t) continue;
        const Eigen::Matrix2d whole = focal_px_ / (priors.tie * tie.scale) * tie.whiten;
        double robust = tie.robust;
        if (reweigh) {
          // Loose at first: a frame that is off as a whole is to be moved, not doubted.
          const double x2 = (whole * t->residual).squaredNorm() / (step == 0 ? 900.0 : 9.0);
          robust = 1.0 / (1.0 + x2);
        }
        const Eigen::Matrix2d scale = std::sqrt(robust) * whole;
        const Eigen::Matrix<double, 2, 7> rows = scale * t->by_frame * by;
        normal += rows.transpose() * rows;
        right -= rows.transpose() * (scale * t->residual);
      }
    }
    for (const KnownPoint& point : known_points) {
      if (point.frame != frame) continue;
      const auto seen = see_known(point, state);
      if (!seen) continue;
      const Eigen::Matrix<double, 2, 7> rows = point.whiten * seen->by_camera * by;
      normal += rows.transpose() * rows;
      right -= rows.transpose() * (point.whiten * seen->residual_px);
    }
    const Vector7 move = normal.ldlt().solve(right);
    extra += move.head<6>();
    if (jitter_s > 0.0) state.jitter_s[i] += move[6];
  }
  return by * normal.inverse() * by.transpose();
}

std::optional<Adjustment::Knowledge> Adjustment::knowledge() const {
  AdjustmentState copy = state;
  Problem problem(*this, copy);
  const auto linear = problem.linearise();
  if (!linear->good) return std::nullopt;
  const Blocks& blocks = problem.blocks();
  const Eigen::Index n = linear->jacobian.cols();
  const auto column_of = [&](int block) {
    return linear->first_column[static_cast<std::size_t>(block)];
  };
  const auto& free_globals = problem.free_globals();

  Knowledge out;
  const auto variance = [&](Eigen::Index column) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(n);
    unit[column] = 1.0;
    return linear->normal.solve(unit)[column];
  };
  for (std::size_t k = 0; k < free_globals.size(); ++k)
    out.globals_sigma[free_globals[k]] =
        std::sqrt(variance(column_of(blocks.globals()) + static_cast<Eigen::Index>(k)));
  for (std::size_t k = 0; k < state.delay_s.size(); ++k) {
    const int column = column_of(blocks.delay(static_cast<int>(k)));
    out.delay_sigma_s.push_back(column < 0 ? 0.0 : std::sqrt(variance(column)));
  }

  for (std::size_t k = 0; k < state.jitter_s.size(); ++k) {
    const int column = column_of(blocks.jitter(static_cast<int>(k)));
    out.jitter_sigma_s.push_back(column < 0 ? std::numeric_limits<double>::infinity()
                                            : std::sqrt(variance(column)));
  }

  // A camera's rows: 6 x n, sparse.
  const auto rows_of = [&](int frame) {
    Evaluated e;
    evaluate(frame, copy, true, e);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n, 6);
    for (int k = 0; k < e.count; ++k) {
      const Slot& slot = e.slots[static_cast<std::size_t>(k)];
      const int first = column_of(slot.block);
      if (first < 0) continue;
      if (slot.block == blocks.globals()) {
        for (std::size_t c = 0; c < free_globals.size(); ++c)
          rows.row(first + static_cast<Eigen::Index>(c)) +=
              slot.by.col(free_globals[c]).transpose();
      } else {
        rows.middleRows(first, slot.size) += slot.by.transpose();
      }
    }
    return std::pair(rows, e.camera);
  };
  const auto ground = [](const ModelCamera& camera) {
    Matrix26 g = Matrix26::Zero();
    auto hit = hit_sea(camera, Eigen::Vector3d::UnitZ());
    if (!hit) {
      g.leftCols<2>().setIdentity();
      return g;
    }
    g.leftCols<3>() = hit->by_position.topRows<2>();
    g.rightCols<3>() = -(hit->by_direction * skew(hit->ray)).topRows<2>();
    return g;
  };
  constexpr std::size_t kMostAsked = 300;
  const std::size_t stride =
      std::max<std::size_t>(1, (frames.size() + kMostAsked - 1) / kMostAsked);
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < frames.size(); i += stride) asked.push_back(i);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(n, 2);
  for (const std::size_t i : asked) {
    const auto [rows, camera] = rows_of(static_cast<int>(i));
    mean += rows * ground(camera).transpose() / static_cast<double>(asked.size());
  }
  const Eigen::MatrixXd with_mean = linear->normal.solve(mean);
  out.shared_m2 = mean.transpose() * with_mean;
  const Eigen::Matrix2d inverse_shared =
      (out.shared_m2 + 1e-18 * Eigen::Matrix2d::Identity()).inverse();
  std::vector<Matrix6> covariances;
  for (const std::size_t i : asked) {
    const auto rows = rows_of(static_cast<int>(i)).first;
    const Eigen::MatrixXd solved = linear->normal.solve(rows);
    const Eigen::Matrix<double, 6, 2> cross = rows.transpose() * with_mean;
    const Matrix6 all = rows.transpose() * solved;
    covariances.push_back(all - cross * inverse_shared * cross.transpose());
  }
  for (std::size_t i = 0; i < frames.size(); ++i)
    out.camera.push_back(covariances[std::min(covariances.size() - 1, (i + stride / 2) / stride)]);
  return out;
}

}  // namespace watersky::align
