// SPDX-License-Identifier: MIT
#include "watersky/vision/ice_training.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "watersky/vision/detail/dense_network.hpp"
#include "watersky/vision/detail/drawn_scene.hpp"
#include "watersky/vision/detail/fine_detail.hpp"
#include "watersky/vision/detail/ice_features.hpp"
#include "watersky/vision/detail/ice_inference.hpp"
#include "watersky/vision/detail/image.hpp"
#include "watersky/vision/detail/polarity_cues.hpp"

namespace watersky {
namespace {

using detail::DenseNetwork;
using detail::IceScene;
using detail::kClasses;
using detail::LevelStatistics;
using detail::Planes;
using Matrix = Eigen::MatrixXf;
using Vector = Eigen::VectorXf;

const std::vector<int> kCoarseLayers{40, 12};
const std::vector<int> kFineLayers{16, 12};

/// Copies that are not altered weigh more: the altered and the drawn ones are there to widen what
/// is known, not to hide what real images look like.
constexpr double kUnalteredWeight = 16.0;
constexpr double kDrawnWeight = 0.06;
/// In what the cues of polarity learn from, where an image weighs as kUnalteredWeight says.
constexpr double kDrawnPolarityWeight = 0.3;
/// Of drawn scenes that show one class alone, which few photographs do.
constexpr double kOneClassWeight = 0.5;
constexpr int kDrawnEdge_px = 320;

/// Part of each class at every pixel; all zero where nobody knows.
using ClassPlanes = std::array<cv::Mat, kClasses>;

// ---- altered copies ------------------------------------------------------------------------

struct Copy {
  IceScene scene;
  LevelStatistics levels;
  double weight = 1.0;
  detail::PolarityExample polarity;
  cv::Mat gray;      ///< at full size, of images in gray
  ClassPlanes full;  ///< the same
  ClassPlanes half, quarter;
};

ClassPlanes class_planes(const cv::Mat& mask) {
  ClassPlanes planes;
  for (std::size_t c = 0; c < kClasses; ++c)
    cv::Mat(mask == static_cast<int>(c)).convertTo(planes[c], CV_32F, 1.0 / 255.0);
  return planes;
}

/// Whether ice is the brighter class; where only one class is there it is called so.
bool ice_is_brighter(const cv::Mat& level, const ClassPlanes& classes) {
  const cv::Mat& ice = classes[detail::kIce];
  const cv::Mat other = classes[detail::kPond] + classes[detail::kWater];
  const double ice_area = cv::sum(ice)[0], other_area = cv::sum(other)[0];
  if (ice_area < 1.0 || other_area < 1.0) return true;
  return cv::sum(level.mul(ice))[0] / ice_area > cv::sum(level.mul(other))[0] / other_area;
}

/// Another scale and a part of the image.
void zoom_and_cut(cv::Mat& image, ClassPlanes& classes, cv::RNG& random) {
  const double zoom = std::exp(random.uniform(std::log(0.6), std::log(2.0)));
  const auto resized = [&](cv::Mat& plane) {
    cv::resize(plane, plane, {}, zoom, zoom, zoom < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  };
  resized(image);
  for (auto& plane : classes) resized(plane);
  const int most = std::min({image.cols, image.rows, 480});
  const int edge = std::min(most, random.uniform(std::min(160, most), most + 1)) / 4 * 4;
  const cv::Rect part(random.uniform(0, image.cols - edge + 1),
                      random.uniform(0, image.rows - edge + 1), edge, edge);
  image = image(part).clone();
  for (auto& plane : classes) plane = plane(part).clone();
}

/// Smooth shading over the image, in the image's levels, alike in all channels.
cv::Mat shading(cv::Size size, double sigma, cv::RNG& random) {
  const double a = random.gaussian(sigma), b = random.gaussian(sigma), c = random.gaussian(sigma);
  cv::Mat plane(size, CV_32F);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double u = 2.0 * x / size.width - 1.0, v = 2.0 * y / size.height - 1.0;
      plane.at<float>(y, x) = static_cast<float>(a * u + b * v + c * (u * u + v * v));
    }
  return plane;
}

void add_noise(cv::Mat& image, double sigma, cv::RNG& random) {
  cv::Mat noise(image.size(), image.type());
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  image += noise;
}

/// Another camera's gamma, shading, contrast and noise, on a gray image in levels of 0 to 255.
void alter_gray(cv::Mat& image, cv::RNG& random) {
  cv::max(image / 255.0, 0.0, image);
  cv::pow(image, std::exp(random.uniform(-0.5, 0.5)), image);
  image = image * 255.0 + shading(image.size(), 8.0, random);
  double noise = random.uniform(0.0, 6.0);
  if (random.uniform(0, 4) == 0) {  // fog
    image = (image - 128.0) * std::exp(random.uniform(std::log(0.03), 0.0));
    noise = 2.0;
  }
  add_noise(image, noise, random);
}

/// Another exposure, white balance and noise. Colour is never inverted: white is white.
void alter_colour(cv::Mat& image, cv::RNG& random) {
  const double exposure = std::exp(random.uniform(-0.35, 0.25));
  cv::Scalar gain;
  for (int c = 0; c < 3; ++c) gain[c] = exposure * std::exp(random.gaussian(0.06));
  cv::multiply(image, gain, image);
  cv::Mat shade = shading(image.size(), 5.0, random);
  cv::merge(std::vector<cv::Mat>{shade, shade, shade}, shade);
  image += shade;
  add_noise(image, random.uniform(0.0, 5.0), random);
  cv::min(image, 255.0, image);
  cv::max(image, 0.0, image);
}

/// Scene, levels and classes of an image as it will be learned from; false where it shows a single
/// level. `image` is CV_32F, in colour with full scale 1.
bool prepare(const cv::Mat& image, const ClassPlanes& classes, bool in_colour, bool ice_brighter,
             Copy& copy) {
  copy.scene = detail::ice_scene(image, {}, in_colour);
  for (std::size_t c = 0; c < kClasses; ++c) {
    cv::Mat plane = classes[c];
    cv::copyMakeBorder(plane, plane, 0, 2 * copy.scene.half.rows - plane.rows, 0,
                       2 * copy.scene.half.cols - plane.cols, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::resize(plane, copy.half[c], copy.scene.half.size(), 0, 0, cv::INTER_AREA);
    cv::resize(plane, copy.quarter[c], copy.scene.quarter.size(), 0, 0, cv::INTER_AREA);
  }
  if (!detail::level_statistics(copy.scene, copy.levels)) return false;
  if (in_colour) return true;
  copy.polarity = {detail::polarity_cues(copy.scene.quarter, {}, copy.levels), ice_brighter,
                   copy.weight};
  copy.levels = copy.levels.with_ice(ice_brighter);
  copy.gray = image;
  copy.full = classes;
  return true;
}

/// The first copies are the image as it is, the others altered.
bool make_copy(const LabelledImage& labelled, int variant, bool in_colour, cv::RNG& random,
               Copy& copy) {
  cv::Mat image;
  (in_colour ? labelled.image : detail::luminance(labelled.image)).convertTo(image, CV_32F);
  if (in_colour) {
    if (labelled.image.depth() == CV_16U) image *= 255.0 / 65535.0;
  } else {
    // Any unit will do, as long as noise and shading are added in the same one.
    double lowest = 0.0, highest = 0.0;
    cv::minMaxLoc(image, &lowest, &highest);
    if (!(highest > lowest)) return false;
    image = (image - lowest) * (255.0 / (highest - lowest));
  }
  ClassPlanes classes = class_planes(labelled.mask);
  const bool ice_brighter = in_colour || ice_is_brighter(image, classes);
  if (variant == 0) {
    copy.weight = kUnalteredWeight;
  } else {
    zoom_and_cut(image, classes, random);
    if (in_colour)
      alter_colour(image, random);
    else
      alter_gray(image, random);
  }
  if (in_colour) image *= 1.0 / 255.0;
  return prepare(image, classes, in_colour, ice_brighter, copy);
}

/// A drawn scene as a camera sees it.
bool make_drawn_copy(bool in_colour, cv::RNG& random, Copy& copy) {
  detail::DrawnScene drawn = detail::draw_scene({kDrawnEdge_px, kDrawnEdge_px}, in_colour, random);
  if (in_colour) {
    alter_colour(drawn.image, random);
    drawn.image *= 1.0 / 255.0;
  } else {
    alter_gray(drawn.image, random);
  }
  double lowest = 0.0, highest = 0.0;
  cv::minMaxLoc(drawn.mask, &lowest, &highest);
  copy.weight = lowest == highest ? kOneClassWeight : kDrawnWeight;
  const bool whole = prepare(drawn.image, class_planes(drawn.mask), in_colour, true, copy);
  copy.polarity.weight = drawn.floes_have_shape ? kDrawnPolarityWeight : 0.0;
  return whole;
}

// ---- samples -------------------------------------------------------------------------------

/// Columns are samples.
struct Samples {
  int inputs = 0;
  std::vector<float> x, classes;

  /// Draws pixels of `planes`, and of `coarse` at half their size between its pixels.
  void draw(const Planes& planes, const Planes& coarse, const ClassPlanes& truth, int count,
            cv::RNG& random) {
    inputs = static_cast<int>(planes.size() + coarse.size());
    const cv::Size size = planes[0].size();
    for (int taken = 0, tried = 0; taken < count && tried < 10 * count; ++tried) {
      const int x0 = random.uniform(0, size.width), y0 = random.uniform(0, size.height);
      float known = 0.0F;
      for (const auto& plane : truth) known += plane.at<float>(y0, x0);
      if (known < 0.99F) continue;
      ++taken;
      for (const auto& plane : planes) x.push_back(plane.at<float>(y0, x0));
      for (const auto& plane : coarse) x.push_back(between(plane, x0, y0));
      for (const auto& plane : truth) classes.push_back(plane.at<float>(y0, x0) / known);
    }
  }

 private:
  /// As cv::resize by two interpolates.
  static float between(const cv::Mat& plane, int x, int y) {
    const float u = (static_cast<float>(x) - 0.5F) / 2.0F,
                v = (static_cast<float>(y) - 0.5F) / 2.0F;
    const int i = cvFloor(u), j = cvFloor(v);
    const float a = u - static_cast<float>(i), b = v - static_cast<float>(j);
    const auto at = [&](int row, int column) {
      return plane.at<float>(std::clamp(row, 0, plane.rows - 1),
                             std::clamp(column, 0, plane.cols - 1));
    };
    return (1.0F - b) * ((1.0F - a) * at(j, i) + a * at(j, i + 1)) +
           b * ((1.0F - a) * at(j + 1, i) + a * at(j + 1, i + 1));
  }
};

// ---- the network ---------------------------------------------------------------------------

/// One layer's numbers and Adam's memory of their gradients (Kingma and Ba 2015, with decoupled
/// weight decay as Loshchilov and Hutter 2019).
struct Layer {
  Matrix w, w_mean, w_square;
  Vector b, b_mean, b_square;

  Layer(int inputs, int outputs, cv::RNG& random)
      : w(outputs, inputs),
        w_mean(Matrix::Zero(outputs, inputs)),
        w_square(w_mean),
        b(Vector::Zero(outputs)),
        b_mean(b),
        b_square(b) {
    // He et al. 2015
    for (Eigen::Index i = 0; i < w.size(); ++i)
      w.data()[i] = static_cast<float>(random.gaussian(std::sqrt(2.0 / inputs)));
  }

  template <class Value>
  static void step(Value& value, Value& mean, Value& square, const Value& gradient, float rate,
                   double decay1, double decay2) {
    mean = 0.9F * mean + 0.1F * gradient;
    square = 0.999F * square + 0.001F * gradient.cwiseAbs2();
    value.array() -= rate * (mean.array() / static_cast<float>(1.0 - decay1)) /
                     ((square.array() / static_cast<float>(1.0 - decay2)).sqrt() + 1e-8F);
  }
};

constexpr int kBatch = 512;
constexpr float kHighestRate = 5e-3F;
constexpr float kWeightDecay = 0.1F;

/// Warm-up over the first tenth, then half a cosine down to nothing.
float learning_rate(double part) {
  if (part < 0.1) return kHighestRate * static_cast<float>(part / 0.1);
  return kHighestRate *
         static_cast<float>(0.5 * (1.0 + std::cos(std::numbers::pi * (part - 0.1) / 0.9)));
}

/// Minimises the cross entropy of the classes.
DenseNetwork fit(Samples& samples, const std::vector<int>& hidden, int passes, int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed) * 7919U + 13U);
  const Eigen::Index inputs = samples.inputs;
  const auto count = static_cast<Eigen::Index>(samples.classes.size() / kClasses);
  Eigen::Map<Matrix> x(samples.x.data(), inputs, count);
  const Eigen::Map<const Matrix> truth(samples.classes.data(), kClasses, count);

