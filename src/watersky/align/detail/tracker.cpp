// SPDX-License-Identifier: MIT
#include "watersky/align/detail/tracker.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "watersky/registration/homography.hpp"

namespace watersky::align {

namespace {

constexpr double kBlur_px = 1.5;
/// What the blur leaves of white noise in a window's sums, where only slow parts count.
constexpr double kNoiseLeft = 0.7;
constexpr double kSpread = 40.0;  ///< sigma that pictures are brought to, in gray levels
constexpr int kWindow_px = 17;
constexpr int kLevels = 3;
constexpr double kMostBack_px = 1.0;
constexpr double kConsensus_px = 2.0;
/// With fewer left of what there was, new places are chosen before it is time.
constexpr double kFewLeft = 0.4;
constexpr double kLeastCorrelation = 0.6;
/// What interpolation, blur and the patch's own unevenness leave, however clear it is.
constexpr double kFloor_px = 0.05;

cv::Mat one_channel(const cv::Mat& picture) {
  if (picture.channels() == 1) return picture;
  cv::Mat gray;
  cv::cvtColor(picture, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

}  // namespace

struct TrackerPicture {
  double t_s = 0.0;
  int reduction = 1;  ///< full pixels of one of its own
  cv::Mat levels;     ///< CV_32FC1, zero mean, spread kSpread, slightly blurred
  cv::Mat valid;      ///< CV_8UC1 or empty
  double noise = 0.0;
  std::vector<cv::Mat> pyramid;
  cv::Mat original;         ///< for the registrar, which evens in its own way
  RegistrationFrame ready;  ///< made when first needed

  [[nodiscard]] Eigen::Vector2d full(const Eigen::Vector2d& p) const {
    return reduction * p + Eigen::Vector2d::Constant(0.5 * (reduction - 1));
  }
  [[nodiscard]] Eigen::Matrix3d full_from_reduced() const {
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    m(0, 0) = m(1, 1) = reduction;
    m(0, 2) = m(1, 2) = 0.5 * (reduction - 1);
    return m;
  }
  [[nodiscard]] bool shows(const Eigen::Vector2d& p) const {
    if (!(p.x() >= 0 && p.y() >= 0 && p.x() < levels.cols - 1 && p.y() < levels.rows - 1))
      return false;
    return valid.empty() ||
           valid.at<uchar>(static_cast<int>(p.y() + 0.5), static_cast<int>(p.x() + 0.5)) != 0;
  }
};

namespace {

/// Further reduced so that the longer side is no longer than asked.
std::shared_ptr<TrackerPicture> make_picture(const TrackerOptions& options, double t_s,
                                             const cv::Mat& picture, int reduction,
                                             const cv::Mat& valid) {
  auto made = std::make_shared<TrackerPicture>();
  made->t_s = t_s;
  cv::Mat gray = one_channel(picture);
  int more = 1;
  while (std::max(gray.cols, gray.rows) / more > options.longest_side_px) ++more;
  made->valid = valid;
  if (more > 1) {
    const cv::Size size(gray.cols / more, gray.rows / more);
    const cv::Rect whole(0, 0, size.width * more, size.height * more);
    cv::resize(gray(whole), gray, size, 0, 0, cv::INTER_AREA);
    if (!valid.empty()) cv::resize(valid(whole), made->valid, size, 0, 0, cv::INTER_NEAREST);
  }
  made->reduction = reduction * more;
  made->original = gray;
  cv::Mat levels;
  gray.convertTo(levels, CV_32F);
  cv::Scalar mean, spread;
  cv::meanStdDev(levels, mean, spread, made->valid);
  // A picture of nothing stays small numbers: no place in it passes.
  const double scale = kSpread / std::max(spread[0], 0.5);
  levels.convertTo(levels, CV_32F, scale, -scale * mean[0]);
  made->noise = kNoiseLeft * pixel_noise(levels);
  cv::GaussianBlur(levels, made->levels, {}, kBlur_px);
  cv::Mat bytes;
  made->levels.convertTo(bytes, CV_8U, 1.0, 128.0);
  cv::buildOpticalFlowPyramid(bytes, made->pyramid, {kWindow_px, kWindow_px}, kLevels);
  return made;
}

}  // namespace

void Tracker::follow(TrackerPicture& now, const std::optional<Eigen::Matrix3d>& expected,
                     const LocalMap& local_map, Step& step) {
  TrackerPicture& then = *previous_;
  const std::size_t n = tracks_.size();
  if (n == 0) return;

  // Where each place is expected, and the map around it.
  const Eigen::Matrix3d start = expected.value_or(Eigen::Matrix3d::Identity());
  std::vector<Eigen::Vector2d> guess(n);
  std::vector<uchar> kept(n, 1);
  double shift = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d q = start * tracks_[i].px.homogeneous();
    guess[i] = q.z() > 0 ? q.hnormalized() : tracks_[i].px;
    shift = std::max(shift, (guess[i] - tracks_[i].px).norm());
  }
  const bool far = shift > options_.long_step * now.levels.cols;
  double reach_px = 3.0;  // how far from the guess a window may settle
  if (far && registrar_) {
    const auto ready = [&](TrackerPicture& p) -> Status {
      if (p.ready.data()) return {};
      WATERSKY_TRY(p.ready, registrar_->prepare(p.original, p.valid));
      return {};
    };
    std::optional<HomographyFit> fit;
    if (ready(then).ok() && ready(now).ok()) {
      auto found = registrar_->align(then.ready, now.ready, expected);
      if (found) {
        fit = std::move(found->fit);
        step.lost = found->reason;
      } else {
        step.lost = found.error().message;
      }
    }
    if (!fit) {
      tracks_.clear();
      return;
    }
    step.lost.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d q = fit->b_from_a * tracks_[i].px.homogeneous();
      kept[i] = q.z() > 0;
      if (!kept[i]) continue;
      guess[i] = q.hnormalized();
    }
    reach_px = 4.0;
  } else {
    std::vector<cv::Point2f> from(n), to(n), back(n);
    for (std::size_t i = 0; i < n; ++i) {
      from[i] = {static_cast<float>(tracks_[i].px.x()), static_cast<float>(tracks_[i].px.y())};
      to[i] = {static_cast<float>(guess[i].x()), static_cast<float>(guess[i].y())};
    }
    back = from;
    std::vector<uchar> there, here;
    std::vector<float> unused;
    const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 15, 0.03);
    const cv::Size window(kWindow_px, kWindow_px);
    cv::calcOpticalFlowPyrLK(then.pyramid, now.pyramid, from, to, there, unused, window, kLevels,
                             until, cv::OPTFLOW_USE_INITIAL_FLOW, 1e-5);
    cv::calcOpticalFlowPyrLK(now.pyramid, then.pyramid, to, back, here, unused, window, 1, until,
                             cv::OPTFLOW_USE_INITIAL_FLOW, 1e-5);
    std::vector<cv::Point2f> good_from, good_to;
    std::vector<std::size_t> of;
    for (std::size_t i = 0; i < n; ++i) {
      kept[i] = there[i] && here[i] && cv::norm(back[i] - from[i]) < kMostBack_px;
      if (!kept[i]) continue;
      guess[i] = {to[i].x, to[i].y};
      good_from.push_back(from[i]);
      good_to.push_back(to[i]);
      of.push_back(i);
    }
    if (good_from.size() >= 6) {
      cv::Mat inliers;
      const cv::Mat found = cv::estimateAffine2D(good_from, good_to, inliers, cv::RANSAC,
                                                 kConsensus_px, 200, 0.99, 3);
      const int agreeing = found.empty() ? 0 : cv::countNonZero(inliers);
      if (agreeing * 2 >= static_cast<int>(good_from.size())) {
        for (std::size_t k = 0; k < of.size(); ++k)
          kept[of[k]] = inliers.at<uchar>(static_cast<int>(k));
      }
    }
  }

