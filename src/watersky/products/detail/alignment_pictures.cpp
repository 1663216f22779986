// SPDX-License-Identifier: MIT
#include "watersky/products/detail/alignment_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "watersky/mapping/mapping.hpp"
#include "watersky/products/palette.hpp"

namespace watersky::detail {

namespace {

constexpr std::size_t kMostConsidered = 400;
constexpr std::size_t kMostShown = 24;
constexpr int kSide_cells = 560;
constexpr double kShareOfFootprint = 0.55;

/// A frame that has a place before and after.
struct Candidate {
  std::size_t index = 0;  ///< in Alignment::frames and in the corrected flight
  CameraPose before, after;
  std::vector<cv::Point2f> footprint_m;  ///< after; easting, northing, from `origin_m_`
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  double gsd_m = 0.0;
  double time_s = 0.0;
};

/// The flight as its frames were put without alignment: what only has an arrival, at that.
Flight at_arrival(const Flight& given) {
  Flight flight = given;
  if (!flight.delay_s) flight.delay_s = 0.0;
  return flight;
}

class Pictures {
 public:
  explicit Pictures(const AlignmentRun& run) : run_(run), given_(at_arrival(run.given)) {}
  std::optional<BeforeAfter> make();

 private:
  void find_candidates();
  [[nodiscard]] std::vector<std::size_t> showing(const Eigen::Vector2d& place_m) const;
  [[nodiscard]] double contrast(const Candidate& candidate) const;
  std::optional<std::size_t> choose_place();
  /// Lays the chosen frames; false when none could be.
  bool lay(const Candidate& centre, const std::vector<std::size_t>& chosen, BeforeAfter& out);
  [[nodiscard]] std::optional<GridView> view(const CameraModel& camera, const CameraPose& pose,
                                             const MapReference& reference) const;
  [[nodiscard]] cv::Mat load(const Candidate& candidate, int reduction);

