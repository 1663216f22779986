// SPDX-License-Identifier: MIT
#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "study.hpp"
#include "watersky/camera/reduced_image.hpp"

namespace watersky::study {

namespace {

/// Lowe's: the best must be so much nearer than the next.
constexpr float kRatio = 0.75F;
/// Of full-size pixels, from the plane that most agree on.
constexpr double kPlane_px = 6.0;
/// Fewer may agree by chance.
constexpr std::size_t kLeastTies = 15;

cv::Rect tile(const Checkerboard& board, int column, int row) {
  const auto edge = [](int k, int count, int length) { return k * length / count; };
  const cv::Point from(edge(column, board.columns, board.image.width),
                       edge(row, board.rows, board.image.height));
  const cv::Point to(edge(column + 1, board.columns, board.image.width),
                     edge(row + 1, board.rows, board.image.height));
  return {from, to};
}

/// Of each row of `a` the row of `b` that passes Lowe's test, or -1.
std::vector<int> best_of(const cv::Mat& a, const cv::Mat& b) {
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_L2).knnMatch(a, b, matches, 2);
  std::vector<int> best(matches.size(), -1);
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (matches[i].size() == 2 && matches[i][0].distance < kRatio * matches[i][1].distance)
      best[i] = matches[i][0].trainIdx;
  return best;
}

}  // namespace

cv::Mat Checkerboard::white() const {
  cv::Mat out(image, CV_8U, cv::Scalar(255));
  for (const cv::Rect& black_tile : black(0)) out(black_tile).setTo(0);
  return out;
}

std::vector<cv::Rect> Checkerboard::black(int margin_px) const {
  std::vector<cv::Rect> out;
  for (int row = 0; row < rows; ++row)
    for (int column = (row + 1) % 2; column < columns; column += 2) {
      const cv::Rect whole = tile(*this, column, row);
      out.emplace_back(whole.x + margin_px, whole.y + margin_px, whole.width - 2 * margin_px,
                       whole.height - 2 * margin_px);
    }
  return out;
}

Result<Keypoints> find_keypoints(const ImageFrame& frame, const std::vector<cv::Rect>& tiles,
                                 int reduction, int most_a_tile) {
  WATERSKY_TRY(cv::Mat image, frame.load({.color = false, .reduction = 1}));
  if (image.depth() != CV_8U) cv::normalize(image, image, 0, 255, cv::NORM_MINMAX, CV_8U);
  image = reduced_by(image, reduction);
  Keypoints out;
  const auto sift = cv::SIFT::create();
  for (const cv::Rect& full : tiles) {
    // Of the tile alone, so that a descriptor looks at nothing beyond it.
    const cv::Rect part(full.x / reduction, full.y / reduction, full.width / reduction,
                        full.height / reduction);
    std::vector<cv::KeyPoint> found;
    sift->detect(image(part), found);
    cv::KeyPointsFilter::retainBest(found, most_a_tile);
    cv::Mat descriptors;
    sift->compute(image(part), found, descriptors);
    if (found.empty()) continue;
    out.descriptors.push_back(descriptors);
    for (const cv::KeyPoint& k : found)
      out.px.push_back((cv::Point2d(k.pt) + cv::Point2d(part.tl()) + cv::Point2d(0.5, 0.5)) *
                           reduction -
                       cv::Point2d(0.5, 0.5));
  }
  return out;
}

std::vector<PixelTie> match(const Keypoints& a, const Keypoints& b, const CameraModel& camera) {
  if (a.px.size() < kLeastTies || b.px.size() < kLeastTies) return {};
  const std::vector<int> there = best_of(a.descriptors, b.descriptors),
                         back = best_of(b.descriptors, a.descriptors);
  std::vector<PixelTie> ties;
  std::vector<cv::Point2d> plane_a, plane_b;
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (there[i] < 0 || back[static_cast<std::size_t>(there[i])] != static_cast<int>(i)) continue;
    const PixelTie t{a.px[i], b.px[static_cast<std::size_t>(there[i])]};
    // Without the lens a plane is a homography exactly.
    const auto ray_a = camera.direction(Pixel{t.a.x, t.a.y}),
               ray_b = camera.direction(Pixel{t.b.x, t.b.y});
    if (!ray_a || !ray_b || !(ray_a->v.z() > 0) || !(ray_b->v.z() > 0)) continue;
    ties.push_back(t);
    for (auto [ray, points] : {std::pair(*ray_a, &plane_a), std::pair(*ray_b, &plane_b)})
      points->emplace_back(camera.focal_px() * ray.v.x() / ray.v.z(),
                           camera.focal_px() * ray.v.y() / ray.v.z());
  }
  if (ties.size() < kLeastTies) return {};
  cv::Mat agrees;
  const cv::Mat h =
      cv::findHomography(plane_a, plane_b, cv::USAC_MAGSAC, kPlane_px, agrees, 10000, 0.999);
  if (h.empty()) return {};
  std::vector<PixelTie> kept;
  for (std::size_t i = 0; i < ties.size(); ++i)
    if (agrees.at<uchar>(static_cast<int>(i)) != 0) kept.push_back(ties[i]);
  if (kept.size() < kLeastTies) kept.clear();
  return kept;
}

Pixel StoredPixels::operator()(const cv::Point2d& mended) const {
  const Eigen::Vector2d p = stored_from_mended * Eigen::Vector3d(mended.x, mended.y, 1.0);
  return {p.x(), p.y()};
}

Result<std::vector<StoredPixels>> stored_pixels(const Flight& recorded,
                                                const std::function<Result<Flight>(Flight)>& mend) {
  const auto right = static_cast<ushort>(recorded.camera.width_px() - 1),
             bottom = static_cast<ushort>(recorded.camera.height_px() - 1);
  // Pictures of four pixels that say where the corner lies that they stand for: mending turns them
  // as it turns the photographs.
  Flight corners = recorded;
  for (ImageFrame& frame : corners.frames)
    frame.load = [right, bottom](const ImageRequest&) -> Result<cv::Mat> {
      cv::Mat image(2, 2, CV_16UC3);
      for (int v = 0; v < 2; ++v)
        for (int u = 0; u < 2; ++u)
          image.at<cv::Vec3w>(v, u) = {u == 0 ? ushort{0} : right, v == 0 ? ushort{0} : bottom, 0};
      return image;
    };
  WATERSKY_TRY(const Flight mended, mend(std::move(corners)));
  std::vector<StoredPixels> out;
  for (const ImageFrame& frame : mended.frames) {
    WATERSKY_TRY(const cv::Mat image, frame.load({}));
    const auto at = [&](int v, int u) {
      const cv::Vec3w c = image.at<cv::Vec3w>(v, u);
      return Eigen::Vector2d(c[0], c[1]);
    };
    Eigen::Matrix<double, 2, 3> m;
    m.col(0) = (at(0, 1) - at(0, 0)) / (mended.camera.width_px() - 1.0);
    m.col(1) = (at(1, 0) - at(0, 0)) / (mended.camera.height_px() - 1.0);
    m.col(2) = at(0, 0);
    out.push_back({m});
  }
  return out;
}

}  // namespace watersky::study