  // Poses may be off by some degrees between host and frame (an unknown delay in a turn): where
  // the places of one host have been carried to tells by how much. A window drawn at a wrong turn
  // settles aside.
  std::map<int, Eigen::Matrix2d> turned;
  for (std::size_t i = 0; i < n; ++i) {
    if (!kept[i] || turned.contains(tracks_[i].host)) continue;
    std::vector<Eigen::Vector2d> from, to;
    Eigen::Vector2d from_mean = Eigen::Vector2d::Zero(), to_mean = Eigen::Vector2d::Zero();
    for (std::size_t k = i; k < n; ++k) {
      if (!kept[k] || tracks_[k].host != tracks_[i].host) continue;
      from.push_back(tracks_[k].host_px);
      to.push_back(guess[k]);
      from_mean += from.back();
      to_mean += to.back();
    }
    from_mean /= static_cast<double>(from.size());
    to_mean /= static_cast<double>(to.size());
    const Eigen::Matrix2d map = local_map(tracks_[i].host, now.full(from_mean));
    double along = 0.0, across = 0.0, spread = 0.0;
    for (std::size_t k = 0; k < from.size(); ++k) {
      const Eigen::Vector2d a = map * (from[k] - from_mean), b = to[k] - to_mean;
      along += a.dot(b);
      across += a.x() * b.y() - a.y() * b.x();
      spread += a.squaredNorm();
    }
    // Two places twenty pixels apart tell a turn to some degrees; less tell less than poses do.
    constexpr double kLeastSpread_px2 = 400.0;
    const double angle = spread > kLeastSpread_px2 ? std::atan2(across, along) : 0.0;
    turned[tracks_[i].host] =
        Eigen::Rotation2Dd(std::abs(angle) < 0.3 ? angle : 0.0).toRotationMatrix();
  }