  const AlignmentRun& run_;
  Flight given_;
  [[nodiscard]] cv::Point2f near_origin(const Eigen::Vector2d& easting_northing_m) const {
    const Eigen::Vector2d d = easting_northing_m - *origin_m_;
    return {static_cast<float>(d.x()), static_cast<float>(d.y())};
  }
  std::optional<Projection> projection_;
  std::optional<Eigen::Vector2d> origin_m_;
  std::vector<Candidate> candidates_;
  double low_ = 0.0, high_ = -1.0;  ///< what 16-bit counts are shown as black and white
};

void Pictures::find_candidates() {
  const auto& frames = run_.alignment.frames;
  const Duration max_gap = seconds(run_.parameters.align_max_pose_gap_s);
  const std::size_t count = std::min(kMostConsidered, run_.corrected.frames.size());
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t k = n * run_.corrected.frames.size() / count;
    const ImageFrame& corrected = run_.corrected.frames[k];
    const auto before = given_.camera_pose(given_.frames[frames[k].index], max_gap);
    const auto after = run_.corrected.camera_pose(corrected, max_gap);
    if (!before || !after) continue;
    if (!projection_)
      if (auto projection = Projection::for_place(after->sea_below)) projection_ = *projection;
    if (!projection_) return;
    const MapReference metres{*projection_, 0.0, 0.0, 1.0};
    const auto grid = view(run_.corrected.camera, *after, metres);
    const auto sea = SeaView::make(run_.corrected.camera, after->sea_from_camera);
    if (!grid || !sea || grid->footprint.empty()) continue;
    Candidate candidate{k, *before, *after, {}};
    for (const Eigen::Vector2d& corner : grid->footprint) {
      const Eigen::Vector2d en = metres.easting_northing_m(corner.x(), corner.y());
      candidate.middle_m += en / static_cast<double>(grid->footprint.size());
    }
    // A projection's metres have seven digits: single precision would hold them to half a metre.
    if (!origin_m_) origin_m_ = candidate.middle_m;
    for (const Eigen::Vector2d& corner : grid->footprint)
      candidate.footprint_m.push_back(
          near_origin(metres.easting_northing_m(corner.x(), corner.y())));
    candidate.gsd_m = sea->gsd_m();
    candidate.time_s = to_seconds(after->time);
    candidates_.push_back(std::move(candidate));
  }
}

std::optional<GridView> Pictures::view(const CameraModel& camera, const CameraPose& pose,
                                       const MapReference& reference) const {
  const auto sea = SeaView::make(camera, pose.sea_from_camera);
  const auto sea_from_grid = reference.sea_from_grid(pose.sea_below);
  if (!sea || !sea_from_grid) return std::nullopt;
  auto grid = make_grid_view(*sea, *sea_from_grid, pose.shutter);
  if (!grid) return std::nullopt;
  return *std::move(grid);
}

std::vector<std::size_t> Pictures::showing(const Eigen::Vector2d& place_m) const {
  std::vector<std::size_t> found;
  const cv::Point2f place = near_origin(place_m);
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (cv::pointPolygonTest(candidates_[i].footprint_m, place, false) > 0) found.push_back(i);
  return found;
}

/// Of the middle of a frame: where nothing is to be seen nothing is to be seen of alignment.
double Pictures::contrast(const Candidate& candidate) const {
  const auto image = run_.corrected.frames[candidate.index].load({.color = false, .reduction = 8});
  if (!image || image->empty()) return 0.0;
  cv::Mat gray = image->reshape(1);
  const cv::Rect middle(gray.cols / 4, gray.rows / 4, std::max(1, gray.cols / 2),
                        std::max(1, gray.rows / 2));
  cv::Scalar mean, deviation;
  cv::meanStdDev(gray(middle), mean, deviation);
  return deviation[0] / std::max(1.0, mean[0]);
}

/// Where many frames, best of several passes, show something.
std::optional<std::size_t> Pictures::choose_place() {
  std::vector<std::pair<double, std::size_t>> ranked;
  std::vector<double> steps;
  for (std::size_t i = 1; i < candidates_.size(); ++i)
    steps.push_back(candidates_[i].time_s - candidates_[i - 1].time_s);
  if (steps.empty()) return std::nullopt;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  const double pass_gap_s = 4 * steps[steps.size() / 2];
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const auto seen = showing(candidates_[i].middle_m);
    if (seen.size() < 2) continue;
    int passes = 1;
    for (std::size_t k = 1; k < seen.size(); ++k)
      passes += candidates_[seen[k]].time_s - candidates_[seen[k - 1]].time_s > pass_gap_s ? 1 : 0;
    ranked.emplace_back(std::min<double>(static_cast<double>(seen.size()), kMostShown) +
                            6 * std::min(passes - 1, 4),
                        i);
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  constexpr std::size_t kLookedAt = 8;
  std::vector<std::size_t> looked_at;
  std::optional<std::size_t> best;
  double best_score = -1.0;
  for (const auto& [score, i] : ranked) {
    const double apart_m = 0.3 * candidates_[i].gsd_m * run_.corrected.camera.height_px();
    const bool near = std::any_of(looked_at.begin(), looked_at.end(), [&](std::size_t other) {
      return (candidates_[other].middle_m - candidates_[i].middle_m).norm() < apart_m;
    });
    if (near) continue;
    looked_at.push_back(i);
    const double now = score * (0.02 + contrast(candidates_[i]));
    if (now > best_score) best = i, best_score = now;
    if (looked_at.size() == kLookedAt) break;
  }
  return best;
}

/// 8 bit, of the size of the camera reduced; empty when it cannot be read.
cv::Mat Pictures::load(const Candidate& candidate, int reduction) {
  const auto image =
      run_.corrected.frames[candidate.index].load({.color = true, .reduction = reduction});
  if (!image) return {};
  const CameraModel camera = run_.corrected.camera.reduced_by(reduction);
  cv::Mat out = *image;
  if (out.cols != camera.width_px() || out.rows != camera.height_px()) {
    if (out.cols != run_.corrected.camera.width_px() ||
        out.rows != run_.corrected.camera.height_px())
      return {};
    // Whole blocks, as the reduced camera has them: the edge is repeated where they reach over it.
    cv::copyMakeBorder(out, out, 0, camera.height_px() * reduction - out.rows, 0,
                       camera.width_px() * reduction - out.cols, cv::BORDER_REPLICATE);
    cv::resize(out, out, cv::Size(camera.width_px(), camera.height_px()), 0, 0, cv::INTER_AREA);
  }
  if (out.depth() == CV_8U) return out;
  if (high_ < low_) {
    // One range for all, wide enough for what the others have beside it.
    cv::Scalar mean, deviation;
    cv::meanStdDev(out.reshape(1), mean, deviation);
    low_ = mean[0] - 3 * deviation[0];
    high_ = mean[0] + 3 * deviation[0] + 1;
  }
  const double scale = 255 / (high_ - low_);
  cv::Mat shown;
  out.convertTo(shown, CV_8U, scale, -scale * low_);
  return shown;
}

/// Sums over the frames of one side.
struct Layers {
  Mosaic mosaic;
  cv::Mat sum, details, squares, count;
  explicit Layers(cv::Size size)
      : sum(size, CV_32FC3, cv::Scalar::all(0)),
        details(size, CV_32F, cv::Scalar(0)),
        squares(size, CV_32F, cv::Scalar(0)),
        count(size, CV_32F, cv::Scalar(0)) {}

