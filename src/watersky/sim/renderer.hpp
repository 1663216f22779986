// SPDX-License-Identifier: MIT
#pragma once
/// What a camera over a virtual sea records.
///
/// Each pixel is `supersampling`² rays in a turned grid, as many again for each instant that a
/// moving camera's exposure is divided into. A ray meets the curved sea surface, finds ice or water
/// there without any raster in between, and carries their brightness through the fog. The lens's
/// blur acts on the rays, then the pixel averages, then come vignetting, fixed pattern, noise,
/// quantisation and compression.
#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/sim/lens.hpp"
#include "watersky/sim/sea.hpp"

namespace watersky::sim {

/// Brightness is relative: 0 is water on average, 1 is ice on average.
struct SensorParameters {
  int bits = 8;
  bool color = false;
  bool ice_darker = false;
  double water_counts = 100.0;
  double contrast_counts = 24.0;
  double noise_counts = 6.0;
  double pattern_counts = 0.8;
  double vignetting = 0.02;
  double psf_px = 0.6;
  double ice_texture = 0.12;
  double water_texture = 0.06;
  double floe_variation = 0.12;
  double fog_per_m = 0.0;
  double fog_brightness = 0.3;
  double sky_brightness = 0.5;
  double exposure_s = 0.004;
  double readout_s = 0.0;
  int supersampling = 2;
  double texture_cell_m = 0.12;
  int jpeg_quality = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.bits, ParameterInfo{"bits", "1", "8 or 16 bit a channel", 8, 16});
    visit(self.color, ParameterInfo{"color", "1", "three channels, as a visible camera"});
    visit(self.ice_darker, ParameterInfo{"ice_darker", "1",
                                         "ice darker than water, as cold ice in a thermal image"});
    visit(self.water_counts, ParameterInfo{"water_counts", "counts", "level of water", 0, 65535});
    visit(self.contrast_counts,
          ParameterInfo{"contrast_counts", "counts", "between ice and water on average", 0, 65535});
    visit(self.noise_counts, ParameterInfo{"noise_counts", "counts",
                                           "one sigma of the noise, anew in each frame", 0, 65535});
    visit(
        self.pattern_counts,
        ParameterInfo{"pattern_counts", "counts",
                      "one sigma of the fixed pattern, half of its variance in columns", 0, 65535});
    visit(self.vignetting,
          ParameterInfo{"vignetting", "1", "share of the level lost in the corners", 0, 0.95});
    visit(self.psf_px, ParameterInfo{"psf_px", "px", "one sigma of the lens's blur", 0, 50});
    visit(self.ice_texture,
          ParameterInfo{"ice_texture", "1",
                        "one sigma of brightness within ice, relative to the contrast", 0, 2});
    visit(self.water_texture,
          ParameterInfo{"water_texture", "1",
                        "one sigma of brightness within water, relative to the contrast", 0, 2});
    visit(
        self.floe_variation,
        ParameterInfo{"floe_variation", "1",
                      "one sigma of brightness from floe to floe, relative to the contrast", 0, 2});
    visit(self.fog_per_m,
          ParameterInfo{"fog_per_m", "1/m",
                        "extinction: contrast falls as exp(-this times the slant range)", 0, 10});
    visit(self.fog_brightness,
          ParameterInfo{"fog_brightness", "1", "brightness of dense fog, 0 as water and 1 as ice",
                        -10, 10});
    visit(self.sky_brightness,
          ParameterInfo{"sky_brightness", "1", "brightness of the sky, 0 as water and 1 as ice",
                        -10, 10});
    visit(self.exposure_s, ParameterInfo{"exposure_s", "s", "exposure time", 0, 10});
    visit(self.readout_s,
          ParameterInfo{"readout_s", "s",
                        "rolling shutter, first row to last; 0 exposes all rows at once", 0, 10});
    visit(self.supersampling,
          ParameterInfo{"supersampling", "1", "rays along a pixel's edge", 1, 8});
    visit(self.texture_cell_m,
          ParameterInfo{"texture_cell_m", "m",
                        "size of the texture's grain; good for a million of them around the "
                        "scene's anchor",
                        0.001, 10});
    visit(self.jpeg_quality,
          ParameterInfo{"jpeg_quality", "1",
                        "images are compressed with this quality, as a video link does; 0: not", 0,
                        100});
  }
};

/// A camera in the scene's frame: north, east, down at the anchor.
struct ScenePose {
  Eigen::Matrix3d scene_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};

/// The camera's pose by seconds of the flight.
using ScenePoseAt = std::function<ScenePose(double t_s)>;

/// Const and thread-safe once made.
class Renderer {
 public:
  /// Usage for a parameter out of its range, a bit depth that is neither 8 nor 16, or 16 bit
  /// compressed as JPEG. The ice moves over the ground with `drift_north_east_m_s`, and is where
  /// `sea` has it at second 0.
  [[nodiscard]] static Result<Renderer> make(const Sea& sea, const LensParameters& lens,
                                             const SensorParameters& sensor, std::uint64_t seed,
                                             const Eigen::Vector2d& drift_north_east_m_s);

  /// The relative brightness that reaches each pixel (CV_32F), before vignetting and noise. Time
  /// is that of the middle row's middle of exposure. The blur sees the image mirrored at its
  /// border. Within a pixel, places on the sea are linear in the pixel's coordinates: with θ the
  /// ray's angle from straight down, that is off by at most tan θ / (5 focal_px) pixels.
  [[nodiscard]] cv::Mat brightness(const ScenePoseAt& pose, double t_s) const;

  /// The picture: CV_8U or CV_16U, one or three (BGR) channels. `frame` seeds its noise.
  [[nodiscard]] cv::Mat image(const ScenePoseAt& pose, double t_s, std::uint64_t frame) const;

 private:
  struct Ray {
    float x, y, z;
  };
  Renderer(const Sea& sea, const LensParameters& lens, const SensorParameters& sensor,
           std::uint64_t seed, const Eigen::Vector2d& drift);
  void trace_row(const ScenePose& pose, double t_s, int row, float weight, cv::Mat& rays) const;
  [[nodiscard]] int exposures(const ScenePoseAt& pose, double t_s) const;
  [[nodiscard]] float texture(double north, double east, unsigned offset) const;

  Sea sea_;
  LensParameters lens_;
  SensorParameters sensor_;
  std::uint64_t seed_;
  Eigen::Vector2d drift_;
  double half_curvature_north_, half_curvature_east_;
  double fine_cells_per_m_, coarse_cells_per_m_;  ///< of the texture
  std::vector<Ray> directions_;   ///< unit, with a border of one pixel; NaN where the lens is dark
  std::vector<float> ice_level_;  ///< of each object, 1 on average over the ice's area
  cv::Mat texture_;               ///< CV_32F, periodic, zero mean, unit variance
  cv::Mat gain_, pattern_;        ///< CV_32F
  cv::Mat dark_;  ///< CV_8U, 255 where no light falls; empty when it falls everywhere
};

}  // namespace watersky::sim
