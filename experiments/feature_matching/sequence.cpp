// SPDX-License-Identifier: MIT
/// Table 4.2 and the figures around it, with what the thesis could not know beside them.
#include <Eigen/LU>
#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "study.hpp"
#include "watersky/io/files.hpp"
#include "watersky/registration/homography.hpp"
#include "watersky/vision/duplicates.hpp"

namespace watersky::study {

namespace {

constexpr double kThesisHellinger = 0.03;
constexpr double kRight_px = 5.0;

struct Course {
  MethodCourse figure;
  RegistrationFrame before;
  std::optional<Eigen::Matrix3d> last;
  RegistrationFrame two_before;
  std::vector<double> seconds, corner_error_px, closure_px;
  int matched = 0, homographies = 0, right = 0, wrong = 0;
};

/// Skips frames that were recorded twice, and keeps what Figure 4.6 shows.
class Duplicates {
 public:
  explicit Duplicates(bool thesis_rule) : thesis_rule_(thesis_rule) {}

  Result<bool> skip(const SequenceFrame& frame) {
    bool by_thesis = false;
    if (!before_.empty()) {
      WATERSKY_TRY(const double l2, l2_norm(before_, frame.image));
      WATERSKY_TRY(const double distance, hellinger_distance(before_, frame.image));
      l2_norms.push_back(l2);
      hellinger.push_back(distance);
      by_thesis = distance < kThesisHellinger;
    }
    before_ = frame.image;
    WATERSKY_TRY(FrameSample sample, FrameSample::of(frame.image));
    const auto difference = filter_.judge(std::move(sample));
    const bool by_pixels = difference && difference->duplicate;
    thesis += by_thesis;
    ours += by_pixels;
    thesis_lost += by_thesis && !frame.repeated;
    ours_lost += by_pixels && !frame.repeated;
    repeated += frame.repeated;
    return thesis_rule_ ? by_thesis : by_pixels;
  }

  std::vector<double> l2_norms, hellinger;
  int thesis = 0, ours = 0, thesis_lost = 0, ours_lost = 0, repeated = 0;