  DenseNetwork network;
  for (Eigen::Index i = 0; i < inputs; ++i) {
    const double mean = x.row(i).cast<double>().mean();
    const double sigma = std::sqrt((x.row(i).cast<double>().array() - mean).square().mean()) + 1e-4;
    network.input_mean.push_back(static_cast<float>(mean));
    network.input_scale.push_back(static_cast<float>(1.0 / sigma));
    x.row(i) = ((x.row(i).array() - static_cast<float>(mean)) * static_cast<float>(1.0 / sigma))
                   .min(DenseNetwork::kClamp)
                   .max(-DenseNetwork::kClamp);
  }

  std::vector<int> widths{static_cast<int>(inputs)};
  widths.insert(widths.end(), hidden.begin(), hidden.end());
  widths.push_back(static_cast<int>(kClasses));
  std::vector<Layer> layers;
  for (std::size_t l = 0; l + 1 < widths.size(); ++l)
    layers.emplace_back(widths[l], widths[l + 1], random);

  std::vector<Matrix> activation(layers.size() + 1);
  activation[0].resize(inputs, kBatch);
  Matrix batch_truth(kClasses, kBatch);
  const auto steps = static_cast<int>(passes * count / kBatch);
  double decay1 = 1.0, decay2 = 1.0;
  for (int step = 0; step < steps; ++step) {
    for (int k = 0; k < kBatch; ++k) {
      const int j = random.uniform(0, static_cast<int>(count));
      activation[0].col(k) = x.col(j);
      batch_truth.col(k) = truth.col(j);
    }
    for (std::size_t l = 0; l < layers.size(); ++l) {
      activation[l + 1].noalias() = layers[l].w * activation[l];
      activation[l + 1].colwise() += layers[l].b;
      if (l + 1 < layers.size()) activation[l + 1] = activation[l + 1].cwiseMax(0.0F);
    }
    // The gradient of the cross entropy by the scores: softmax less truth.
    Matrix gradient = activation.back();
    for (int k = 0; k < kBatch; ++k) {
      gradient.col(k) = (gradient.col(k).array() - gradient.col(k).maxCoeff()).exp();
      gradient.col(k) /= gradient.col(k).sum();
    }
    gradient = (gradient - batch_truth) / static_cast<float>(kBatch);
    const float rate = learning_rate(static_cast<double>(step) / steps);
    decay1 *= 0.9;
    decay2 *= 0.999;
    for (std::size_t l = layers.size(); l-- > 0;) {
      const Matrix by_weights = gradient * activation[l].transpose();
      const Vector by_biases = gradient.rowwise().sum();
      if (l > 0) {
        Matrix below = layers[l].w.transpose() * gradient;
        gradient = (activation[l].array() > 0.0F).select(below, 0.0F);
      }
      layers[l].w *= 1.0F - rate * kWeightDecay;
      Layer::step(layers[l].w, layers[l].w_mean, layers[l].w_square, by_weights, rate, decay1,
                  decay2);
      Layer::step(layers[l].b, layers[l].b_mean, layers[l].b_square, by_biases, rate, decay1,
                  decay2);
    }
  }
  for (const auto& layer : layers) {
    detail::DenseLayer out{
        static_cast<int>(layer.w.cols()), static_cast<int>(layer.w.rows()), {}, {}};
    for (Eigen::Index o = 0; o < layer.w.rows(); ++o)
      for (Eigen::Index i = 0; i < layer.w.cols(); ++i) out.weights.push_back(layer.w(o, i));
    out.biases.assign(layer.b.begin(), layer.b.end());
    network.layers.push_back(std::move(out));
  }
  return network;
}

// ---- both networks of a kind ---------------------------------------------------------------

using Copies = std::vector<Copy>;

DenseNetwork fit_coarse(const std::vector<const Copies*>& images,
                        const TrainingParameters& parameters, int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed) + 1U);
  Samples samples;
  for (const auto* copies : images)
    for (const auto& copy : *copies)
      samples.draw(detail::coarse_features(copy.scene, copy.levels), {}, copy.quarter,
                   cvRound(copy.weight * parameters.samples), random);
  return fit(samples, kCoarseLayers, parameters.passes, seed);
}

