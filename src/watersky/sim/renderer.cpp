// SPDX-License-Identifier: MIT
#include "watersky/sim/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "watersky/sim/detail/earth.hpp"
#include "watersky/sim/detail/random.hpp"
#include "watersky/sim/detail/sea_index.hpp"

namespace watersky::sim {
namespace {

constexpr int kTextureCells = 1024;
constexpr double kFineCell_m = 0.12;
constexpr double kCoarseCell_m = 0.97;   ///< no small multiple of the other: no visible period
constexpr int kPeriods = 1000;           ///< to a million grains from the anchor
constexpr double kFarthest_m = 30000.0;  ///< beyond it a ray counts as sky

/// Water and ice in a visible image, blue, green, red, relative to the level and to the contrast.
constexpr double kWaterTint[3] = {1.18, 1.0, 0.72};
constexpr double kIceTint[3] = {0.94, 1.0, 1.04};

cv::Mat make_texture(std::uint64_t seed) {
  cv::RNG rng(mix(seed, static_cast<std::uint64_t>(Stream::Texture)));
  cv::Mat sum = cv::Mat::zeros(kTextureCells, kTextureCells, CV_32F);
  for (const double sigma : {1.2, 3.5, 10.0}) {
    cv::Mat white(kTextureCells, kTextureCells, CV_32F), wide;
    rng.fill(white, cv::RNG::NORMAL, 0.0, 1.0);
    const int border = static_cast<int>(std::ceil(4.0 * sigma));
    cv::copyMakeBorder(white, wide, border, border, border, border, cv::BORDER_WRAP);
    cv::GaussianBlur(wide, wide, {}, sigma);
    const cv::Mat octave = wide({border, border, kTextureCells, kTextureCells});
    cv::Scalar mean, deviation;
    cv::meanStdDev(octave, mean, deviation);
    sum += (octave - mean[0]) / deviation[0];
  }
  cv::Scalar mean, deviation;
  cv::meanStdDev(sum, mean, deviation);
  return (sum - mean[0]) / deviation[0];
}

}  // namespace

Result<Renderer> Renderer::make(const Sea& sea, const LensParameters& lens,
                                const SensorParameters& sensor, std::uint64_t seed,
                                const Eigen::Vector2d& drift) {
  WATERSKY_CHECK(validate(lens));
  WATERSKY_CHECK(validate(sensor));
  if (sensor.bits != 8 && sensor.bits != 16)
    return Error{ErrorCode::Usage, "bits must be 8 or 16, is " + std::to_string(sensor.bits)};
  if (sensor.bits == 16 && sensor.jpeg_quality > 0)
    return Error{ErrorCode::Usage, "images of 16 bits cannot be JPEG; set jpeg_quality to 0"};
  return Renderer(sea, lens, sensor, seed, drift);
}

Renderer::Renderer(const Sea& sea, const LensParameters& lens, const SensorParameters& sensor,
                   std::uint64_t seed, const Eigen::Vector2d& drift)
    : sea_(sea),
      lens_(lens),
      sensor_(sensor),
      seed_(seed),
      drift_(drift),
      fine_cells_per_m_(1.0 / sensor.texture_cell_m),
      coarse_cells_per_m_(1.0 / (kCoarseCell_m * (sensor.texture_cell_m / kFineCell_m))) {
  const SeaSurface surface(sea.anchor());
  half_curvature_north_ = surface.half_curvature_north();
  half_curvature_east_ = surface.half_curvature_east();

  const Lens model(lens);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const int width = lens.width_px, height = lens.height_px;
  directions_.reserve(static_cast<std::size_t>(width + 2) * static_cast<std::size_t>(height + 2));
  for (int v = -1; v <= height; ++v)
    for (int u = -1; u <= width; ++u) {
      const auto d = model.direction({u, v});
      directions_.push_back(d ? Ray{static_cast<float>(d->x()), static_cast<float>(d->y()),
                                    static_cast<float>(d->z())}
                              : Ray{nan, nan, nan});
    }

  if (std::any_of(directions_.begin(), directions_.end(),
                  [](const Ray& d) { return std::isnan(d.z); })) {
    dark_.create(height, width, CV_8U);
    const auto stride = static_cast<std::size_t>(width + 2);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u)
        dark_.at<unsigned char>(v, u) =
            std::isnan(directions_[static_cast<std::size_t>(v + 1) * stride +
                                   static_cast<std::size_t>(u + 1)]
                           .z)
                ? 255
                : 0;
  }

