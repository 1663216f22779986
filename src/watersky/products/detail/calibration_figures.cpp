// SPDX-License-Identifier: MIT
#include "watersky/products/detail/calibration_figures.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/products/detail/html.hpp"
#include "watersky/products/palette.hpp"

namespace watersky::detail {

namespace {

constexpr double kWidth = 520;  // of a figure in its own units

/// An image-shaped frame and the way from its pixels to the figure.
struct Frame {
  double scale, height;
  explicit Frame(const CameraModel& camera)
      : scale(kWidth / camera.width_px()), height(scale * camera.height_px()) {}
  [[nodiscard]] double x(double u) const { return (u + 0.5) * scale; }
  [[nodiscard]] double y(double v) const { return (v + 0.5) * scale; }
  /// `below`: room under the frame.
  [[nodiscard]] std::string begin(const std::string& label, double below = 0) const {
    return "<svg class=\"chart\" viewBox=\"-1 -1 " + number(kWidth + 2, 0) + " " +
           number(height + 2 + below, 0) + "\" role=\"img\" aria-label=\"" + label + "\">";
  }
  [[nodiscard]] std::string border() const {
    return "<rect x=\"0\" y=\"0\" width=\"" + number(kWidth, 0) + "\" height=\"" +
           number(height, 1) + "\" fill=\"none\" stroke=\"var(--soft)\"/>";
  }
};

std::string at(double x, double y) { return number(x, 1) + " " + number(y, 1); }

/// Calls with pixel and residual of every point that was used.
template <class Visit>
void each_used(const TargetCalibration& calibration, const Visit& visit) {
  for (const CalibrationView& view : calibration.views) {
    if (!view.used) continue;
    for (std::size_t i = 0; i < view.residuals.size(); ++i)
      if (!view.left_out[i]) visit(view.target->points[i].seen, view.residuals[i]);
  }
}

/// 1, 2 or 5 times a power of ten, not above `value`.
double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0})
    if (step * power <= value) return step * power;
  return power;
}

std::string pixels(double value) {
  return number(value, value < 0.1 ? 3 : value < 1 ? 2 : value < 10 ? 1 : 0) + " px";
}

double farthest_corner_px(const CameraModel& camera) {
  const double u0 = camera.camera_matrix()(0, 2), v0 = camera.camera_matrix()(1, 2);
  return std::hypot(std::max(u0, camera.width_px() - 1 - u0),
                    std::max(v0, camera.height_px() - 1 - v0));
}

}  // namespace

std::string residual_svg(const TargetCalibration& calibration) {
  const Frame frame(calibration.camera);
  const double longest = std::max(2.5 * calibration.rms_px, 1e-6);
  const double magnified = 0.055 * kWidth / longest;  // figure units a pixel of residual
  std::string lines, dots;
  each_used(calibration, [&](const Pixel& p, const Eigen::Vector2d& r) {
    const double x = frame.x(p.u), y = frame.y(p.v);
    lines += "M" + at(x, y) + "L" + at(x + magnified * r.x(), y + magnified * r.y());
    dots += "M" + at(x, y) + "h.01";
  });
  const double bar = round_below(longest);
  const double foot = frame.height + 22;
  return frame.begin("Residuals in the image", 34) +
         "<defs><clipPath id=\"res-frame\"><rect x=\"0\" y=\"0\" width=\"" + number(kWidth, 0) +
         "\" height=\"" + number(frame.height, 1) + "\"/></clipPath></defs>" +
         "<g clip-path=\"url(#res-frame)\"><path d=\"" + lines +
         "\" stroke=\"var(--count)\" stroke-width=\"1\" fill=\"none\"/><path d=\"" + dots +
         "\" stroke=\"var(--ink)\" stroke-width=\"1.8\" stroke-linecap=\"round\" fill=\"none\"/>"
         "</g>" +
         frame.border() + "<path d=\"M2 " + number(foot, 1) + "h" + number(magnified * bar, 1) +
         "\" stroke=\"var(--count)\" stroke-width=\"2.5\"/><text x=\"" +
         number(magnified * bar + 10, 1) + "\" y=\"" + number(foot + 4, 1) + "\">" + pixels(bar) +
         " of residual, drawn " + rounded(magnified / frame.scale) + " times as long</text></svg>";
}

