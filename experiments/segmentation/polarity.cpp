// SPDX-License-Identifier: MIT
// How often the polarity of ice is found, for each image alone and for each set as one flight.
#include <algorithm>
#include <cstdio>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/files.hpp"
#include "watersky/vision/otsu.hpp"
#include "watersky/vision/segmentation.hpp"

namespace watersky::study {

namespace fs = std::filesystem;

namespace {

struct Picture {
  fs::path file;
  cv::Mat image;
  cv::Mat valid;
};

std::vector<Picture> read_folder(const fs::path& folder, int flags) {
  std::vector<Picture> pictures;
  if (!fs::is_directory(folder)) return pictures;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    cv::Mat image = cv::imread(file.string(), flags);
    if (image.empty()) continue;
    // Tiles at the edge of a mosaic are filled up with black.
    cv::Mat valid;
    if (image.channels() == 3) {
      cv::Mat gray;
      cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
      valid = gray > 8;
    }
    pictures.push_back({file, image, valid});
  }
  return pictures;
}

/// Polarity of each picture alone and of all as one flight.
template <class Truth>
void polarity(const std::string& set, const std::vector<Picture>& pictures, Truth&& truth) {
  if (pictures.empty()) return;
  std::map<IcePolarity, OtsuSegmenter> flights;
  std::map<IcePolarity, std::size_t> members;
  std::size_t right = 0, sure = 0, sure_and_wrong = 0;
  for (const auto& picture : pictures) {
    const auto found = OtsuSegmenter().polarity_of(picture.image, picture.valid);
    if (!found) continue;
    const IcePolarity expected = truth(picture);
    right += found->polarity == expected;
    sure += found->confidence >= kSureOfPolarity;
    sure_and_wrong += found->confidence >= kSureOfPolarity && found->polarity != expected;
    if (found->polarity != expected)
      std::fprintf(stderr, "wrong: %s %s, confidence %.2f, %s\n", set.c_str(),
                   picture.file.filename().c_str(), found->confidence, found->evidence.c_str());
    flights.try_emplace(expected).first->second.observe(picture.image, picture.valid);
    ++members[expected];
  }
  print_figure("polarity." + set + ".images", static_cast<double>(pictures.size()));
  print_figure("polarity." + set + ".images_right", static_cast<double>(right));
  print_figure("polarity." + set + ".images_sure", static_cast<double>(sure));
  print_figure("polarity." + set + ".images_sure_and_wrong", static_cast<double>(sure_and_wrong));
  for (const auto& [expected, flight] : flights) {
    const auto found = flight.polarity();
    const std::string name = "polarity." + set + ".flight_" +
                             (expected == IcePolarity::Brighter ? "brighter" : "darker");
    print_figure(name + ".right", found.polarity == expected ? 1.0 : 0.0);
    print_figure(name + ".confidence", found.confidence);
  }
}

/// What the shipped classifier makes of each picture alone; only of pictures that it was not
/// trained on. Pictures without contrast have no polarity.
void learned_polarity(const std::string& set, const std::vector<Picture>& pictures,
                      IcePolarity expected) {
  if (pictures.empty()) return;
  const LearnedSegmenter segmenter;
  std::size_t told = 0, right = 0, sure = 0, sure_and_wrong = 0;
  for (const auto& picture : pictures) {
    const auto found = segmenter.findings_of(picture.image, picture.valid).polarity;
    if (!found) continue;
    ++told;
    right += found->polarity == expected;
    sure += found->confidence >= kSureOfPolarity;
    sure_and_wrong += found->confidence >= kSureOfPolarity && found->polarity != expected;
  }
  const std::string name = "polarity." + set + ".learned.";
  print_figure(name + "images_told", static_cast<double>(told));
  print_figure(name + "images_right", static_cast<double>(right));
  print_figure(name + "images_sure", static_cast<double>(sure));
  print_figure(name + "images_sure_and_wrong", static_cast<double>(sure_and_wrong));
}

}  // namespace

