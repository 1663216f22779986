// SPDX-License-Identifier: MIT
#pragma once
/// Teaching the classifier from images with hand-made masks.
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>

#include "watersky/base/parameters.hpp"
#include "watersky/base/progress.hpp"
#include "watersky/base/result.hpp"
#include "watersky/vision/ice_model.hpp"

namespace watersky {

/// Values of a mask's pixels.
enum class IceClass : unsigned char { MeltPond = 0, Ice = 1, Water = 2, Unknown = 255 };

struct LabelledImage {
  std::string name;
  cv::Mat image;  ///< as Segmenter takes it; where it has colour it teaches the colour networks
  cv::Mat mask;   ///< CV_8UC1 of the same size, values of IceClass
};

struct TrainingParameters {
  int variants = 16;
  int drawn = 400;
  int samples = 800;
  int passes = 28;
  int folds = 3;
  int seed = 1;
  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.variants,
          ParameterInfo{"variants", "1",
                        "copies of each image, the first as it is, the others altered: scale, cut, "
                        "contrast, shading, noise",
                        2, 1000});
    visit(self.drawn,
          ParameterInfo{"drawn", "1",
                        "scenes of ice that are drawn, not photographed, to learn from as well: "
                        "they show every concentration, floe size and contrast",
                        0, 10000});
    visit(
        self.samples,
        ParameterInfo{"samples", "1",
                      "pixels taken from each altered copy; sixteen times as many from the others",
                      10, 100000});
    visit(self.passes, ParameterInfo{"passes", "1", "passes over all samples", 1, 1000});
    visit(self.folds,
          ParameterInfo{"folds", "1",
                        "groups of images; the fine network learns from what coarse networks say "
                        "of images that they were not trained on",
                        2, 20});
    visit(self.seed, ParameterInfo{"seed", "1", "of everything drawn at random", 0, 2147483647});
  }
};

/// Trains the networks of the kinds that `images` are of, gray and colour; a kind that is not
/// among them is taken from `base`. The same images and parameters give the same model, bit for
/// bit on the same kind of processor and to rounding on others. InvalidInput, naming the image,
/// for a mask of another size or without both ice and something else in all of a kind.
[[nodiscard]] Result<IceModel> train_ice_model(std::span<const LabelledImage> images,
                                               const TrainingParameters& parameters,
                                               const IceModel& base = {},
                                               const Progress& progress = {});

}  // namespace watersky