 private:
  bool thesis_rule_;
  cv::Mat before_;
  DuplicateFilter filter_;
};

/// How far A→B→C ends from A→C, median over what all three show, px of C.
double closure(const Eigen::Matrix3d& ba, const Eigen::Matrix3d& cb, const Eigen::Matrix3d& ca,
               cv::Size size) {
  std::vector<double> distances;
  const auto inside = [&](cv::Point2d p) {
    return p.x >= 0 && p.y >= 0 && p.x < size.width && p.y < size.height;
  };
  for (int y = 0; y < size.height; y += std::max(1, size.height / 30))
    for (int x = 0; x < size.width; x += std::max(1, size.width / 30)) {
      const cv::Point2d in_b = apply(ba, cv::Point2d(x, y)), around = apply(cb, in_b);
      const cv::Point2d straight = apply(ca, cv::Point2d(x, y));
      if (inside(in_b) && inside(around) && inside(straight))
        distances.push_back(cv::norm(around - straight));
    }
  return median(std::move(distances));
}

Status step(const Contender& contender, const SequenceFrame& before, const SequenceFrame& frame,
            Course& course, std::optional<Registration>& shown) {
  const Stopwatch watch;
  WATERSKY_TRY(RegistrationFrame now, contender.registrar->prepare(frame.image));
  WATERSKY_TRY(Registration found, contender.registrar->align(course.before, now));
  course.seconds.push_back(watch.seconds());
  course.figure.matches.push_back(found.matches.size());
  course.figure.registered.push_back(found.fit.has_value());
  course.matched += !found.matches.empty();
  if (found.fit) {
    ++course.homographies;
    if (before.frame_from_scene && frame.frame_from_scene) {
      const Eigen::Matrix3d truth = *frame.frame_from_scene * before.frame_from_scene->inverse();
      const double error = corner_error_px(found.fit->b_from_a, truth / truth(2, 2), now.size());
      if (error < kRight_px) {
        ++course.right;
        course.corner_error_px.push_back(error);
      } else {
        ++course.wrong;
      }
    }
    if (course.last && course.two_before.data()) {
      WATERSKY_TRY(const Registration straight, contender.registrar->align(course.two_before, now));
      if (straight.fit)
        course.closure_px.push_back(
            closure(*course.last, found.fit->b_from_a, straight.fit->b_from_a, now.size()));
    }
    course.last = found.fit->b_from_a;
  } else {
    course.last.reset();
  }
  course.two_before = course.before;
  course.before = std::move(now);
  shown = std::move(found);
  return {};
}

Status write_picture(const std::filesystem::path& file, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes))
    return Error{ErrorCode::Io, file.string() + ": cannot be encoded"};
  return write_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

Status study_sequence(const Sequence& sequence, bool thesis_duplicates,
                      const std::filesystem::path& out) {
  /// The pair of which Figure 4.8 is drawn.
  constexpr int kShownPair = 5;
  const auto methods = contenders();
  std::vector<Course> courses(methods.size());
  Duplicates duplicates(thesis_duplicates);
  std::optional<SequenceFrame> before;
  int images = 0, read = 0;
  while (true) {
    WATERSKY_TRY(std::optional<SequenceFrame> frame, sequence.next());
    if (!frame) break;
    ++read;
    WATERSKY_TRY(const bool skip, duplicates.skip(*frame));
    if (skip) continue;
    ++images;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      Course& course = courses[m];
      course.figure.name = methods[m].name;
      if (!before) {
        WATERSKY_TRY(course.before, methods[m].registrar->prepare(frame->image));
        continue;
      }
      std::optional<Registration> found;
      WATERSKY_CHECK(step(methods[m], *before, *frame, course, found));
      if (images == kShownPair)
        WATERSKY_CHECK(
            write_picture(out / ("figure_4_8_" + sequence.name + "_" + methods[m].name + ".png"),
                          draw_matches(before->image, frame->image, *found)));
    }
    before = std::move(frame);
  }
  const std::string prefix = "feature_matching." + sequence.name + ".";
  print_figure(prefix + "images_read", read);
  print_figure(prefix + "duplicates_by_hellinger", duplicates.thesis);
  print_figure(prefix + "duplicates_by_pixels", duplicates.ours);
  tell("\n%s: %d images read; duplicates by the thesis's rule %d, by pixels %d",
       sequence.name.c_str(), read, duplicates.thesis, duplicates.ours);
  const bool truth = before && before->frame_from_scene;
  if (truth) {
    print_figure(prefix + "frames_lost_by_hellinger", duplicates.thesis_lost);
    print_figure(prefix + "frames_lost_by_pixels", duplicates.ours_lost);
    tell("; %d are; frames lost: %d and %d", duplicates.repeated, duplicates.thesis_lost,
         duplicates.ours_lost);
  }
  tell("\n%-7s %7s %8s %12s %9s %7s %7s %10s %11s\n", "method", "images", "matched", "homographies",
       "mean ms", "right", "wrong", "error px", "closure px");
  std::vector<MethodCourse> figures;
  for (const Course& c : courses) {
    const std::string figure = prefix + c.figure.name;
    print_figure(figure + ".images", images);
    print_figure(figure + ".matched", c.matched);
    print_figure(figure + ".homographies", c.homographies);
    print_figure(figure + ".mean_ms", 1e3 * mean(c.seconds), "ms");
    print_figure(figure + ".median_triplet_closure_px", median(c.closure_px), "px");
    if (truth) {
      print_figure(figure + ".right", c.right);
      print_figure(figure + ".wrong", c.wrong);
      print_figure(figure + ".median_corner_error_px", median(c.corner_error_px), "px");
    }
    char right[16] = "-", wrong[16] = "-";
    if (truth) {
      std::snprintf(right, sizeof right, "%d", c.right);
      std::snprintf(wrong, sizeof wrong, "%d", c.wrong);
    }
    tell("%-7s %7d %8d %12d %9.2f %7s %7s %10.2f %11.2f\n", c.figure.name.c_str(), images,
         c.matched, c.homographies, 1e3 * mean(c.seconds), right, wrong, median(c.corner_error_px),
         median(c.closure_px));
    figures.push_back(c.figure);
  }
  WATERSKY_CHECK(write_figure_4_6(out / ("figure_4_6_" + sequence.name + ".svg"),
                                  duplicates.l2_norms, duplicates.hellinger));
  return write_figure_4_7(out / ("figure_4_7_" + sequence.name + ".svg"), figures);
}

}  // namespace watersky::study