std::string residual_cloud_svg(const TargetCalibration& calibration) {
  constexpr double kSide = 300, kMiddle = kSide / 2;
  const double reach = std::max(4 * calibration.sigma_px, 1e-6);
  const double scale = kMiddle / reach;
  std::string dots, rings;
  each_used(calibration, [&](const Pixel&, const Eigen::Vector2d& r) {
    const double x = std::clamp(r.x(), -reach, reach), y = std::clamp(r.y(), -reach, reach);
    dots += "M" + at(kMiddle + scale * x, kMiddle + scale * y) + "h.01";
  });
  for (const int sigmas : {1, 2, 3}) {
    const double radius = sigmas * scale * calibration.sigma_px;
    rings += "<circle cx=\"150\" cy=\"150\" r=\"" + number(radius, 1) +
             "\" fill=\"none\" stroke=\"var(--area)\" stroke-width=\"1.3\"/><text x=\"" +
             number(kMiddle + 0.7071 * radius + 4, 1) + "\" y=\"" +
             number(kMiddle - 0.7071 * radius - 2, 1) + "\">" + std::to_string(sigmas) +
             " σ</text>";
  }
  return "<svg class=\"chart\" viewBox=\"-1 -1 302 334\" style=\"max-width:330px\" role=\"img\" "
         "aria-label=\"Residuals about nothing\"><path class=\"grid\" d=\"M0 150H300M150 0V300\"/>"
         "<path d=\"" +
         dots +
         "\" stroke=\"var(--count)\" stroke-opacity=\".55\" stroke-width=\"2.6\" "
         "stroke-linecap=\"round\" fill=\"none\"/>" +
         rings +
         "<rect x=\"0\" y=\"0\" width=\"300\" height=\"300\" fill=\"none\" "
         "stroke=\"var(--soft)\"/><text x=\"150\" y=\"322\" text-anchor=\"middle\">σ = " +
         pixels(calibration.sigma_px) + " of each coordinate</text></svg>";
}

std::string coverage_svg(const TargetCalibration& calibration) {
  const Frame frame(calibration.camera);
  const ImageCoverage& c = calibration.coverage;
  const int most = std::max(1, *std::max_element(c.points.begin(), c.points.end()));
  const double w = kWidth / c.columns, h = frame.height / c.rows;
  std::string cells, dots;
  for (int row = 0; row < c.rows; ++row)
    for (int column = 0; column < c.columns; ++column) {
      const int n = c.points[static_cast<std::size_t>(row * c.columns + column)];
      const double share = std::sqrt(static_cast<double>(n) / most);
      cells += "<rect x=\"" + number(column * w, 1) + "\" y=\"" + number(row * h, 1) +
               "\" width=\"" + number(w, 1) + "\" height=\"" + number(h, 1) + "\" fill=\"" +
               (n > 0 ? "var(--count)\" fill-opacity=\"" + number(0.12 + 0.5 * share, 2)
                      : std::string("url(#cov-none)")) +
               "\" stroke=\"var(--line)\"/>";
      if (n > 0)
        dots += "<text x=\"" + number(column * w + 4, 1) + "\" y=\"" + number(row * h + 13, 1) +
                "\">" + std::to_string(n) + "</text>";
    }
  std::string points;
  each_used(calibration, [&](const Pixel& p, const Eigen::Vector2d&) {
    points += "M" + at(frame.x(p.u), frame.y(p.v)) + "h.01";
  });
  return frame.begin("Coverage of the image") +
         "<defs><pattern id=\"cov-none\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\" "
         "patternTransform=\"rotate(45)\"><rect class=\"unseen-ground\" width=\"7\" "
         "height=\"7\"/><rect class=\"unseen-line\" width=\"1.6\" height=\"7\"/></pattern></defs>" +
         cells + "<path d=\"" + points +
         "\" stroke=\"var(--ink)\" stroke-width=\"1.8\" stroke-linecap=\"round\" fill=\"none\"/>"
         "<g class=\"counts\">" +
         dots + "</g>" + frame.border() + "</svg>";
}

