// SPDX-License-Identifier: MIT
/// Known warps of real pictures: how often each method is right, and how often it says so when it
/// is not.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <random>

#include "study.hpp"
#include "watersky/registration/homography.hpp"

namespace watersky::study {

namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr int kPicture_px = 820;  ///< what pictures are reduced to: the frames see most of them
constexpr double kNoise = 2.0;
constexpr double kRight_px = 5.0;
constexpr std::array kContrasts{1.0, 0.25, 0.08};

enum class Kind { Small, Large, Apart };
constexpr std::array kKinds{Kind::Small, Kind::Large, Kind::Apart};
const char* name_of(Kind kind) {
  return kind == Kind::Small ? "small" : kind == Kind::Large ? "large" : "apart";
}

struct KnownPair {
  cv::Mat a, b;  ///< full contrast, no noise
  Eigen::Matrix3d b_from_a;
};

Eigen::Matrix3d shifted(double x, double y) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m(0, 2) = x;
  m(1, 2) = y;
  return m;
}

cv::Mat view(const cv::Mat& picture, const Eigen::Matrix3d& picture_from_view) {
  return view_of(picture, picture_from_view, {kWidth, kHeight});
}

class Maker {
 public:
  /// `elsewhere`: pictures of no place that is in `pictures`.
  Maker(const std::vector<cv::Mat>& pictures, const std::vector<cv::Mat>& elsewhere,
        std::uint64_t seed)
      : pictures_(pictures), elsewhere_(elsewhere), random_(seed) {}

  KnownPair make(Kind kind) {
    const std::size_t i = whole(pictures_.size());
    const cv::Mat& picture = pictures_[i];
    const double x = uniform(0, std::max(1, picture.cols - kWidth)),
                 y = uniform(0, std::max(1, picture.rows - kHeight));
    KnownPair pair;
    const Eigen::Matrix3d at = shifted(x, y);
    pair.a = view(picture, at);
    if (kind == Kind::Apart) {
      const cv::Mat& other = elsewhere_[whole(elsewhere_.size())];
      pair.b = view(other, shifted(uniform(0, std::max(1, other.cols - kWidth)),
                                   uniform(0, std::max(1, other.rows - kHeight))));
      return pair;
    }
    const bool small = kind == Kind::Small;
    const double shift = small ? 10 : 60, turn = small ? 2 : 10, zoom = small ? 0.01 : 0.04;
    const double angle = uniform(-turn, turn) * CV_PI / 180, scale = 1 + uniform(-zoom, zoom);
    Eigen::Matrix3d similarity = Eigen::Matrix3d::Identity();
    similarity.topLeftCorner<2, 2>() << scale * std::cos(angle), -scale * std::sin(angle),
        scale * std::sin(angle), scale * std::cos(angle);
    // A tilt of a degree or so: up to 1.5 % of zoom from one border to the other.
    similarity(2, 0) = uniform(-0.015, 0.015) / kWidth;
    similarity(2, 1) = uniform(-0.015, 0.015) / kHeight;
    const double cx = (kWidth - 1) / 2.0, cy = (kHeight - 1) / 2.0;
    pair.b_from_a = shifted(cx + uniform(-shift, shift), cy + uniform(-shift, shift)) * similarity *
                    shifted(-cx, -cy);
    pair.b_from_a /= pair.b_from_a(2, 2);
    pair.b = view(picture, at * pair.b_from_a.inverse());
    return pair;
  }
  std::uint64_t seed() { return random_(); }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random_);
  }
  std::size_t whole(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
  }

  const std::vector<cv::Mat>&pictures_, &elsewhere_;
  std::mt19937_64 random_;
};

struct Tally {
  int pairs = 0, right = 0, wrong = 0;
  std::vector<double> error_px, predicted_px, seconds;
};

double rms_corner_error(const Eigen::Matrix3d& found, const Eigen::Matrix3d& truth) {
  double square = 0;
  for (const cv::Point2d& p : corners_of({kWidth, kHeight}))
    square += std::pow(cv::norm(apply(found, p) - apply(truth, p)), 2) / 4;
  return std::sqrt(square);
}

Status judge(const Contender& contender, const KnownPair& pair, const cv::Mat& a, const cv::Mat& b,
             Kind kind, Tally& tally) {
  const Stopwatch watch;
  WATERSKY_TRY(const auto fa, contender.registrar->prepare(a));
  WATERSKY_TRY(const auto fb, contender.registrar->prepare(b));
  WATERSKY_TRY(const Registration found, contender.registrar->align(fa, fb));
  tally.seconds.push_back(watch.seconds());
  ++tally.pairs;
  if (!found.fit) return {};
  const double error = kind == Kind::Apart
                           ? std::numeric_limits<double>::infinity()
                           : corner_error_px(found.fit->b_from_a, pair.b_from_a, a.size());
  if (error < kRight_px) {
    ++tally.right;
    tally.error_px.push_back(rms_corner_error(found.fit->b_from_a, pair.b_from_a));
    tally.predicted_px.push_back(found.fit->corner_sigma_px);
  } else {
    ++tally.wrong;
  }
  return {};
}

}  // namespace

