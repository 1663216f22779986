// SPDX-License-Identifier: MIT
#pragma once
/// A camera's intrinsics from views of a flat target (Zhang 2000; the model is that of the thesis's
/// 2.9 to 2.12), with how well they are known.
///
/// Views that show the target where another one does, that are blurred, that have no pose or whose
/// residuals stand far out of the others' are rejected, each with its reason. The lens model is the
/// simplest that predicts views it was not fitted to as well as the best does: each tenth of the
/// views is left out in turn, its poses are fitted with the lens of the others, and residuals are
/// compared view by view. What a plain RMS favours, more coefficients, costs there.
///
/// Circles are taken as discs: what is compared with a centroid is the centroid of the picture of
/// the disc, not the picture of its centre (detail/lens_fit.hpp).
///
/// Sigmas are those of least squares with the residuals' own spread, or, where that is larger, of
/// the residuals summed view by view: a board that is not flat or corners that err alike make them
/// grow. They say nothing of what all views have in common, such as a target whose rows and
/// columns are not spaced alike.
#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/base/progress.hpp"
#include "watersky/geo/rigid3.hpp"
#include "watersky/target_calibration/target.hpp"

namespace watersky {

enum class LensChoice { Auto, Pinhole, Fisheye };

struct CalibrationParameters {
  int min_views = 4;
  double outlier_mads = 5.0;
  double point_outlier_sigmas = 5.0;
  double least_move_px = 1.0;
  double simpler_within_sigmas = 1.0;
  double max_focal_sigma = 0.02;
  double max_centre_sigma = 0.03;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.min_views, ParameterInfo{"min_views", "1", "fewest usable views", 3, 10000});
    visit(self.outlier_mads,
          ParameterInfo{"outlier_mads", "1",
                        "a view is rejected when its residual or blur is so many median absolute "
                        "deviations (scaled to sigmas) above the median",
                        2, 1000});
    visit(self.point_outlier_sigmas,
          ParameterInfo{"point_outlier_sigmas", "1",
                        "a point is left out when its residual is so many sigmas", 3, 1000});
    visit(self.least_move_px,
          ParameterInfo{"least_move_px", "px",
                        "a view is rejected when no point moved farther than this from another "
                        "view",
                        0, 1000});
    visit(self.simpler_within_sigmas,
          ParameterInfo{"simpler_within_sigmas", "1",
                        "a simpler lens model is taken when it predicts left out views worse than "
                        "the best by less than so many standard errors",
                        0, 100});
    visit(self.max_focal_sigma,
          ParameterInfo{"max_focal_sigma", "1",
                        "refused when the focal length's relative sigma is above this", 0, 1});
    visit(self.max_centre_sigma,
          ParameterInfo{"max_centre_sigma", "1",
                        "refused when the principal point's sigma, over the image's longer side, "
                        "is above this",
                        0, 1});
  }
};

/// What came of one image.
struct CalibrationView {
  std::string name;
  bool used = false;
  std::string reason;  ///< why it was rejected; empty when it was used
  std::optional<DetectedTarget> target;
  /// Seen less predicted, a point each, in pixels, for views that have a pose; rejected ones are
  /// compared with the lens of the others.
  std::vector<Eigen::Vector2d> residuals;
  std::vector<bool> left_out;  ///< points whose residual stands out, in a view that was used
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  double tilt_deg = std::numeric_limits<double>::quiet_NaN();  ///< of the target to the image plane
  double distance = std::numeric_limits<double>::quiet_NaN();  ///< to its middle, in spacings
  std::optional<Eigen::Matrix<double, 3, 4>> camera_from_target;  ///< lengths in spacings
};

/// A lens model that was tried.
struct LensCandidate {
  std::string name;  ///< "pinhole k1 k2"
  LensModel lens = LensModel::Pinhole;
  int parameters = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square residual in views that were left out of the fit.
  double left_out_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// By how much it predicts worse than the best one, in standard errors over views.
  double worse_by_sigmas = std::numeric_limits<double>::quiet_NaN();
  std::string fault;          ///< why it cannot be taken; empty: it can
  bool folds_unseen = false;  ///< it folds back before the image's corners, where no point was seen
  bool chosen = false;
};

struct EstimatedParameter {
  std::string name;  ///< "fx", "k1"
  double value = 0.0;
  double sigma = 0.0;
  bool estimated = true;  ///< otherwise held at its value
};

/// Where in the image points of used views lie.
struct ImageCoverage {
  int columns = 0, rows = 0;
  std::vector<int> points;  ///< of each cell, row by row
  double share = 0.0;       ///< of cells with a point
  /// How far from the principal point the farthest point lies, of the farthest image corner.
  double radius_share = 0.0;
};

struct TargetCalibration {
  explicit TargetCalibration(CameraModel model) : camera(std::move(model)) {}

  CameraModel camera;
  TargetKind kind = TargetKind::Chessboard;
  TargetSize size;  ///< of the target, as asked for or as found
  bool size_was_found = false;
  std::vector<EstimatedParameter> parameters;
  Eigen::MatrixXd covariance;  ///< of those that were estimated, in their order
  double rms_px = 0.0;         ///< root mean square length of the residuals
  double sigma_px = 0.0;       ///< of one coordinate of one point
  std::size_t points = 0;
  /// Largest over the image's corners, of where the lens shows a given direction.
  double corner_sigma_px = 0.0;
  double middle_sigma_px = 0.0;  ///< the same in the image's middle
  ImageCoverage coverage;
  double tilt_spread_deg = 0.0;  ///< largest angle between two views' targets
  std::vector<CalibrationView> views;
  std::vector<LensCandidate> candidates;
  std::vector<std::string> notes;  ///< what a person should know, a clause each
  [[nodiscard]] std::size_t used_views() const;
};

/// `views` in which no target was found have their reason already; they are passed through.
/// Degenerate when too few views are left, when all show the target at one place, and when they
/// do not tell the focal length or the centre: the message says what to photograph.
[[nodiscard]] Result<TargetCalibration> calibrate_views(
    std::vector<CalibrationView> views, int width_px, int height_px,
    LensChoice lens = LensChoice::Auto, const CalibrationParameters& parameters = {},
    const Progress& progress = {});

}  // namespace watersky