  Random random(seed, Stream::Appearance);
  double weighted = 0.0, area = 0.0;
  for (const IceObject& object : sea.objects()) {
    const double level = std::clamp(1.0 + sensor.floe_variation * random.normal(), 0.4, 1.6);
    ice_level_.push_back(static_cast<float>(level));
    weighted += level * object.area_m2;
    area += object.area_m2;
  }
  for (float& level : ice_level_) level *= static_cast<float>(area / weighted);
  texture_ = make_texture(seed);

  gain_.create(height, width, CV_32F);
  const double corner2 = 0.25 * (width * width + height * height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const double x = u - 0.5 * (width - 1), y = v - 0.5 * (height - 1);
      gain_.at<float>(v, u) =
          static_cast<float>(1.0 - sensor.vignetting * (x * x + y * y) / corner2);
    }
  cv::RNG rng(mix(seed, static_cast<std::uint64_t>(Stream::Pattern)));
  pattern_.create(height, width, CV_32F);
  cv::Mat columns(1, width, CV_32F);
  const double share = sensor.pattern_counts * std::sqrt(0.5);
  rng.fill(pattern_, cv::RNG::NORMAL, 0.0, share);
  rng.fill(columns, cv::RNG::NORMAL, 0.0, share);
  pattern_ += cv::repeat(columns, height, 1);
}

float Renderer::texture(double north, double east, unsigned offset) const {
  const auto sample = [&](double cells_per_m, unsigned shift) {
    // Whole periods are added so that truncation rounds down.
    const double x = east * cells_per_m + kPeriods * kTextureCells;
    const double y = north * cells_per_m + kPeriods * kTextureCells;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const auto ax = static_cast<float>(x - column), ay = static_cast<float>(y - row);
    constexpr unsigned kMask = kTextureCells - 1;
    const unsigned c = static_cast<unsigned>(column) + shift;
    const unsigned r = static_cast<unsigned>(row) + 3 * shift;
    const float* top = texture_.ptr<float>(static_cast<int>(r & kMask));
    const float* bottom = texture_.ptr<float>(static_cast<int>((r + 1) & kMask));
    const unsigned c0 = c & kMask, c1 = (c + 1) & kMask;
    return (1 - ay) * ((1 - ax) * top[c0] + ax * top[c1]) +
           ay * ((1 - ax) * bottom[c0] + ax * bottom[c1]);
  };
  return 0.70711F * (sample(fine_cells_per_m_, offset) + sample(coarse_cells_per_m_, offset + 397));
}