std::string tilt_svg(const TargetCalibration& calibration) {
  constexpr double kMiddle = 150, kReach = 130;
  double most = 45;
  for (const CalibrationView& view : calibration.views)
    if (view.used) most = std::max(most, view.tilt_deg);
  most = std::ceil(most / 15) * 15;
  std::string rings, dots;
  for (double tilt = 15; tilt <= most; tilt += 15) {
    const double r = kReach * tilt / most;
    rings += "<circle class=\"grid\" cx=\"150\" cy=\"150\" r=\"" + number(r, 1) +
             "\" fill=\"none\"/><text x=\"" + number(kMiddle + 0.7071 * r + 3, 1) + "\" y=\"" +
             number(kMiddle - 0.7071 * r - 2, 1) + "\">" + number(tilt, 0) + "°</text>";
  }
  for (const CalibrationView& view : calibration.views) {
    if (!view.used || !view.camera_from_target) continue;
    // The side of the normal that looks at the camera; it leans to where the target faces.
    Eigen::Vector3d normal = view.camera_from_target->col(2);
    if (normal.z() > 0) normal = -normal;
    const double across = std::hypot(normal.x(), normal.y());
    const double r = kReach * view.tilt_deg / most / std::max(across, 1e-9);
    dots += "<circle class=\"by-count\" fill-opacity=\".8\" cx=\"" +
            number(kMiddle + r * normal.x(), 1) + "\" cy=\"" + number(kMiddle + r * normal.y(), 1) +
            "\" r=\"5\"/>";
  }
  return "<svg class=\"chart\" viewBox=\"0 0 300 300\" style=\"max-width:330px\" role=\"img\" "
         "aria-label=\"Tilt of the target\"><path class=\"grid\" d=\"M20 150H280M150 20V280\"/>" +
         rings + dots + "</svg>";
}

std::string distortion_svg(const TargetCalibration& calibration) {
  const CameraModel& camera = calibration.camera;
  const Frame frame(camera);
  const CameraModel straight = camera.without_distortion();
  const double u0 = camera.camera_matrix()(0, 2), v0 = camera.camera_matrix()(1, 2);
  constexpr int kLines = 8;  // to the right of the centre, within the image of a straight lens
  const double step = std::max(camera.width_px(), camera.height_px()) / (2.0 * kLines);
  std::string bent, ideal;
  // Lines of the straight grid go on beyond the image: a barrel brings them in.
  constexpr int kBeyond = 3 * kLines, kPieces = 8;
  const auto line = [&](bool upright, int index) {
    bool pen = false;
    const double along = index * step;
    for (int i = -kBeyond * kPieces; i <= kBeyond * kPieces; ++i) {
      const double across = i * step / kPieces;
      const Pixel p{u0 + (upright ? along : across), v0 + (upright ? across : along)};
      const auto direction = straight.direction(p);
      const auto seen = direction ? camera.project(*direction) : std::nullopt;
      if (!seen || !camera.contains(*seen)) {
        pen = false;
        continue;
      }
      bent += (pen ? "L" : "M") + at(frame.x(seen->u), frame.y(seen->v));
      pen = true;
    }
    const double x = frame.x(u0 + along), y = frame.y(v0 + along);
    if (upright && x > 0 && x < kWidth) ideal += "M" + at(x, 0) + "V" + number(frame.height, 1);
    if (!upright && y > 0 && y < frame.height) ideal += "M" + at(0, y) + "H" + number(kWidth, 0);
  };
  for (int i = -kBeyond; i <= kBeyond; ++i) line(true, i), line(false, i);
  return frame.begin("Distortion") + "<path d=\"" + ideal +
         "\" stroke=\"var(--soft)\" stroke-opacity=\".6\" stroke-dasharray=\"3 4\" "
         "fill=\"none\"/><path d=\"" +
         bent + "\" stroke=\"var(--count)\" stroke-width=\"1.4\" fill=\"none\"/><circle cx=\"" +
         number(frame.x(u0), 1) + "\" cy=\"" + number(frame.y(v0), 1) +
         "\" r=\"4\" fill=\"var(--area)\"/><path d=\"M" + at(kWidth / 2 - 6, frame.height / 2) +
         "h12M" + at(kWidth / 2, frame.height / 2 - 6) +
         "v12\" stroke=\"var(--ink)\" stroke-width=\"1.3\"/>" + frame.border() + "</svg>";
}

