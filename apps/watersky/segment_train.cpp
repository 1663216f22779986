// SPDX-License-Identifier: MIT
/// `watersky segment train IMAGES MASKS -o MODEL`: the classifier learns from masks.
#include <opencv2/core.hpp>

#include "cli.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/mask_file.hpp"
#include "watersky/vision/ice_training.hpp"

namespace watersky::cli {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::string images, masks, out, values, base = "shipped";
  bool overwrite = false;
  TrainingParameters parameters;
};

/// Image and mask as training wants them, of classes whatever the mask's values mean.
Result<LabelledImage> read_labelled(const fs::path& file, const Options& o) {
  LabelledImage labelled;
  labelled.name = file.string();
  WATERSKY_TRY(labelled.image, image_loader(file)(ImageRequest{}));
  WATERSKY_TRY(const fs::path mask, find_mask(file, {o.masks}, false));
  WATERSKY_TRY(labelled.mask, read_mask(mask, {labelled.image.cols, labelled.image.rows}));
  if (o.values == "binary") {
    const auto ice = ice_in_mask(labelled.mask, MaskValues::Binary, PondIs::Water);
    if (!ice) return ice.error().at(mask.string());
    const cv::Mat is_ice = *ice != 0;
    labelled.mask.setTo(static_cast<int>(IceClass::Water));
    labelled.mask.setTo(static_cast<int>(IceClass::Ice), is_ice);
  }
  return labelled;
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_CHECK(validate(o.parameters));
  std::error_code ignored;
  if (fs::exists(o.out, ignored) && !o.overwrite)
    return Error{ErrorCode::Usage, o.out + ": is there already; give --overwrite to replace it"};
  IceModel base;
  if (o.base == "shipped") {
    base = IceModel::shipped();
  } else if (o.base != "none") {
    WATERSKY_TRY(base, read_ice_model(o.base));
  }
  WATERSKY_TRY(const auto files, list_inputs({o.images}));
  const Progress progress = progress_bar(common);
  std::vector<LabelledImage> images;
  for (const fs::path& file : files) {
    report(progress, "reading", images.size(), files.size());
    auto labelled = read_labelled(file, o);
    // A folder may hold more images than somebody had time to label.
    if (!labelled && labelled.error().code == ErrorCode::NotFound) {
      say_more(common, "left out: " + labelled.error().message);
      continue;
    }
    if (!labelled) return labelled.error();
    images.push_back(*std::move(labelled));
  }
  if (images.empty())
    return Error{ErrorCode::NotFound, "no image of " + o.images + " has a mask in " + o.masks +
                                          "; a mask has the name of its image"};
  WATERSKY_TRY(const IceModel model, train_ice_model(images, o.parameters, base, progress));
  const std::string text = format_ice_model(model);
  WATERSKY_CHECK(write_file(o.out, text));
  say(common, "Learned from " + std::to_string(images.size()) + " of " +
                  std::to_string(files.size()) + " images.");
  nlohmann::json kinds = nlohmann::json::object();
  const auto tell = [&](const char* kind, const auto& networks, const std::string& origin) {
    if (!networks) return;
    say(common, std::string(kind) + " images: " + origin);
    kinds[kind] = origin;
  };
  tell("gray", model.gray, model.gray_origin);
  tell("colour", model.colour, model.colour_origin);
  say(common, "Use it: watersky segment IMAGES -o OUT --model " + o.out);
  return nlohmann::json{{"verb", "segment train"},    {"model", o.out},
                        {"bytes", text.size()},       {"images", files.size()},
                        {"with_mask", images.size()}, {"kinds", kinds}};
}

}  // namespace

void add_segment_train(CLI::App& segment) {
  auto o = std::make_shared<Options>();
  CLI::App& verb =
      add_verb(segment, "train", "Teach the learned methods from images with hand-made masks",
               [o](const Common& common) { return run(*o, common); });
  verb.add_option("IMAGES", o->images, "folder of images; those without a mask are left out")
      ->required();
  verb.add_option("MASKS", o->masks, "folder of masks with the images' names")->required();
  verb.add_option("-o,--out", o->out, "model file to write, for --model")->required();
  verb.add_option("--mask-values", o->values,
                  "what masks hold: classes (0 melt pond, 1 ice, 2 water, 255 unknown) or binary "
                  "(0 water, else ice)")
      ->check(CLI::IsMember({"classes", "binary"}))
      ->default_val("classes");
  verb.add_option("--base", o->base,
                  "model whose networks are kept for the kind, gray or colour, that the images "
                  "are not of: a file, shipped or none")
      ->capture_default_str();
  verb.add_flag("--overwrite", o->overwrite, "replace MODEL");
  add_parameters(verb, o->parameters);
}

}  // namespace watersky::cli
