// SPDX-License-Identifier: MIT
/// Figures 4.2 to 4.5 of the thesis, for Algorithm 1 and for ours.
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithm1_map.hpp"
#include "drawing.hpp"
#include "study.hpp"
#include "watersky/map/algorithm1.hpp"
#include "watersky/sim/laboratory.hpp"

namespace watersky::study {

namespace {

constexpr int kGap = 24, kTitle = 34;

RoomView room(double pixels_per_m) { return {-2.2, 1.0, 0.0, 3.2, pixels_per_m}; }

/// The body's true places in the motion capture's frame, z up.
std::vector<Eigen::Vector3d> path(const sim::Simulation& recording) {
  std::vector<Eigen::Vector3d> out;
  for (const sim::TrueFrame& frame : recording.truth.frames) {
    const Eigen::Vector3d& p = frame.world_from_body.origin().v;
    out.emplace_back(p.x(), -p.y(), -p.z());
  }
  return out;
}

/// Panels of one size in a grid, each under its title.
class Sheet {
 public:
  Sheet(int columns, const std::vector<int>& heights, int width)
      : heights_(heights), width_(width) {
    int height = kGap;
    for (const int h : heights) height += kTitle + h + kGap;
    picture_ = cv::Mat(height, kGap + columns * (width + kGap), CV_8UC3, kPaper);
  }
  void put(int column, int row, const std::string& title, const cv::Mat& panel) {
    int top = kGap;
    for (int r = 0; r < row; ++r) top += kTitle + heights_[static_cast<std::size_t>(r)] + kGap;
    const int left = kGap + column * (width_ + kGap);
    write_text(picture_, title, {left, top + kTitle - 12}, 0.52);
    panel.copyTo(picture_(cv::Rect(left, top + kTitle, panel.cols, panel.rows)));
  }
  [[nodiscard]] const cv::Mat& picture() const { return picture_; }

 private:
  std::vector<int> heights_;
  int width_;
  cv::Mat picture_;
};

cv::Mat map_panel(const RoomMap& map, const sim::Simulation& recording, const RoomView& view) {
  cv::Mat panel = shaded(in_room(map, recording.flight.datum, view));
  draw_truth(panel, recording, view);
  draw_scale(panel, view);
  return panel;
}

cv::Mat path_panel(const sim::Simulation& recording, const RoomView& view) {
  cv::Mat panel(view.size(), CV_8UC3, kPaper);
  for (int x = -3; x <= 3; ++x) {
    const int u = static_cast<int>(view.pixel(x, 0).x()),
              v = static_cast<int>(view.pixel(0, x + 1.0).y());
    cv::line(panel, {u, 0}, {u, panel.rows}, kFaint, 1);
    cv::line(panel, {0, v}, {panel.cols, v}, kFaint, 1);
  }
  std::vector<cv::Point> line;
  for (const Eigen::Vector3d& p : path(recording)) {
    const Eigen::Vector2d q = 16.0 * view.pixel(p.x(), p.y());
    line.emplace_back(static_cast<int>(q.x()), static_cast<int>(q.y()));
  }
  cv::polylines(panel, line, false, kPath, 2, cv::LINE_AA, 4);
  cv::circle(panel, line.front() / 16, 6, kPath, cv::FILLED, cv::LINE_AA);
  draw_truth(panel, recording, view);
  draw_scale(panel, view);
  return panel;
}

/// A viewer beside the room, looking down into it.
class Perspective {
 public:
  Perspective(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, double focal_px,
              cv::Size size)
      : eye_(eye), focal_px_(focal_px), middle_(0.5 * size.width, 0.5 * size.height) {
    forward_ = (target - eye).normalized();
    right_ = forward_.cross(Eigen::Vector3d::UnitZ()).normalized();
    down_ = forward_.cross(right_);
  }
  [[nodiscard]] cv::Point at(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d d = p - eye_;
    const double scale = focal_px_ / d.dot(forward_);
    return {static_cast<int>(std::lround(middle_.x() + scale * d.dot(right_))),
            static_cast<int>(std::lround(middle_.y() + scale * d.dot(down_)))};
  }