void Renderer::trace_row(const ScenePose& pose, double t_s, int v, float weight,
                         cv::Mat& rays) const {
  const int s = sensor_.supersampling, width = lens_.width_px;
  const auto stride = static_cast<std::size_t>(width + 2);
  const Ray* here = directions_.data() + static_cast<std::size_t>(v + 1) * stride + 1;
  const Ray* above = here - stride;
  const Ray* below = here + stride;
  const Eigen::Matrix3d& r = pose.scene_from_camera;
  const Eigen::Vector3d& o = pose.origin_m;
  const bool picture = sea_.has_picture();
  const SeaIndex* index = sea_.index();
  const double half_north = 0.5 * sea_.extent().north_m, half_east = 0.5 * sea_.extent().east_m;
  const double drift_north = drift_.x() * t_s, drift_east = drift_.y() * t_s;
  const auto ice_texture = static_cast<float>(sensor_.ice_texture);
  const auto water_texture = static_cast<float>(sensor_.water_texture);
  const auto fog = static_cast<float>(sensor_.fog_brightness);
  const auto sky =
      static_cast<float>(sensor_.fog_per_m > 0.0 ? sensor_.fog_brightness : sensor_.sky_brightness);

  std::array<double, 8> offset{};
  for (int i = 0; i < s; ++i) offset[static_cast<std::size_t>(i)] = (i + 0.5) / s - 0.5;
  constexpr float kNotYet = std::numeric_limits<float>::max();

  for (int u = 0; u < width; ++u) {
    const Eigen::Vector3d d = r * Eigen::Vector3d(here[u].x, here[u].y, here[u].z);
    // The distance along the unit ray to the paraboloid, from the plane's by one correction; what
    // is left is the correction times the slope of the sea: micrometres over a scene.
    const double per_down = 1.0 / d.z();
    double range = -o.z() * per_down;
    const double n = o.x() + range * d.x(), e = o.y() + range * d.y();
    range += (n * n * half_curvature_north_ + e * e * half_curvature_east_) * per_down;
    if (!(d.z() > 1e-5 && range > 0.0 && range < kFarthest_m)) {
      for (int j = 0; j < s; ++j) {
        float* out = rays.ptr<float>(v * s + j) + static_cast<std::ptrdiff_t>(u) * s;
        for (int i = 0; i < s; ++i) out[i] += weight * sky;
      }
      continue;
    }
    const double middle_north = o.x() + range * d.x(), middle_east = o.y() + range * d.y();
    // The place on the sea changes by range (δ - d δz/dz) for a change δ of the direction.
    const Eigen::Vector3d right = r * Eigen::Vector3d(0.5 * (here[u + 1].x - here[u - 1].x),
                                                      0.5 * (here[u + 1].y - here[u - 1].y),
                                                      0.5 * (here[u + 1].z - here[u - 1].z));
    const Eigen::Vector3d down =
        r * Eigen::Vector3d(0.5 * (below[u].x - above[u].x), 0.5 * (below[u].y - above[u].y),
                            0.5 * (below[u].z - above[u].z));
    const double right_tilt = right.z() * per_down, down_tilt = down.z() * per_down;
    const double right_north = range * (right.x() - d.x() * right_tilt);
    const double right_east = range * (right.y() - d.y() * right_tilt);
    const double down_north = range * (down.x() - d.x() * down_tilt);
    const double down_east = range * (down.y() - d.y() * down_tilt);

    float clear = 1.0F;
    if (sensor_.fog_per_m > 0.0) clear = static_cast<float>(std::exp(-sensor_.fog_per_m * range));
    // Texture varies little within a pixel: once for all its rays, and only where it shows.
    float ice_here = kNotYet, water_here = kNotYet;
    const double here_north = middle_north - drift_north, here_east = middle_east - drift_east;
    const auto brightness_of = [&](int object) {
      if (object >= 0) {
        if (ice_here == kNotYet) ice_here = ice_texture * texture(here_north, here_east, 0);
        return ice_level_[static_cast<std::size_t>(object)] + ice_here;
      }
      if (water_here == kNotYet)
        water_here = water_texture * texture(middle_north, middle_east, 611);
      return water_here;
    };
    const auto through_fog = [&](float seen) {
      return weight * (clear * seen + (1.0F - clear) * fog);
    };

    int object = -1;
    if (index && !picture &&
        index->same_around(here_north, here_east,
                           0.5 * (std::abs(right_north) + std::abs(down_north)),
                           0.5 * (std::abs(right_east) + std::abs(down_east)), object)) {
      const float light = through_fog(brightness_of(object));
      for (int j = 0; j < s; ++j) {
        float* out = rays.ptr<float>(v * s + j) + static_cast<std::ptrdiff_t>(u) * s;
        for (int i = 0; i < s; ++i) out[i] += light;
      }
      continue;
    }
    for (int j = 0; j < s; ++j) {
      float* out = rays.ptr<float>(v * s + j) + static_cast<std::ptrdiff_t>(u) * s;
      const double oj = offset[static_cast<std::size_t>(j)];
      for (int i = 0; i < s; ++i) {
        const double oi = offset[static_cast<std::size_t>(i)];
        // A turned grid: no two rays of a pixel share a row or a column, so an edge along either
        // is resolved to 1/s² of a pixel, not 1/s.
        const double a = oi + oj / s, b = oj - oi / s;
        const double north = here_north + a * right_north + b * down_north;
        const double east = here_east + a * right_east + b * down_east;
        float seen = 0.0F;
        if (!picture) {
          seen = brightness_of(index ? index->object_at(north, east) : sea_.object_at(north, east));
        } else if (std::abs(north) <= half_north && std::abs(east) <= half_east) {
          seen = sea_.picture_at(north, east);
        }
        out[i] += through_fog(seen);
      }
    }
  }
}

