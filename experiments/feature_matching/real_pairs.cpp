// SPDX-License-Identifier: MIT
/// Photographs without truth: which pairs are registered, and whether three close.
#include <algorithm>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "study.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky::study {

namespace {

struct Photographs {
  std::vector<std::string> names;
  std::vector<cv::Mat> images;
  std::vector<RegistrationFrame> frames;
};

Result<Photographs> prepare_all(const std::filesystem::path& folder, const Registrar& registrar) {
  WATERSKY_TRY(const auto files, list_images(folder));
  Photographs photographs;
  for (const auto& file : files) {
    WATERSKY_TRY(cv::Mat image, image_loader(file)({.color = false}));
    WATERSKY_TRY(RegistrationFrame frame, registrar.prepare(image));
    photographs.names.push_back(file.stem().string());
    photographs.images.push_back(std::move(image));
    photographs.frames.push_back(std::move(frame));
  }
  return photographs;
}

struct Closure {
  double median_px = std::nan(""), most_px = std::nan("");
};

/// How far A→B→C ends from A→C over what all three show, px of C.
Closure closure(const Eigen::Matrix3d& ba, const Eigen::Matrix3d& cb, const Eigen::Matrix3d& ca,
                cv::Size size) {
  std::vector<double> distances;
  const cv::Rect2d inside(0, 0, size.width, size.height);
  for (int y = 0; y < size.height; y += std::max(1, size.height / 60))
    for (int x = 0; x < size.width; x += std::max(1, size.width / 60)) {
      const cv::Point2d in_b = apply(ba, cv::Point2d(x, y)), around = apply(cb, in_b);
      const cv::Point2d straight = apply(ca, cv::Point2d(x, y));
      if (inside.contains(in_b) && inside.contains(around) && inside.contains(straight))
        distances.push_back(cv::norm(around - straight));
    }
  if (distances.empty()) return {};
  return {median(distances), *std::max_element(distances.begin(), distances.end())};
}

}  // namespace