  // Found again by the host's own window.
  std::vector<Track> still;
  still.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    Track& t = tracks_[i];
    if (!kept[i] || !now.shows(guess[i])) continue;
    const Eigen::Matrix2d map = turned.at(t.host) * local_map(t.host, now.full(t.host_px));
    const double scale = std::sqrt(std::abs(map.determinant()));
    if (!(scale > 0.6 && scale < 1.7)) continue;
    const auto found = t.patch.find(now.levels, guess[i], map, reach_px);
    const bool good = found && found->correlation > kLeastCorrelation && now.shows(found->at);
    if (!good && (far || ++t.misses > 3)) continue;
    t.px = good ? found->at : guess[i];
    if (good) {
      t.misses = 0;
      const double noise2 = t.noise * t.noise + now.noise * now.noise;
      const Eigen::Matrix2d covariance =
          noise2 * map * t.patch.unit_covariance() * map.transpose() +
          kFloor_px * kFloor_px * Eigen::Matrix2d::Identity();
      step.sightings.push_back({t.id, t.host, now.full(t.host_px), now.full(t.px),
                                found->correlation, covariance * now.reduction * now.reduction});
    }
    still.push_back(std::move(t));
  }
  tracks_ = std::move(still);
  if (tracks_.empty()) step.lost = "nothing of the frame before was found again in it";
}

void Tracker::host_anew(const TrackerPicture& now, int frame) {
  std::erase_if(tracks_, [&](Track& t) {
    if (now.t_s - t.host_s <= options_.longest_host_s) return false;
    auto patch = Patch::cut(now.levels, t.px, now.noise);
    if (!patch || t.misses > 0) return true;
    t = {next_id_++, frame, now.t_s, t.px, t.px, *std::move(patch), now.noise};
    return false;
  });
}