float fit_detail(const std::vector<Copies>& images, const IceNetworks& networks,
                 const TrainingParameters& parameters) {
  cv::RNG random(static_cast<std::uint64_t>(parameters.seed) + 4U);
  std::vector<detail::DetailSample> samples;
  std::vector<float> p, difference;
  for (const auto& copies : images)
    for (const auto& copy : copies) {
      const cv::Mat p_half =
          detail::probability(detail::ice_scores(networks, copy.scene, copy.levels));
      const detail::FineDetail fine(copy.gray, copy.scene, copy.levels);
      constexpr int kRows = 16;
      const int count = cvCeil(copy.weight * parameters.samples / kRows);
      for (int k = 0; k < kRows; ++k) {
        const int y = random.uniform(0, copy.gray.rows);
        fine.row(p_half, y, p, difference);
        for (int i = 0; i < count; ++i) {
          const int x = random.uniform(0, copy.gray.cols);
          float known = 0.0F;
          for (const auto& plane : copy.full) known += plane.at<float>(y, x);
          const float ice = copy.full[detail::kIce].at<float>(y, x);
          const auto at = static_cast<std::size_t>(x);
          if (known > 0.99F) samples.push_back({p[at], difference[at], ice});
        }
      }
    }
  return detail::fit_detail_weight(samples);
}