Status study_hotrax(const std::filesystem::path& folder, const std::filesystem::path& out) {
  /// The only ones that overlap (the data's own README).
  const std::set<std::set<std::string>> overlap{
      {"ice10", "ice11"}, {"ice11", "ice12"}, {"ice10", "ice12"}};
  tell("\nhotrax_pack_ice, 3008x2000: 66 pairs, 3 of which overlap\n%-7s %10s %8s %10s %12s %10s\n",
       "method", "registered", "wrong", "closure px", "most px", "s a pair");
  for (const Contender& contender : contenders()) {
    WATERSKY_TRY(const Photographs all, prepare_all(folder, *contender.registrar));
    int right = 0, wrong = 0, pairs = 0;
    std::map<std::pair<std::string, std::string>, Eigen::Matrix3d> known;
    const Stopwatch watch;
    for (std::size_t i = 0; i < all.frames.size(); ++i)
      for (std::size_t k = i + 1; k < all.frames.size(); ++k) {
        WATERSKY_TRY(const Registration found,
                     contender.registrar->align(all.frames[i], all.frames[k]));
        ++pairs;
        if (!found.fit) continue;
        const bool overlaps = overlap.contains({all.names[i], all.names[k]});
        (overlaps ? right : wrong) += 1;
        known[{all.names[i], all.names[k]}] = found.fit->b_from_a;
        if (overlaps && contender.method == RegistrationMethod::Klt) {
          std::vector<unsigned char> bytes;
          cv::imencode(".png", draw_matches(all.images[i], all.images[k], found), bytes);
          WATERSKY_CHECK(write_file(out / ("hotrax_" + all.names[i] + "_" + all.names[k] + ".png"),
                                    {reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
        }
      }
    const double seconds = watch.seconds() / std::max(1, pairs);
    Closure closes;
    const auto ba = known.find({"ice10", "ice11"}), cb = known.find({"ice11", "ice12"}),
               ca = known.find({"ice10", "ice12"});
    if (ba != known.end() && cb != known.end() && ca != known.end())
      closes = closure(ba->second, cb->second, ca->second, all.frames[0].size());
    const std::string figure = "feature_matching.hotrax_pack_ice." + contender.name;
    print_figure(figure + ".overlapping_pairs_registered", right);
    print_figure(figure + ".other_pairs_registered", wrong);
    print_figure(figure + ".triplet_closure_median_px", closes.median_px, "px");
    print_figure(figure + ".triplet_closure_most_px", closes.most_px, "px");
    print_figure(figure + ".pair_s", seconds, "s");
    tell("%-7s %8d/3 %5d/63 %10.2f %12.2f %10.2f\n", contender.name.c_str(), right, wrong,
         closes.median_px, closes.most_px, seconds);
  }
  return {};
}

Status study_brighton(const std::filesystem::path& folder) {
  WATERSKY_TRY(const auto registrar, make_registrar(RegistrationMethod::Klt));
  WATERSKY_TRY(const Photographs all, prepare_all(folder, *registrar));
  std::vector<double> medians, returns;
  int registered = 0, triplets = 0;
  const std::size_t n = all.frames.size();
  std::vector<std::optional<Eigen::Matrix3d>> next(n);
  tell("\nbrighton_beach, 4000x2250, klt: consecutive frames\n");
  for (std::size_t i = 0; i + 1 < n; ++i) {
    WATERSKY_TRY(const Registration found, registrar->align(all.frames[i], all.frames[i + 1]));
    if (found.fit) {
      ++registered;
      next[i] = found.fit->b_from_a;
      tell("%s %s: overlap %.0f %%, %zu inliers, corners to %.2f px\n", all.names[i].c_str(),
           all.names[i + 1].c_str(), 100 * found.overlap, found.inliers,
           found.fit->corner_sigma_px);
      WATERSKY_TRY(const Registration back, registrar->align(all.frames[i + 1], all.frames[i]));
      if (back.fit)
        returns.push_back(closure(found.fit->b_from_a, back.fit->b_from_a,
                                  Eigen::Matrix3d::Identity(), all.frames[i].size())
                              .median_px);
    } else {
      tell("%s %s: %s\n", all.names[i].c_str(), all.names[i + 1].c_str(), found.reason.c_str());
    }
  }
  for (std::size_t i = 0; i + 2 < n; ++i) {
    if (!next[i] || !next[i + 1]) continue;
    WATERSKY_TRY(const Registration straight, registrar->align(all.frames[i], all.frames[i + 2]));
    if (!straight.fit) continue;
    const Closure closes =
        closure(*next[i], *next[i + 1], straight.fit->b_from_a, all.frames[i].size());
    if (!std::isfinite(closes.median_px)) continue;
    ++triplets;
    medians.push_back(closes.median_px);
    tell("%s and the next two close to %.2f px (most %.2f)\n", all.names[i].c_str(),
         closes.median_px, closes.most_px);
  }
  const std::string figure = "feature_matching.brighton_beach.klt";
  print_figure(figure + ".consecutive_pairs", static_cast<double>(n) - 1);
  print_figure(figure + ".consecutive_pairs_registered", registered);
  print_figure(figure + ".there_and_back", static_cast<double>(returns.size()));
  print_figure(figure + ".there_and_back_median_px", median(returns), "px");
  print_figure(figure + ".triplets", triplets);
  print_figure(figure + ".triplet_closure_median_px", median(medians), "px");
  print_figure(figure + ".triplet_closure_worst_median_px",
               medians.empty() ? std::nan("") : *std::max_element(medians.begin(), medians.end()),
               "px");
  tell("%zu there and back again close to %.2f px (median of medians)\n", returns.size(),
       median(returns));
  tell("%d of %zu registered; %d triplets close to %.2f px (median of medians)\n", registered,
       n - 1, triplets, median(medians));
  return {};
}

}  // namespace watersky::study