Status study_warps(const std::vector<std::filesystem::path>& folders, int pairs_each,
                   std::uint64_t seed) {
  const auto methods = contenders();
  std::vector<Tally> all(methods.size());
  std::vector<std::array<Tally, kContrasts.size()>> overlapping(methods.size());
  int total = 0;
  std::vector<std::vector<cv::Mat>> sets;
  for (const auto& folder : folders) {
    WATERSKY_TRY(auto pictures, read_pictures(folder, kPicture_px));
    sets.push_back(std::move(pictures));
  }
  for (std::size_t f = 0; f < folders.size(); ++f) {
    const auto& folder = folders[f];
    const std::string scene = folder.parent_path().filename().string();
    Maker maker(sets[f], sets[(f + 1) % sets.size()], seed + f);
    for (std::size_t level = 0; level < kContrasts.size(); ++level) {
      const double contrast = kContrasts[level];
      tell(
          "\n%s, contrast %.2f, noise %.0f levels, 640x360\n%-7s %-6s %6s %7s %7s %9s %9s %8s "
          "%8s\n",
          scene.c_str(), contrast, kNoise, "method", "pairs", "n", "right", "wrong", "error px",
          "predicted", "mean ms", "median");
      std::vector<std::array<Tally, 3>> tallies(methods.size());
      for (const Kind kind : kKinds) {
        const int n = kind == Kind::Apart ? std::max(1, pairs_each / 4) : pairs_each;
        for (int k = 0; k < n; ++k) {
          const KnownPair pair = maker.make(kind);
          const cv::Mat pattern = fixed_pattern(pair.a.size(), maker.seed());
          const cv::Mat a = seen_by_sensor(pair.a, contrast, pattern, kNoise, maker.seed());
          const cv::Mat b = seen_by_sensor(pair.b, contrast, pattern, kNoise, maker.seed());
          ++total;
          for (std::size_t m = 0; m < methods.size(); ++m)
            WATERSKY_CHECK(
                judge(methods[m], pair, a, b, kind, tallies[m][static_cast<std::size_t>(kind)]));
        }
      }
      for (std::size_t m = 0; m < methods.size(); ++m)
        for (const Kind kind : kKinds) {
          const Tally& t = tallies[m][static_cast<std::size_t>(kind)];
          char where[120];
          std::snprintf(where, sizeof where, "feature_matching.warps.%s.%s.contrast_%g.%s",
                        scene.c_str(), methods[m].name.c_str(), contrast, name_of(kind));
          const std::string figure = where;
          if (kind != Kind::Apart) {
            print_figure(figure + ".right_share", static_cast<double>(t.right) / t.pairs);
            print_figure(figure + ".median_corner_rms_px", median(t.error_px), "px");
            print_figure(figure + ".median_predicted_rms_px", median(t.predicted_px), "px");
          }
          print_figure(figure + ".wrong_share", static_cast<double>(t.wrong) / t.pairs);
          print_figure(figure + ".mean_ms", 1e3 * mean(t.seconds), "ms");
          tell("%-7s %-6s %6d %6.1f%% %6.1f%% %9.2f %9.2f %8.2f %8.2f\n", methods[m].name.c_str(),
               name_of(kind), t.pairs, 100.0 * t.right / t.pairs, 100.0 * t.wrong / t.pairs,
               median(t.error_px), median(t.predicted_px), 1e3 * mean(t.seconds),
               1e3 * median(t.seconds));
          if (kind != Kind::Apart) {
            overlapping[m][level].pairs += t.pairs;
            overlapping[m][level].right += t.right;
          }
          Tally& sum = all[m];
          sum.pairs += t.pairs;
          sum.right += t.right;
          sum.wrong += t.wrong;
          sum.seconds.insert(sum.seconds.end(), t.seconds.begin(), t.seconds.end());
        }
    }
  }
  const auto orb = std::find_if(methods.begin(), methods.end(), [](const Contender& c) {
    return c.method == RegistrationMethod::Orb;
  });
  const double orb_mean = mean(all[static_cast<std::size_t>(orb - methods.begin())].seconds);
  const double orb_median = median(all[static_cast<std::size_t>(orb - methods.begin())].seconds);
  tell("\n%d pairs in all, wrong: accepted and off by 5 px or more at a corner\n", total);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const Tally& t = all[m];
    const std::string figure = "feature_matching.warps." + methods[m].name;
    tell("%-7s right at contrast", methods[m].name.c_str());
    for (std::size_t level = 0; level < kContrasts.size(); ++level) {
      const Tally& o = overlapping[m][level];
      char contrast[40];
      std::snprintf(contrast, sizeof contrast, ".contrast_%g.right_share", kContrasts[level]);
      print_figure(figure + contrast, static_cast<double>(o.right) / o.pairs);
      tell(" %g: %.1f %%,", kContrasts[level], 100.0 * o.right / o.pairs);
    }
    print_figure(figure + ".pairs", t.pairs);
    print_figure(figure + ".wrong_share", static_cast<double>(t.wrong) / t.pairs);
    print_figure(figure + ".mean_ms", 1e3 * mean(t.seconds), "ms");
    print_figure(figure + ".ratio_orb_mean_time", mean(t.seconds) / orb_mean);
    print_figure(figure + ".ratio_orb_median_time", median(t.seconds) / orb_median);
    tell(" wrong %.2f %%, mean %.2f ms (%.2f of ORB's), median %.2f ms (%.2f of ORB's)\n",
         100.0 * t.wrong / t.pairs, 1e3 * mean(t.seconds), mean(t.seconds) / orb_mean,
         1e3 * median(t.seconds), median(t.seconds) / orb_median);
  }
  return {};
}

}  // namespace watersky::study