IceNetworks train_kind(const std::vector<Copies>& images, bool in_colour,
                       const TrainingParameters& parameters, const Progress& progress) {
  const auto folds = std::min(static_cast<std::size_t>(parameters.folds), images.size());
  std::size_t done = 0;
  const auto tell = [&] { report(progress, "training", done++, folds + 2); };
  std::vector<const Copies*> all;
  for (const auto& copies : images) all.push_back(&copies);
  tell();
  IceNetworks networks;
  networks.coarse =
      std::make_shared<const DenseNetwork>(fit_coarse(all, parameters, parameters.seed));

  cv::RNG random(static_cast<std::uint64_t>(parameters.seed) + 2U);
  Samples samples;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    tell();
    std::vector<const Copies*> others;
    for (std::size_t i = 0; i < images.size(); ++i)
      if (folds == 1 || i % folds != fold) others.push_back(&images[i]);
    const DenseNetwork coarse =
        fit_coarse(others, parameters, parameters.seed + 10 + static_cast<int>(fold));
    for (std::size_t i = fold; i < images.size(); i += folds)
      for (const auto& copy : images[i]) {
        const cv::Mat rough = detail::probability(
            detail::evaluate(coarse, detail::coarse_features(copy.scene, copy.levels)));
        samples.draw(
            detail::fine_features(copy.scene, copy.levels),
            detail::context_features(copy.scene, copy.levels, rough, detail::log_odds(rough)),
            copy.half, cvRound(copy.weight * parameters.samples), random);
      }
  }
  tell();
  networks.fine = std::make_shared<const DenseNetwork>(
      fit(samples, kFineLayers, parameters.passes, parameters.seed + 77));
  if (!in_colour) {
    std::vector<detail::PolarityExample> examples;
    for (const auto& copies : images)
      for (const auto& copy : copies) examples.push_back(copy.polarity);
    const auto weights = detail::fit_polarity(examples);
    networks.polarity.assign(weights.begin(), weights.end());
    networks.detail = fit_detail(images, networks, parameters);
  }
  return networks;
}