 private:
  Eigen::Vector3d eye_, forward_, right_, down_;
  double focal_px_;
  Eigen::Vector2d middle_;
};

/// A frame laid onto the floor as `prepared` has it, what it does not show light gray.
Result<cv::Mat> laid_out(const Flight& prepared, const ImageFrame& frame,
                         const sim::Simulation& recording, const RoomView& view) {
  Algorithm1Parameters parameters;
  parameters.width_cells = view.size().width;
  parameters.height_cells = view.size().height;
  parameters.dx_m = parameters.dy_m = 1.0 / view.pixels_per_m;
  const Rigid3<World, Map> world_from_map(Eigen::Quaterniond::Identity(),
                                          Point<World>{{view.x_from_m, -view.y_to_m, 0.0}});
  WATERSKY_TRY(const Algorithm1 algorithm,
               Algorithm1::make(parameters, prepared.camera, world_from_map));
  const auto same = std::find_if(prepared.frames.begin(), prepared.frames.end(),
                                 [&](const ImageFrame& f) { return f.name == frame.name; });
  if (same == prepared.frames.end())
    return Error{ErrorCode::NotFound, frame.name + " was left out of the flight"};
  WATERSKY_TRY(const CameraPose pose, prepared.camera_pose(*same, std::chrono::seconds(1)));
  WATERSKY_TRY(const cv::Mat image, frame.load({}));
  WATERSKY_TRY(const cv::Mat laid, algorithm.project_image_to_map(image, pose.world_from_camera));
  WATERSKY_TRY(const cv::Mat seen,
               algorithm.project_image_to_map(cv::Mat(image.size(), CV_8U, cv::Scalar(255)),
                                              pose.world_from_camera));
  cv::Mat panel(laid.size(), CV_8UC3, cv::Scalar(214, 211, 208)), colour;
  cv::cvtColor(laid, colour, cv::COLOR_GRAY2BGR);
  colour.copyTo(panel, seen == 255);
  draw_truth(panel, recording, view);
  draw_scale(panel, view);
  return panel;
}

/// The mapped frame that shows most of the patches whole.
std::size_t fullest(const DrawnFlight& flight) {
  const sim::Simulation& recording = *flight.recording;
  std::size_t best = 0, most = 0;
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    const auto index = static_cast<std::size_t>(flight.frames[i] - recording.flight.frames.data());
    const auto camera_from_world = recording.truth.frames[index].world_from_camera.inverse();
    std::size_t whole = 0;
    for (const sim::Outline& outline : recording.truth.sea.pieces())
      whole += std::all_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& corner) {
        const auto pixel =
            recording.flight.camera.project(camera_from_world * recording.truth.world(corner));
        return pixel && recording.flight.camera.contains(*pixel);
      });
    if (whole > most) {
      most = whole;
      best = i;
    }
  }
  return best;
}

}  // namespace

Status write_figure_4_2(const std::filesystem::path& file, const DrawnFlight& flight) {
  const cv::Size size(1100, 780);
  cv::Mat picture(size, CV_8UC3, cv::Scalar(48, 48, 48));
  const Perspective seen({2.0, -2.2, 3.5}, {-0.5, 1.35, 0.5}, 1080.0, size);
  const cv::Scalar grid(110, 110, 110), path_colour(90, 200, 255), shadow(85, 120, 140);
  for (int i = -3; i <= 2; ++i)
    cv::line(picture, seen.at({1.0 * i, -1, 0}), seen.at({1.0 * i, 4, 0}), grid, 1, cv::LINE_AA);
  for (int i = -1; i <= 4; ++i)
    cv::line(picture, seen.at({-3, 1.0 * i, 0}), seen.at({2, 1.0 * i, 0}), grid, 1, cv::LINE_AA);
  const sim::Simulation& recording = *flight.recording;
  for (const sim::Outline& outline : recording.truth.sea.pieces()) {
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& corner : outline) {
      const Eigen::Vector2d p = room_from_scene(recording.flight.datum, corner);
      corners.push_back(seen.at({p.x(), p.y(), 0.0}));
    }
    cv::fillPoly(picture, std::vector<std::vector<cv::Point>>{corners}, kPaper, cv::LINE_AA);
  }
  std::vector<cv::Point> above, below;
  const std::vector<Eigen::Vector3d> places = path(recording);
  for (const Eigen::Vector3d& p : places) {
    above.push_back(seen.at(p));
    below.push_back(seen.at({p.x(), p.y(), 0.0}));
  }
  cv::polylines(picture, below, false, shadow, 1, cv::LINE_AA);
  for (std::size_t i = 0; i < places.size(); i += 150)
    cv::line(picture, above[i], below[i], shadow, 1, cv::LINE_AA);
  cv::polylines(picture, above, false, path_colour, 2, cv::LINE_AA);
  cv::circle(picture, above.front(), 7, path_colour, cv::FILLED, cv::LINE_AA);
  for (std::size_t i = 0; i < sim::kPaperPatches.size(); ++i) {
    const sim::PaperPatch& patch = sim::kPaperPatches[i];
    const double reach_m = 0.55 * recording.truth.sea.objects()[i].max_length_m;
    write_text(picture, std::to_string(patch.number),
               seen.at({patch.x_m + reach_m, patch.y_m - 0.03, 0.0}) + cv::Point(4, 6), 0.6,
               kPaper);
  }
  const struct {
    Eigen::Vector3d end;
    cv::Scalar colour;
    const char* name;
  } axes[] = {{{0.6, 0, 0}, cv::Scalar(70, 70, 235), "x"},
              {{0, 0.6, 0}, cv::Scalar(90, 200, 90), "y"},
              {{0, 0, 0.6}, cv::Scalar(240, 130, 70), "z"}};
  for (const auto& axis : axes) {
    cv::line(picture, seen.at({0, 0, 0}), seen.at(axis.end), axis.colour, 4, cv::LINE_AA);
    write_text(picture, axis.name, seen.at(1.15 * axis.end), 0.7, axis.colour, Align::Centre);
  }
  write_text(picture, "Path of the drone over the patches; the dot is its start.", {24, 36}, 0.6,
             kPaper);
  write_text(picture, "Squares are 1 m wide; axes of the motion capture's frame, z up.", {24, 62},
             0.6, kPaper);
  return write_picture(file, picture);
}

