// SPDX-License-Identifier: MIT
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/vision/ice_training.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky::study {

namespace fs = std::filesystem;

namespace {

/// A method on the image smoothed as the known figures have it.
class Blurred final : public Segmenter {
 public:
  explicit Blurred(std::unique_ptr<Segmenter> inner) : inner_(std::move(inner)) {}
  void observe(const cv::Mat& image, const cv::Mat& valid) override {
    inner_->observe(blurred(image), valid);
  }
  [[nodiscard]] Result<cv::Mat> segment(const cv::Mat& image, const cv::Mat& valid) const override {
    return inner_->segment(blurred(image), valid);
  }

 private:
  static cv::Mat blurred(const cv::Mat& image) {
    cv::Mat smooth;
    cv::blur(image, smooth, cv::Size(5, 5));
    return smooth;
  }
  std::unique_ptr<Segmenter> inner_;
};

enum class Told { Nothing, Polarity, ColdIsIce };

/// A method that learns from no image.
Contender untrained(const std::string& name, const std::string& what, SegmentationMethod method,
                    Told told, const SegmentationParameters& parameters = {}) {
  return {name, what, [=](const auto&, const LabelledImage& judged, PondIs) {
            const IcePolarity ice = told == Told::Polarity    ? judged.truth
                                    : told == Told::ColdIsIce ? IcePolarity::Darker
                                                              : IcePolarity::Auto;
            return make_segmenter(method, parameters, ice);
          }};
}

/// The model that the images teach, with the default parameters. A set of images is learned from
/// once, however many contenders, fogs and tables ask for it.
Result<std::shared_ptr<const IceModel>> learned_from(
    const std::vector<const LabelledImage*>& training) {
  static std::map<std::string, std::shared_ptr<const IceModel>> known;
  std::string key;
  std::vector<watersky::LabelledImage> images;
  for (const LabelledImage* image : training) {
    key += image->name + '\n';
    images.push_back({image->name, image->image, image->classes});
  }
  auto& model = known[key];
  if (!model) {
    WATERSKY_TRY(IceModel learned, train_ice_model(images, TrainingParameters{}));
    model = std::make_shared<const IceModel>(std::move(learned));
  }
  return model;
}

/// Which of the training images a contender may learn from.
using MayLearnFrom = bool (*)(const LabelledImage&);

Contender trained(
    const std::string& name, const std::string& what, SegmentationMethod method,
    MayLearnFrom may_learn_from = [](const LabelledImage&) { return true; }) {
  return {name, what,
          [=](const auto& training, const LabelledImage&,
              PondIs pond) -> Result<std::unique_ptr<Segmenter>> {
            std::vector<const LabelledImage*> taken;
            for (const LabelledImage* image : training)
              if (may_learn_from(*image)) taken.push_back(image);
            SegmentationParameters parameters;
            parameters.learned.ponds_are_ice = pond == PondIs::Ice;
            WATERSKY_TRY(parameters.model, learned_from(taken));
            return make_segmenter(method, parameters);
          }};
}

}  // namespace

cv::Mat LabelledImage::ice(PondIs pond) const {
  return ice_in_mask(classes, MaskValues::Classes, pond).value();
}

Result<std::vector<LabelledImage>> read_labelled(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder / "images", ignored))
    return Error{ErrorCode::NotFound, folder.string() + ": holds no images/ with masks/ beside it"};
  WATERSKY_TRY(const auto files, list_images(folder / "images"));
  std::vector<LabelledImage> images;
  for (const fs::path& file : files) {
    LabelledImage image;
    image.name = file.stem().string();
    WATERSKY_TRY(image.image, image_loader(file)(ImageRequest{.color = false}));
    WATERSKY_TRY(const fs::path mask, find_mask(file, {folder / "masks"}, false));
    WATERSKY_TRY(image.classes, read_mask(mask, {image.image.cols, image.image.rows}));
    if (auto checked = ice_in_mask(image.classes, MaskValues::Classes, PondIs::Water); !checked)
      return checked.error().at(mask.string());
    // Ice against the sea; ponds are on the ice and brighter than both when thermal.
    image.truth =
        cv::mean(image.image, image.classes == 1)[0] > cv::mean(image.image, image.classes == 2)[0]
            ? IcePolarity::Brighter
            : IcePolarity::Darker;
    images.push_back(std::move(image));
  }
  if (images.empty())
    return Error{ErrorCode::NotFound, (folder / "images").string() + ": holds no image"};
  return images;
}

std::vector<Contender> contenders() {
  using enum SegmentationMethod;
  SegmentationParameters closing;
  closing.evidence.close_px = 5;
  std::vector<Contender> all{
      trained("learned", "learned", Learned),
      // The labelled images are nearly all of one polarity; what it is trained on is only of that.
      trained("learned_one_polarity", "learned, one polarity", Learned,
              [](const LabelledImage& image) { return image.truth == IcePolarity::Darker; }),
      trained("learned_fast", "learned, fast", LearnedFast),
      trained("learned_best", "learned, best", LearnedBest),
      untrained("otsu_told", "Otsu, told", Otsu, Told::Polarity),
      untrained("otsu_cold_is_ice", "Otsu, cold is ice", Otsu, Told::ColdIsIce),
      untrained("otsu_auto", "Otsu", Otsu, Told::Nothing),
      untrained("otsu_auto_close5", "Otsu, closed 5 px", Otsu, Told::Nothing, closing),
      untrained("local_otsu_auto", "local Otsu", LocalOtsu, Told::Nothing),
      untrained("edges_auto", "edges", Edges, Told::Nothing),
      untrained("watershed_auto", "watershed", Watershed, Told::Nothing)};
  all.insert(
      all.begin() + 5,
      {"otsu_told_blur5", "Otsu, told, 5x5 mean",
       [](const auto&, const LabelledImage& judged, PondIs) -> Result<std::unique_ptr<Segmenter>> {
         WATERSKY_TRY(auto otsu, make_segmenter(Otsu, {}, judged.truth));
         return std::unique_ptr<Segmenter>(std::make_unique<Blurred>(std::move(otsu)));
       }});
  return all;
}

}  // namespace watersky::study