Status check(const LabelledImage& labelled) {
  const cv::Mat& image = labelled.image;
  const cv::Mat& mask = labelled.mask;
  if (const Status checked = detail::check_image(image, {}); !checked)
    return checked.error().at(labelled.name);
  if (mask.type() != CV_8UC1)
    return Error{ErrorCode::InvalidInput, labelled.name + ": mask is of type " +
                                              cv::typeToString(mask.type()) +
                                              "; give 8 bit with one channel"};
  if (mask.size() != image.size())
    return Error{ErrorCode::InvalidInput, labelled.name + ": mask is " + std::to_string(mask.cols) +
                                              "x" + std::to_string(mask.rows) +
                                              " for an image of " + std::to_string(image.cols) +
                                              "x" + std::to_string(image.rows)};
  if (std::min(image.rows, image.cols) < 32)
    return Error{ErrorCode::InvalidInput,
                 labelled.name + ": image is smaller than 32 px, too small to learn from"};
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const auto value = mask.at<unsigned char>(y, x);
      if (value > static_cast<unsigned char>(IceClass::Water) &&
          value != static_cast<unsigned char>(IceClass::Unknown))
        return Error{ErrorCode::InvalidInput,
                     labelled.name + ": mask has value " + std::to_string(value) + " at column " +
                         std::to_string(x) + ", row " + std::to_string(y) +
                         "; values are 0 melt pond, 1 ice, 2 water, 255 unknown"};
    }
  return {};
}

}  // namespace