  void add(GridView grid, const cv::Mat& image, const CellBox& box) {
    const int first_column = std::max(grid.box.first_column, box.first_column),
              first_row = std::max(grid.box.first_row, box.first_row);
    grid.box = {first_column, first_row,
                std::min(grid.box.end_column(), box.end_column()) - first_column,
                std::min(grid.box.end_row(), box.end_row()) - first_row};
    if (grid.box.empty()) return;
    Mosaic alone;
    if (!mosaic.add(grid, image) || !alone.add(grid, image)) return;
    const cv::Mat seen = alone.bgra(box);
    cv::Mat gray(seen.size(), CV_32F, cv::Scalar(0)), known(seen.size(), CV_32F, cv::Scalar(0));
    for (int r = 0; r < seen.rows; ++r)
      for (int c = 0; c < seen.cols; ++c) {
        const auto& p = seen.at<cv::Vec4b>(r, c);
        if (p[3] == 0) continue;
        const cv::Vec3f color(p[0], p[1], p[2]);
        sum.at<cv::Vec3f>(r, c) += color;
        gray.at<float>(r, c) = 0.114F * color[0] + 0.587F * color[1] + 0.299F * color[2];
        known.at<float>(r, c) = 1.0F;
      }
    count += known;
    // Light and the lens's shading are smooth; what is out of place is not.
    cv::Mat smooth, weight;
    const double sigma_cells = seen.cols / 16.0;
    cv::GaussianBlur(gray, smooth, {}, sigma_cells);
    cv::GaussianBlur(known, weight, {}, sigma_cells);
    cv::Mat detail = gray - smooth / cv::max(weight, 1e-3);
    detail = detail.mul(known);
    details += detail;
    squares += detail.mul(detail);
  }

  /// Standard deviation of the levels without what is smooth, where several frames see a cell; NaN
  /// elsewhere.
  [[nodiscard]] cv::Mat spread() const {
    cv::Mat out(count.size(), CV_32F);
    for (int r = 0; r < out.rows; ++r)
      for (int c = 0; c < out.cols; ++c) {
        const float n = count.at<float>(r, c);
        const float mean = details.at<float>(r, c) / std::max(1.0F, n);
        out.at<float>(r, c) =
            n < 2 ? std::numeric_limits<float>::quiet_NaN()
                  : std::sqrt(std::max(0.0F, squares.at<float>(r, c) / n - mean * mean));
      }
    return out;
  }
};

constexpr int kUnseenGray = 128;

cv::Mat on_gray(const cv::Mat& bgra) {
  cv::Mat out(bgra.size(), CV_8UC3, cv::Scalar::all(kUnseenGray));
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c)
      if (const auto& p = bgra.at<cv::Vec4b>(r, c); p[3] != 0)
        out.at<cv::Vec3b>(r, c) = {p[0], p[1], p[2]};
  return out;
}

PlacePictures pictures_of(const Layers& layers, const cv::Mat& spread, double most,
                          const CellBox& box) {
  PlacePictures out;
  out.mosaic = on_gray(layers.mosaic.bgra(box));
  out.mean.create(layers.sum.size(), CV_8UC3);
  out.spread.create(layers.sum.size(), CV_8UC3);
  double squares = 0.0;
  std::size_t cells = 0;
  for (int r = 0; r < out.mean.rows; ++r)
    for (int c = 0; c < out.mean.cols; ++c) {
      const float n = layers.count.at<float>(r, c);
      const cv::Vec3f mean = layers.sum.at<cv::Vec3f>(r, c) / std::max(1.0F, n);
      out.mean.at<cv::Vec3b>(r, c) =
          n > 0 ? cv::Vec3b(cv::saturate_cast<uchar>(mean[0]), cv::saturate_cast<uchar>(mean[1]),
                            cv::saturate_cast<uchar>(mean[2]))
                : cv::Vec3b::all(kUnseenGray);
      const float s = spread.at<float>(r, c);
      if (std::isnan(s)) {
        out.spread.at<cv::Vec3b>(r, c) = cv::Vec3b::all(kUnseenGray);
        continue;
      }
      squares += static_cast<double>(s) * static_cast<double>(s);
      ++cells;
      const Rgb color = color_at(kCountRamp, static_cast<double>(s) / most);
      out.spread.at<cv::Vec3b>(r, c) = {color.blue, color.green, color.red};
    }
  out.spread_levels = cells > 0 ? std::sqrt(squares / static_cast<double>(cells)) : 0.0;
  return out;
}