void study_polarity(const fs::path& data, const std::vector<LabelledImage>& thermal) {
  std::vector<Picture> pictures;
  std::map<std::string, IcePolarity> truth;
  for (const LabelledImage& image : thermal) {
    pictures.push_back({image.name, image.image, {}});
    truth[image.name] = image.truth;
  }
  polarity("tir_sea_ice", pictures, [&](const Picture& p) { return truth[p.file.string()]; });
  if (data.empty()) return;
  const auto brighter = [](const Picture&) { return IcePolarity::Brighter; };
  const auto pack_ice = read_folder(data / "hotrax_pack_ice/images", cv::IMREAD_GRAYSCALE);
  polarity("hotrax_pack_ice", pack_ice, brighter);
  learned_polarity("hotrax_pack_ice", pack_ice, IcePolarity::Brighter);
  // With tiles of shore, kelp and seals but no ice among them: a real flight has such frames.
  auto glacier = read_folder(data / "glacier_bay/tiles", cv::IMREAD_COLOR);
  polarity("glacier_bay", glacier, brighter);
  for (auto& picture : glacier) cv::cvtColor(picture.image, picture.image, cv::COLOR_BGR2GRAY);
  polarity("glacier_bay_gray", glacier, brighter);
  learned_polarity("glacier_bay_gray", glacier, IcePolarity::Brighter);
}

Status study_points(const fs::path& tiles, const fs::path& points) {
  std::error_code ignored;
  if (!fs::exists(points, ignored) || !fs::is_directory(tiles, ignored)) return {};
  WATERSKY_TRY(const std::string text, read_text(points));
  WATERSKY_TRY(const CsvTable table, CsvTable::parse(text, points.filename().string()));
  WATERSKY_CHECK(table.require({"tile", "x_px", "y_px", "label", "near_edge"}));
  const auto cell = [&](std::size_t row, const char* name) -> const std::string& {
    return table.cell(row, *table.column(name));
  };
  std::map<std::string, Picture> pictures;
  for (const Picture& picture : read_folder(tiles, cv::IMREAD_COLOR))
    pictures[picture.file.stem().string()] = picture;
  for (const SegmentationMethod method : segmentation_methods()) {
    WATERSKY_TRY(const auto segmenter, make_segmenter(method));
    // Points in the clear, and within two pixels of an edge.
    struct Count {
      int right = 0, wrong = 0, unknown = 0;
    } count[2];
    std::map<std::string, cv::Mat> results;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const std::string& label = cell(row, "label");
      if (label != "ice" && label != "water") continue;
      const auto picture = pictures.find(cell(row, "tile"));
      if (picture == pictures.end())
        return Error{ErrorCode::NotFound, table.place(row) + ": there is no tile " +
                                              cell(row, "tile") + " in " + tiles.string()};
      cv::Mat& p_ice = results[picture->first];
      if (p_ice.empty()) {
        WATERSKY_TRY(p_ice, segmenter->segment(picture->second.image, {}));
      }
      WATERSKY_TRY(const double x, table.number(row, *table.column("x_px")));
      WATERSKY_TRY(const double y, table.number(row, *table.column("y_px")));
      if (x < 0 || y < 0 || x >= p_ice.cols || y >= p_ice.rows)
        return Error{ErrorCode::InvalidInput, table.place(row) + ": lies outside its tile"};
      const float p = p_ice.at<float>(static_cast<int>(y), static_cast<int>(x));
      Count& c = count[cell(row, "near_edge") == "1" ? 1 : 0];
      if (std::isnan(p))
        ++c.unknown;
      else
        ++((p > 0.5F) == (label == "ice") ? c.right : c.wrong);
    }
    const char* const places[] = {"clear", "near_edge"};
    for (int i = 0; i < 2; ++i) {
      const int all = count[i].right + count[i].wrong + count[i].unknown;
      const std::string name =
          "segmentation.glacier_bay." + std::string(name_of(method)) + "." + places[i];
      print_figure(name + ".points", all);
      print_figure(name + ".right_share", static_cast<double>(count[i].right) / all);
      print_figure(name + ".unknown_share", static_cast<double>(count[i].unknown) / all);
    }
  }
  return {};
}

}  // namespace watersky::study
