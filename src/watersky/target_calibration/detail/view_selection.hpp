// SPDX-License-Identifier: MIT
#pragma once
/// Which views, and which of their points, can be believed.
#include "watersky/target_calibration/detail/lens_fit.hpp"
#include "watersky/target_calibration/target_calibration.hpp"

namespace watersky::detail {

class ViewSelection {
 public:
  /// All views in which a target was found; `views` get their reasons and outlive this.
  ViewSelection(std::vector<CalibrationView>& views, const CalibrationParameters& parameters);

  /// Places in the list of all views, and their points, in the same order.
  [[nodiscard]] const std::vector<std::size_t>& active() const { return active_; }
  [[nodiscard]] const std::vector<FitView>& points() const { return points_; }

  void reject(std::size_t place, std::string reason);
  void reject_copies();
  void reject_blurred();
  /// Degenerate where fewer are left than must be; "only 2 of 9 views `what`".
  [[nodiscard]] Status enough(const std::string& what) const;

  /// A first fit, of the one lens model that suits better, without the views and the gross points
  /// that stand out.
  [[nodiscard]] Result<LensFit> settle(LensChoice choice, int width_px, int height_px);

  /// Rejects the view that stands out most, if any does, and takes its pose out of `fit`.
  bool reject_worst(LensFit& fit);
  /// Points whose residual is above so many sigmas get no weight, all others their full one.
  void leave_out_points(const LensFit& fit, double sigmas);
  /// From pictures of discs to pictures of their centres, as `fit` has it.
  void correct_discs(const LensFit& fit);

 private:
  struct RobustFit;
  [[nodiscard]] std::optional<RobustFit> robust_fit(LensModel model, int width_px,
                                                    int height_px) const;

  std::vector<CalibrationView>& views_;
  const CalibrationParameters& parameters_;
  std::vector<std::size_t> active_;
  std::vector<FitView> points_;
  std::size_t copies_ = 0;
};

[[nodiscard]] double median(std::vector<double> values);

/// Sigma of one coordinate, from the median length of the residuals, in pixels.
[[nodiscard]] double residual_sigma_px(std::span<const FitView> views, const LensFit& fit);

/// Of the points that have weight.
[[nodiscard]] double rms_px(const FitView& view, const Lens& lens, const TargetPose& pose);

/// Angle of the target's plane to the image plane, from 0 to 90 degrees.
[[nodiscard]] double tilt_deg(const TargetPose& pose);

}  // namespace watersky::detail