/// Ice under fog differs by a few levels: the same stretch for all, to nearly black and white.
void stretch(std::vector<cv::Mat> pictures) {
  std::array<std::size_t, 256> count{};
  std::size_t total = 0;
  for (const cv::Mat& picture : pictures)
    for (auto p = picture.begin<cv::Vec3b>(); p != picture.end<cv::Vec3b>(); ++p) {
      if (*p == cv::Vec3b::all(kUnseenGray)) continue;
      for (int channel = 0; channel < 3; ++channel) ++count[(*p)[channel]];
      total += 3;
    }
  std::size_t below = 0;
  int low = 255, high = 0;
  for (int level = 0; level < 256; ++level) {
    const std::size_t here = count[static_cast<std::size_t>(level)];
    if (below + here > total / 200 && level < low) low = level;
    if (below < total - total / 200) high = level;
    below += here;
  }
  if (high - low < 4) return;
  const double scale = std::max(1.0, 225.0 / (high - low));
  for (cv::Mat& picture : pictures) {
    cv::Mat unseen;
    cv::inRange(picture, cv::Scalar::all(kUnseenGray), cv::Scalar::all(kUnseenGray), unseen);
    picture.convertTo(picture, -1, scale, scale > 1.0 ? 15 - scale * low : 0.0);
    picture.setTo(cv::Scalar::all(kUnseenGray), unseen);
  }
}

bool Pictures::lay(const Candidate& centre, const std::vector<std::size_t>& chosen,
                   BeforeAfter& out) {
  const CameraModel& camera = run_.corrected.camera;
  const double footprint_m = centre.gsd_m * std::min(camera.width_px(), camera.height_px());
  // No finer than the image shows: more cells would only enlarge it.
  out.cell_m = std::max(kShareOfFootprint * footprint_m / kSide_cells, 0.8 * centre.gsd_m);
  const int side =
      std::max(16, static_cast<int>(std::lround(kShareOfFootprint * footprint_m / out.cell_m)));
  const MapReference reference{*projection_, centre.middle_m.x() - 0.5 * side * out.cell_m,
                               centre.middle_m.y() + 0.5 * side * out.cell_m, out.cell_m};
  const CellBox box{0, 0, side, side};
  int reduction = 1;
  while (reduction < 8 && 2 * reduction * centre.gsd_m <= out.cell_m) reduction *= 2;
  Layers before(cv::Size(side, side)), after(cv::Size(side, side));
  for (const std::size_t i : chosen) {
    const Candidate& candidate = candidates_[i];
    const cv::Mat image = load(candidate, reduction);
    if (image.empty()) continue;
    const auto was = view(given_.camera, candidate.before, reference);
    const auto is = view(camera, candidate.after, reference);
    if (!was || !is) continue;
    before.add(was->with(given_.camera.reduced_by(reduction)), image, box);
    after.add(is->with(camera.reduced_by(reduction)), image, box);
    ++out.frames;
  }
  if (out.frames < 2) return false;
  const cv::Mat spread_before = before.spread(), spread_after = after.spread();
  std::vector<float> known;
  for (const cv::Mat& spread : {spread_before, spread_after})
    for (auto it = spread.begin<float>(); it != spread.end<float>(); ++it)
      if (!std::isnan(*it)) known.push_back(*it);
  if (known.empty()) return false;
  // The brightest percent would leave the rest of the picture dark.
  const auto at = known.begin() + static_cast<std::ptrdiff_t>(known.size() * 99 / 100);
  std::nth_element(known.begin(), at, known.end());
  out.most_spread_levels = std::max(1.0, static_cast<double>(*at));
  out.before = pictures_of(before, spread_before, out.most_spread_levels, box);
  out.after = pictures_of(after, spread_after, out.most_spread_levels, box);
  stretch({out.before.mosaic, out.after.mosaic, out.before.mean, out.after.mean});
  return true;
}

std::optional<BeforeAfter> Pictures::make() {
  if (run_.alignment.method == AlignMethod::AsGiven) return std::nullopt;
  find_candidates();
  const auto place = choose_place();
  if (!place) return std::nullopt;
  const auto seen = showing(candidates_[*place].middle_m);
  const std::size_t count = std::min(kMostShown, seen.size());
  std::vector<std::size_t> chosen;
  for (std::size_t n = 0; n < count; ++n) chosen.push_back(seen[n * seen.size() / count]);
  BeforeAfter out;
  if (!lay(candidates_[*place], chosen, out)) return std::nullopt;
  return out;
}

}  // namespace

std::optional<BeforeAfter> before_after(const AlignmentRun& run) { return Pictures(run).make(); }

}  // namespace watersky::detail