Status write_figure_4_3(const std::filesystem::path& file, const DrawnFlight& flight,
                        const Contender& algorithm1, const Contender& ours) {
  const sim::Simulation& recording = *flight.recording;
  const std::size_t chosen = fullest(flight);
  const ImageFrame& frame = *flight.frames[chosen];
  WATERSKY_TRY(cv::Mat image, frame.load({}));
  WATERSKY_TRY(const std::vector<cv::Mat> masks, segmented(flight.frames));
  cv::Mat mask = masks[chosen].clone();
  for (cv::Mat* panel : {&image, &mask}) {
    cv::cvtColor(*panel, *panel, cv::COLOR_GRAY2BGR);
    cv::rectangle(*panel, {0, 0, panel->cols, panel->rows}, kInk, 1);
  }
  const RoomView view = room(200.0);
  Sheet sheet(2, {image.rows, view.size().height}, image.cols);
  sheet.put(0, 0, "(a) an image", image);
  sheet.put(1, 0, "(b) segmented: paper white", mask);
  int column = 0;
  for (const Contender* contender : {&algorithm1, &ours}) {
    WATERSKY_TRY(const Flight prepared, contender->prepare(recording.flight));
    WATERSKY_TRY(const cv::Mat panel, laid_out(prepared, frame, recording, view));
    sheet.put(column, 1,
              (column == 0 ? "(c) laid onto the floor: " : "(d) laid onto the floor: ") +
                  contender->title,
              panel);
    ++column;
  }
  return write_picture(file, sheet.picture());
}

Status write_figure_4_4(const std::filesystem::path& file, const DrawnFlight& flight,
                        const Contender& algorithm1, const Contender& ours) {
  constexpr int kSteps = 5;
  const RoomView view = room(130.0);
  Sheet sheet(kSteps, {view.size().height, view.size().height}, view.size().width);
  int row = 0;
  for (const Contender* contender : {&algorithm1, &ours}) {
    WATERSKY_TRY(const Flight prepared, contender->prepare(flight.recording->flight));
    for (int i = 0; i < kSteps; ++i) {
      const auto count = static_cast<std::ptrdiff_t>(flight.frames.size() *
                                                     static_cast<std::size_t>(i + 1) / kSteps);
      const std::vector<const ImageFrame*> part(flight.frames.begin(),
                                                flight.frames.begin() + count);
      WATERSKY_TRY(const RoomMap map, make_map(prepared, contender->mapper, part));
      const std::string title = std::to_string(count) + " frames";
      sheet.put(i, row, i == 0 ? contender->title + ": " + title : title,
                map_panel(map, *flight.recording, view));
    }
    ++row;
  }
  return write_picture(file, sheet.picture());
}

Status write_figure_4_5(const std::filesystem::path& file, const std::vector<DrawnFlight>& flights,
                        const std::string& title_of_ours) {
  const RoomView view = room(150.0);
  Sheet sheet(3, std::vector<int>(flights.size(), view.size().height), view.size().width);
  int row = 0;
  for (const DrawnFlight& flight : flights) {
    const std::string number = "Flight " + std::to_string(row + 1);
    sheet.put(0, row, number + ": path from above", path_panel(*flight.recording, view));
    sheet.put(1, row, number + ": Algorithm 1, latest pose",
              map_panel(flight.algorithm1, *flight.recording, view));
    sheet.put(2, row, number + ": " + title_of_ours,
              map_panel(flight.ours, *flight.recording, view));
    ++row;
  }
  return write_picture(file, sheet.picture());
}

}  // namespace watersky::study