Result<IceModel> train_ice_model(std::span<const LabelledImage> images,
                                 const TrainingParameters& parameters, const IceModel& base,
                                 const Progress& progress) {
  WATERSKY_CHECK(validate(parameters));
  for (const auto& labelled : images) WATERSKY_CHECK(check(labelled));
  IceModel model = base;
  bool any = false;
  for (const bool in_colour : {false, true}) {
    std::vector<Copies> kind;
    double ice = 0.0, other = 0.0;
    for (const auto& labelled : images) {
      if (detail::colourful(labelled.image) != in_colour) continue;
      report(progress, "preparing", kind.size(), images.size());
      // Each image has its own dice, so that adding one does not change the others' copies.
      cv::RNG random(static_cast<std::uint64_t>(parameters.seed) * 1000003U + kind.size() + 5U);
      Copies copies;
      for (int variant = 0; variant < parameters.variants; ++variant) {
        Copy copy;
        if (make_copy(labelled, variant, in_colour, random, copy))
          copies.push_back(std::move(copy));
      }
      if (copies.empty())
        return Error{ErrorCode::InvalidInput,
                     labelled.name + ": image has one level everywhere; leave it out"};
      ice += cv::sum(copies[0].half[detail::kIce])[0];
      other +=
          cv::sum(copies[0].half[detail::kPond])[0] + cv::sum(copies[0].half[detail::kWater])[0];
      kind.push_back(std::move(copies));
    }
    if (kind.empty()) continue;
    any = true;
    const auto labelled_count = kind.size();
    if (kind.size() < 2 || ice == 0.0 || other == 0.0)
      return Error{ErrorCode::InvalidInput,
                   std::string(in_colour ? "colour" : "gray") +
                       " images: at least two are needed, with ice and with water or melt pond "
                       "in their masks"};
    cv::RNG random(static_cast<std::uint64_t>(parameters.seed) * 1000003U + 3U);
    for (int i = 0; i < parameters.drawn; ++i) {
      report(progress, "drawing", static_cast<std::size_t>(i),
             static_cast<std::size_t>(parameters.drawn));
      Copies copies(1);
      if (make_drawn_copy(in_colour, random, copies[0])) kind.push_back(std::move(copies));
    }
    (in_colour ? model.colour : model.gray) = train_kind(kind, in_colour, parameters, progress);
    (in_colour ? model.colour_origin : model.gray_origin) =
        std::to_string(labelled_count) + " images, " + std::to_string(parameters.variants) +
        " variants, " + std::to_string(parameters.drawn) + " drawn, " +
        std::to_string(parameters.samples) + " samples, " + std::to_string(parameters.passes) +
        " passes, " + std::to_string(parameters.folds) + " folds, seed " +
        std::to_string(parameters.seed);
  }
  if (!any) return Error{ErrorCode::InvalidInput, "no images to learn from"};
  return model;
}

}  // namespace watersky
