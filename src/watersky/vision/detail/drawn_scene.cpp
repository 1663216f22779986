// SPDX-License-Identifier: MIT
#include "watersky/vision/detail/drawn_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/vision/ice_training.hpp"

namespace watersky::detail {
namespace {

double log_uniform(cv::RNG& random, double low, double high) {
  return std::exp(random.uniform(std::log(low), std::log(high)));
}

/// Noise smoothed over `sigma_px`, of zero mean and unit deviation.
cv::Mat smooth_noise(cv::Size size, double sigma_px, cv::RNG& random) {
  // Coarse noise is drawn small and enlarged: the blur would cost more than all the rest.
  const double by = std::max(1.0, sigma_px / 3.0);
  cv::Mat noise(
      cv::Size(std::max(2, cvCeil(size.width / by)), std::max(2, cvCeil(size.height / by))),
      CV_32F);
  random.fill(noise, cv::RNG::NORMAL, 0.0, 1.0);
  cv::GaussianBlur(noise, noise, {}, sigma_px / by);
  cv::resize(noise, noise, size, 0, 0, cv::INTER_CUBIC);
  cv::Scalar mean, deviation;
  cv::meanStdDev(noise, mean, deviation);
  return (noise - mean[0]) * (1.0 / std::max(deviation[0], 1e-6));
}

/// The level that `part` of the plane lies above.
float upper_quantile(const cv::Mat& plane, double part) {
  std::vector<float> levels(plane.begin<float>(), plane.end<float>());
  const auto at =
      levels.begin() + static_cast<long>((1.0 - part) * static_cast<double>(levels.size() - 1));
  std::nth_element(levels.begin(), at, levels.end());
  return *at;
}

/// A convex floe with 4 to 12 corners, about round.
std::vector<cv::Point> polygon(cv::Point2d centre, double radius, cv::RNG& random) {
  std::vector<double> angles(static_cast<std::size_t>(random.uniform(4, 13)));
  for (double& angle : angles) angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  std::sort(angles.begin(), angles.end());
  const double squeeze = random.uniform(0.5, 1.0), turn = random.uniform(0.0, std::numbers::pi);
  std::vector<cv::Point> corners;
  for (const double angle : angles) {
    const double u = radius * std::cos(angle), v = squeeze * radius * std::sin(angle);
    corners.emplace_back(cvRound(centre.x + u * std::cos(turn) - v * std::sin(turn)),
                         cvRound(centre.y + u * std::sin(turn) + v * std::cos(turn)));
  }
  return corners;
}

/// Ice to draw, and what is added to the level of each of its pieces.
struct Pieces {
  cv::Mat ice;    ///< CV_8U
  cv::Mat level;  ///< CV_32F, of zero mean and about unit deviation over the pieces
};

/// Floes of all sizes on `part` of the picture, beside or on top of each other.
Pieces floes(cv::Size size, double part, cv::RNG& random) {
  Pieces pieces{cv::Mat::zeros(size, CV_8U), cv::Mat::zeros(size, CV_32F)};
  const double largest = log_uniform(random, 6.0, 90.0), slope = random.uniform(1.0, 4.0);
  const double target = part * size.area();
  const bool round = random.uniform(0, 3) == 0;
  for (int i = 0; i < 6000; ++i) {
    if (i % 16 == 0 && cv::countNonZero(pieces.ice) >= target) break;
    const double radius = 1.5 + largest * std::pow(random.uniform(0.0, 1.0), slope);
    const cv::Point2d centre(random.uniform(0.0, double(size.width)),
                             random.uniform(0.0, double(size.height)));
    const double level = random.gaussian(1.0);
    if (round) {
      const cv::Size axes(std::max(1, cvRound(radius)),
                          std::max(1, cvRound(radius * random.uniform(0.5, 1.0))));
      const double angle = random.uniform(0.0, 180.0);
      cv::ellipse(pieces.ice, cv::Point(centre), axes, angle, 0, 360, 255, cv::FILLED);
      cv::ellipse(pieces.level, cv::Point(centre), axes, angle, 0, 360, level, cv::FILLED);
    } else {
      const std::vector<cv::Point> corners = polygon(centre, radius, random);
      cv::fillConvexPoly(pieces.ice, corners, 255);
      cv::fillConvexPoly(pieces.level, corners, level);
    }
  }
  return pieces;
}

/// Closed ice, cut by leads, with a few holes.
Pieces leads(cv::Size size, double part, cv::RNG& random) {
  Pieces pieces{cv::Mat(size, CV_8U, cv::Scalar(255)), smooth_noise(size, 40.0, random)};
  const double target = part * size.area();
  const double widest = log_uniform(random, 2.0, 30.0);
  for (int i = 0; i < 400 && cv::countNonZero(pieces.ice) > target; ++i) {
    cv::Point2d at(random.uniform(0.0, double(size.width)),
                   random.uniform(0.0, double(size.height)));
    double course = random.uniform(0.0, 2.0 * std::numbers::pi);
    if (random.uniform(0, 4) == 0) {
      cv::fillConvexPoly(pieces.ice, polygon(at, 1.5 * widest, random), 0);
      continue;
    }
    const int width = std::max(1, cvRound(widest * std::pow(random.uniform(0.0, 1.0), 2.0)));
    for (int k = 0; k < 12; ++k) {
      course += random.gaussian(0.35);
      const double reach = random.uniform(10.0, 60.0);
      const cv::Point2d next = at + reach * cv::Point2d(std::cos(course), std::sin(course));
      cv::line(pieces.ice, cv::Point(at), cv::Point(next), 0, width);
      at = next;
    }
  }
  return pieces;
}

/// Brash, slush and ragged patches, large and small.
Pieces patches(cv::Size size, double part, cv::RNG& random) {
  cv::Mat field = cv::Mat::zeros(size, CV_32F);
  const double finest = log_uniform(random, 1.5, 12.0);
  for (double sigma = finest, weight = 1.0; sigma < 60.0; sigma *= 2.5, weight *= 1.3)
    field += weight * smooth_noise(size, sigma, random);
  return {field > upper_quantile(field, part), smooth_noise(size, 30.0, random)};
}

/// Ponds on what is well within the ice.
cv::Mat ponds(const cv::Mat& ice, cv::RNG& random) {
  cv::Mat within;
  cv::erode(ice, within, cv::Mat::ones(5, 5, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT,
            cv::Scalar(255));
  const cv::Mat field = smooth_noise(ice.size(), log_uniform(random, 2.0, 8.0), random);
  return (field > upper_quantile(field, random.uniform(0.02, 0.3))) & within;
}

/// A class's level everywhere: its own, a texture and its pieces' differences.
cv::Mat surface(cv::Size size, double level, double texture, double texture_px, cv::RNG& random) {
  cv::Mat plane = smooth_noise(size, texture_px, random) * texture;
  return plane + level;
}

/// Water from black over blue, teal and brown to gray; BGR in levels of 255.
cv::Scalar water_colour(cv::RNG& random) {
  static constexpr std::array<std::array<double, 3>, 5> kHues{
      {{1.0, 0.75, 0.35}, {1.0, 0.95, 0.55}, {0.85, 1.0, 0.6}, {0.6, 0.85, 1.0}, {1.0, 0.95, 0.9}}};
  const auto& hue = kHues[static_cast<std::size_t>(random.uniform(0, 5))];
  const double level = random.uniform(15.0, 150.0);
  cv::Scalar colour;
  for (int c = 0; c < 3; ++c)
    colour[c] =
        std::max(0.0, level * hue[static_cast<std::size_t>(c)] * (1.0 + random.gaussian(0.07)));
  return colour;
}

}  // namespace

DrawnScene draw_scene(cv::Size size, bool in_colour, cv::RNG& random) {
  // By its colour one class alone can be known, by its gray level not.
  double part = random.uniform(0.02, 0.98);
  if (in_colour && random.uniform(0, 5) == 0) part = random.uniform(0, 2);
  DrawnScene scene;
  Pieces pieces;
  // Floes where there is room for them to be seen, leads where there is not.
  switch (random.uniform(0, 5)) {
    case 0:
      pieces = patches(size, part, random);
      scene.floes_have_shape = false;
      break;
    case 1: pieces = part > 0.5 ? leads(size, part, random) : floes(size, part, random); break;
    case 2: pieces = leads(size, std::max(part, 1.0 - part), random); break;
    default: pieces = floes(size, part, random); break;
  }
  if (part == 0.0 || part == 1.0) pieces.ice.setTo(part > 0.5 ? 255 : 0);
  scene.mask.create(size, CV_8U);
  scene.mask.setTo(static_cast<int>(IceClass::Water));
  scene.mask.setTo(static_cast<int>(IceClass::Ice), pieces.ice);
  const bool with_ponds = !in_colour && random.uniform(0, 2) == 0;
  const cv::Mat pond = with_ponds ? ponds(pieces.ice, random) : cv::Mat();
  if (with_ponds) scene.mask.setTo(static_cast<int>(IceClass::MeltPond), pond);

  // Everything in units of the contrast. Which of the two is the rougher is for the photographs to
  // say; of drawn ice only the shape is like ice.
  const double contrast = in_colour ? random.uniform(50.0, 150.0) : random.uniform(40.0, 150.0);
  const double rough = contrast * random.uniform(0.0, 0.25),
               own = contrast * random.uniform(0.0, 0.2);
  const double waves =
      contrast * (in_colour ? random.uniform(0.0, 0.1) : random.uniform(0.0, 0.25));
  const double ice_px = log_uniform(random, 1.0, 15.0), wave_px = log_uniform(random, 1.0, 15.0);
  if (in_colour) {
    const cv::Scalar water = water_colour(random);
    // Ice is whiter than this water, and not bluer than glacier ice.
    const double highest = std::max({water[0], water[1], water[2]});
    const double level = std::min(245.0, highest + random.uniform(0.3, 1.0) * contrast);
    const double blue = random.uniform(-0.03, 0.12);
    const cv::Scalar ice(level * (1.0 + 0.5 * blue), level, level * (1.0 - blue));
    const cv::Mat ice_texture = surface(size, 0.0, rough, ice_px, random) + own * pieces.level;
    const cv::Mat water_texture = surface(size, 0.0, waves, wave_px, random);
    std::vector<cv::Mat> channels;
    for (int c = 0; c < 3; ++c) {
      cv::Mat plane = water_texture * (water[c] / std::max(highest, 1.0)) + water[c];
      cv::Mat(ice_texture + ice[c]).copyTo(plane, pieces.ice);
      channels.push_back(plane);
    }
    cv::merge(channels, scene.image);
  } else {
    const double water = 128.0 - 0.5 * contrast;
    scene.image = surface(size, water, waves, wave_px, random);
    // Currents, fresh water, new ice: to a thermal camera the sea is not of one level.
    if (random.uniform(0, 2) == 0)
      scene.image += contrast * random.uniform(0.0, 0.35) *
                     smooth_noise(size, log_uniform(random, 15.0, 120.0), random);
    cv::Mat(surface(size, water + contrast, rough, ice_px, random) + own * pieces.level)
        .copyTo(scene.image, pieces.ice);
    if (with_ponds) {
      // Fresh water on ice: as warm or dark as the sea, less so, or a good deal more.
      const double level = water + contrast * random.uniform(-1.0, 0.6);
      surface(size, level, waves, wave_px, random).copyTo(scene.image, pond);
    }
  }
  cv::GaussianBlur(scene.image, scene.image, {}, log_uniform(random, 0.3, 1.6));
  return scene;
}

}  // namespace watersky::detail