void Tracker::choose(const TrackerPicture& now, int frame) {
  const int wanted = options_.points - static_cast<int>(tracks_.size());
  if (wanted <= 0) return;
  cv::Mat strength, highest;
  cv::cornerMinEigenVal(now.levels, strength, 7, 3);
  cv::dilate(strength, highest, cv::Mat::ones(7, 7, CV_8U));
  constexpr int kColumns = 8, kRows = 6;
  std::array<int, kColumns * kRows> in_cell{};
  const auto cell = [&](const Eigen::Vector2d& p) -> std::size_t {
    const int c = std::clamp(static_cast<int>(p.x() * kColumns / now.levels.cols), 0, kColumns - 1);
    const int r = std::clamp(static_cast<int>(p.y() * kRows / now.levels.rows), 0, kRows - 1);
    return static_cast<std::size_t>(r * kColumns + c);
  };
  for (const Track& t : tracks_) ++in_cell[cell(t.px)];
  struct Candidate {
    float strength;
    int u, v;
  };
  std::vector<Candidate> candidates;
  constexpr int kMargin = Patch::kHalf + 3;
  for (int v = kMargin; v < strength.rows - kMargin; ++v) {
    const float *s = strength.ptr<float>(v), *h = highest.ptr<float>(v);
    for (int u = kMargin; u < strength.cols - kMargin; ++u)
      if (s[u] > 0 && s[u] == h[u]) candidates.push_back({s[u], u, v});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.strength != b.strength ? a.strength > b.strength
                                    : std::pair(a.v, a.u) < std::pair(b.v, b.u);
  });
  const double apart_px =
      0.35 * std::sqrt(static_cast<double>(now.levels.total()) / std::max(1, options_.points));
  const int most_in_cell = std::max(2, 2 * options_.points / (kColumns * kRows));
  constexpr int kMostFailed = 30;
  int chosen = 0;
  // In two rounds: spread over the picture first, then wherever there is texture.
  for (const int most : {most_in_cell, options_.points}) {
    int failed = 0;
    for (const Candidate& c : candidates) {
      if (chosen >= wanted) return;
      const Eigen::Vector2d p(c.u, c.v);
      const std::size_t where = cell(p);
      if (in_cell[where] >= most || !now.shows(p)) continue;
      const double apart = most == most_in_cell ? apart_px : 0.5 * apart_px;
      if (std::any_of(tracks_.begin(), tracks_.end(),
                      [&](const Track& t) { return (t.px - p).norm() < apart; }))
        continue;
      auto patch = Patch::cut(now.levels, p, now.noise);
      if (!patch) {
        // Candidates come strongest first: where many in a row cannot be fixed none follows.
        if (++failed > kMostFailed) break;
        continue;
      }
      failed = 0;
      tracks_.push_back({next_id_++, frame, now.t_s, p, p, *std::move(patch), now.noise});
      ++in_cell[where];
      ++chosen;
    }
  }
}

Result<Tracker::Step> Tracker::add(int frame, double t_s, const cv::Mat& picture, int reduction,
                                   const cv::Mat& valid,
                                   const std::optional<Eigen::Matrix3d>& from_previous,
                                   const LocalMap& map) {
  auto now = make_picture(options_, t_s, picture, reduction, valid);
  Step step;
  if (previous_ && previous_->levels.size() == now->levels.size()) {
    std::optional<Eigen::Matrix3d> expected;
    if (from_previous)
      expected =
          now->full_from_reduced().inverse() * *from_previous * previous_->full_from_reduced();
    follow(*now, expected, map, step);
  } else {
    tracks_.clear();
  }
  // Half a typical frame's step early rather than late.
  const double since_s = t_s - last_keyframe_s_;
  const double step_s = previous_ ? t_s - previous_->t_s : 0.0;
  if (since_s + 0.5 * step_s >= options_.keyframe_interval_s ||
      (static_cast<double>(tracks_.size()) < kFewLeft * static_cast<double>(after_choice_) &&
       since_s >= 0.3 * options_.keyframe_interval_s)) {
    step.keyframe = true;
    last_keyframe_s_ = t_s;
    host_anew(*now, frame);
    choose(*now, frame);
    after_choice_ = tracks_.size();
  }
  previous_ = std::move(now);
  return step;
}

}  // namespace watersky::align