int Renderer::exposures(const ScenePoseAt& pose, double t_s) const {
  if (sensor_.exposure_s == 0.0) return 1;
  const ScenePose a = pose(t_s - 0.5 * sensor_.exposure_s),
                  b = pose(t_s + 0.5 * sensor_.exposure_s);
  const double moved = (a.origin_m - b.origin_m).norm() / std::max(0.1, -a.origin_m.z());
  const double turned = (a.scene_from_camera - b.scene_from_camera).norm();
  // Half a pixel between two instants keeps the steps below the pixel's own box.
  return std::clamp(static_cast<int>(std::ceil(2.0 * lens_.focal_px * (moved + turned))), 1, 64);
}

cv::Mat Renderer::brightness(const ScenePoseAt& pose_at, double t_s) const {
  const int s = sensor_.supersampling, width = lens_.width_px, height = lens_.height_px;
  cv::Mat rays = cv::Mat::zeros(height * s, width * s, CV_32F);
  const int instants = exposures(pose_at, t_s);
  for (int k = 0; k < instants; ++k) {
    const double t = t_s + sensor_.exposure_s * ((k + 0.5) / instants - 0.5);
    ScenePose pose = pose_at(t);
    for (int v = 0; v < height; ++v) {
      double row_t = t;
      if (sensor_.readout_s > 0.0) {
        row_t += sensor_.readout_s * (static_cast<double>(v) / (height - 1) - 0.5);
        pose = pose_at(row_t);
      }
      trace_row(pose, row_t, v, 1.0F / static_cast<float>(instants), rays);
    }
  }
  if (sensor_.psf_px > 0.0) cv::GaussianBlur(rays, rays, {}, sensor_.psf_px * s);
  if (s == 1) return rays;
  cv::Mat pixels;
  cv::resize(rays, pixels, {width, height}, 0, 0, cv::INTER_AREA);
  return pixels;
}

cv::Mat Renderer::image(const ScenePoseAt& pose, double t_s, std::uint64_t frame) const {
  const cv::Mat seen = brightness(pose, t_s);
  cv::RNG rng(mix(seed_, static_cast<std::uint64_t>(Stream::Noise), frame));
  const double contrast = sensor_.ice_darker ? -sensor_.contrast_counts : sensor_.contrast_counts;
  const int channels = sensor_.color ? 3 : 1;
  std::vector<cv::Mat> planes(static_cast<std::size_t>(channels));
  for (int k = 0; k < channels; ++k) {
    const double water = sensor_.water_counts * (sensor_.color ? kWaterTint[k] : 1.0);
    const double scale = contrast * (sensor_.color ? kIceTint[k] : 1.0);
    cv::Mat noise(seen.size(), CV_32F);
    rng.fill(noise, cv::RNG::NORMAL, 0.0, sensor_.noise_counts);
    cv::Mat counts = (seen * scale + water).mul(gain_) + pattern_ + noise;
    counts.convertTo(planes[static_cast<std::size_t>(k)], sensor_.bits == 16 ? CV_16U : CV_8U);
  }
  cv::Mat image;
  cv::merge(planes, image);
  if (!dark_.empty()) image.setTo(cv::Scalar::all(0), dark_);
  if (sensor_.jpeg_quality > 0) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, sensor_.jpeg_quality});
    image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  }
  return image;
}

}  // namespace watersky::sim