std::string radial_svg(const TargetCalibration& calibration) {
  const CameraModel& camera = calibration.camera;
  constexpr double kLeft = 62, kTop = 12, kHigh = 250, kWide = kWidth - kLeft - 14;
  const double corner = farthest_corner_px(camera);
  const double focal = camera.focal_px();
  const double u0 = camera.camera_matrix()(0, 2), v0 = camera.camera_matrix()(1, 2);
  // Along the radius in the picture, to the right; decentring is left to the other figure.
  std::vector<std::pair<double, double>> curve;
  double least = 0, most = 0;
  for (int i = 0; i <= 120; ++i) {
    const double r = corner * i / 120;
    const auto direction = camera.direction({u0 + r, v0});
    if (!direction || !(direction->v.z() > 0.05)) break;
    const double straight =
        focal * std::hypot(direction->v.x(), direction->v.y()) / direction->v.z();
    if (straight > 6 * corner) break;
    curve.emplace_back(r, r - straight);
    least = std::min(least, r - straight), most = std::max(most, r - straight);
  }
  if (curve.size() < 2) return {};
  const double range = std::max(most - least, 0.1);
  const double step = round_below(range / 3);
  least = std::floor(least / step) * step, most = std::ceil(most / step) * step;
  if (most <= least) most = least + step;
  const auto x = [&](double r) { return kLeft + kWide * r / corner; };
  const auto y = [&](double d) { return kTop + kHigh * (most - d) / (most - least); };
  std::string svg = "<svg class=\"chart\" viewBox=\"0 0 " + number(kWidth, 0) +
                    " 306\" role=\"img\" aria-label=\"Distortion along the radius\">";
  const double seen = corner * std::min(1.0, calibration.coverage.radius_share);
  svg += "<rect x=\"" + number(x(seen), 1) + "\" y=\"" + number(kTop, 0) + "\" width=\"" +
         number(x(corner) - x(seen), 1) + "\" height=\"" + number(kHigh, 0) +
         "\" class=\"unseen-ground\"/>";
  for (double d = least; d <= most + 0.01 * step; d += step) {
    svg += "<path class=\"grid\" d=\"M" + at(kLeft, y(d)) + "H" + number(kLeft + kWide, 1) +
           "\"/><text x=\"" + number(kLeft - 8, 0) + "\" y=\"" + number(y(d) + 4, 1) +
           "\" text-anchor=\"end\">" +
           number(std::abs(d) < 1e-9 ? 0 : d, step < 0.1 ? 2
                                              : step < 1 ? 1
                                                         : 0) +
           "</text>";
  }
  const double r_step = round_below(corner / 3);
  for (double r = 0; r <= corner; r += r_step)
    svg += "<text x=\"" + number(x(r), 1) + "\" y=\"" + number(kTop + kHigh + 18, 0) +
           "\" text-anchor=\"middle\">" + number(r, 0) + "</text>";
  std::string path;
  for (const auto& [r, d] : curve) path += (path.empty() ? "M" : "L") + at(x(r), y(d));
  return svg + "<path d=\"" + path +
         "\" stroke=\"var(--count)\" stroke-width=\"2\" fill=\"none\"/><text x=\"" +
         number(kLeft + kWide / 2, 0) + "\" y=\"" + number(kTop + kHigh + 38, 0) +
         "\" text-anchor=\"middle\">pixels from the principal point</text><text "
         "transform=\"translate(14 " +
         number(kTop + kHigh / 2, 0) +
         ")rotate(-90)\" text-anchor=\"middle\">moved outwards, px</text></svg>";
}

}  // namespace watersky::detail
