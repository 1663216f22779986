// SPDX-License-Identifier: MIT
// Otsu on real sea ice with hand-made masks, told whether ice is brighter and not told; and how
// often the polarity is found, for each image alone and for each set as one flight.
//
//   segmentation_polarity DATA    # the folder with tir_sea_ice/, hotrax_pack_ice/, glacier_bay/, …
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/vision/otsu.hpp"

namespace fs = std::filesystem;
using watersky::IcePolarity;
using watersky::OtsuSegmenter;

namespace {

void print(const std::string& name, double value, const char* unit = "1") {
  std::printf("{\"name\": \"%s\", \"value\": %.6g, \"unit\": \"%s\"}\n", name.c_str(), value, unit);
}

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
    sure += found->confidence >= watersky::kSureOfPolarity;
    sure_and_wrong += found->confidence >= watersky::kSureOfPolarity && found->polarity != expected;
    if (found->polarity != expected)
      std::fprintf(stderr, "wrong: %s %s, confidence %.2f, %s\n", set.c_str(),
                   picture.file.filename().c_str(), found->confidence, found->evidence.c_str());
    flights.try_emplace(expected).first->second.observe(picture.image, picture.valid);
    ++members[expected];
  }
  print("polarity." + set + ".images", static_cast<double>(pictures.size()));
  print("polarity." + set + ".images_right", static_cast<double>(right));
  print("polarity." + set + ".images_sure", static_cast<double>(sure));
  print("polarity." + set + ".images_sure_and_wrong", static_cast<double>(sure_and_wrong));
  for (const auto& [expected, flight] : flights) {
    const auto found = flight.polarity();
    const std::string name = "polarity." + set + ".flight_" +
                             (expected == IcePolarity::Brighter ? "brighter" : "darker");
    print(name + ".right", found.polarity == expected ? 1.0 : 0.0);
    print(name + ".confidence", found.confidence);
  }
}

struct Score {
  double accuracy = 0.0, iou = 0.0, concentration_error = 0.0;
  int images = 0;
  void add(const cv::Mat& p_ice, const cv::Mat& ice) {
    const cv::Mat found = p_ice > 0.5;
    const double both = cv::countNonZero(found & ice), any = cv::countNonZero(found | ice);
    const auto n = static_cast<double>(ice.total());
    accuracy += (n - (any - both)) / n;
    iou += any > 0 ? both / any : 1.0;
    concentration_error += std::abs(cv::countNonZero(found) - cv::countNonZero(ice)) / n;
    ++images;
  }
  void print_as(const std::string& name) const {
    if (images == 0) return;
    print(name + ".accuracy", accuracy / images);
    print(name + ".iou", iou / images);
    print(name + ".concentration_error", concentration_error / images);
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "usage: segmentation_polarity DATA\n");
    return argc == 2 ? 0 : 2;
  }
  const fs::path data = argv[1];
  const auto thermal = read_folder(data / "tir_sea_ice/images", cv::IMREAD_UNCHANGED);
  if (thermal.empty()) {
    std::fprintf(stderr, "%s holds no tir_sea_ice/images\n", data.c_str());
    return 1;
  }
  Score told, automatic, blurred;
  std::map<std::string, IcePolarity> thermal_truth;
  for (const auto& picture : thermal) {
    const cv::Mat mask = cv::imread((data / "tir_sea_ice/masks" / picture.file.filename()).string(),
                                    cv::IMREAD_UNCHANGED);
    if (mask.size() != picture.image.size()) continue;
    const cv::Mat ice = mask == 1;
    // Ice against the sea; ponds are on the ice and brighter than both when thermal.
    const auto truth = cv::mean(picture.image, ice)[0] > cv::mean(picture.image, mask == 2)[0]
                           ? IcePolarity::Brighter
                           : IcePolarity::Darker;
    thermal_truth[picture.file.filename()] = truth;
    cv::Mat smooth;
    cv::blur(picture.image, smooth, cv::Size(5, 5));
    if (const auto p = OtsuSegmenter({}, truth).segment(picture.image, {})) told.add(*p, ice);
    if (const auto p = OtsuSegmenter({}, truth).segment(smooth, {})) blurred.add(*p, ice);
    if (const auto p = OtsuSegmenter().segment(picture.image, {})) automatic.add(*p, ice);
  }
  told.print_as("segmentation.tir_sea_ice.otsu_told");
  blurred.print_as("segmentation.tir_sea_ice.otsu_told_blur5");
  automatic.print_as("segmentation.tir_sea_ice.otsu_auto");

  const auto brighter = [](const Picture&) { return IcePolarity::Brighter; };
  polarity("tir_sea_ice", thermal,
           [&](const Picture& p) { return thermal_truth[p.file.filename()]; });
  polarity("hotrax_pack_ice", read_folder(data / "hotrax_pack_ice/images", cv::IMREAD_GRAYSCALE),
           brighter);
  // With tiles of shore, kelp and seals but no ice among them: a real flight has such frames.
  auto glacier = read_folder(data / "glacier_bay/tiles", cv::IMREAD_COLOR);
  polarity("glacier_bay", glacier, brighter);
  for (auto& picture : glacier) cv::cvtColor(picture.image, picture.image, cv::COLOR_BGR2GRAY);
  polarity("glacier_bay_gray", glacier, brighter);
  return 0;
}
