// SPDX-License-Identifier: MIT
/// How far apart overlapping photographs of a real flight put one place, as tagged, after mending
/// the metadata, and after alignment; judged by another detector than the adjustment's, in tiles of
/// the pictures that the adjustment did not see.
///
///   brighton_ties [DATA] [--sea-level LEVEL] [--out FOLDER]
///
/// DATA is a flight of photographs (by default brighton_beach of the real data), its sea at LEVEL
/// (takeoff:2.5). The camera's picture is a checkerboard of 8 x 6 tiles: the alignment gets the
/// white ones, SIFT the black ones, less a margin. (The metadata check looks at all of a picture;
/// whether it is upside down is all that it says.) FOLDER (brighton_ties_study) gets table.txt and
/// ties.csv. Figures are printed one JSON object a line, the table on standard error as well.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <opencv2/core/utility.hpp>

#include "options.hpp"
#include "statistics.hpp"
#include "study.hpp"
#include "support/print_figure.hpp"
#include "support/real_data.hpp"
#include "support/tell.hpp"
#include "watersky/align/frame_pairs.hpp"
#include "watersky/camera/sea_plane.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/products/alignment_run.hpp"

namespace fs = std::filesystem;

namespace watersky::study {

namespace {

constexpr int kReduction = 2;    ///< of 4000 pixels: a pixel of SIFT's is 3 cm on the sea
constexpr int kMostATile = 150;  ///< keypoints
constexpr int kMargin_px = 40;

struct Options {
  fs::path data = test::real_data("brighton_beach").value_or("brighton_beach");
  fs::path out = "brighton_ties_study";
  std::string sea_level = "takeoff:2.5";
};

/// Where one version of the flight puts a pixel of each frame.
class Version {
 public:
  explicit Version(const Flight& flight) {
    for (const ImageFrame& frame : flight.frames) {
      const auto pose = flight.camera_pose(frame, std::chrono::milliseconds(500));
      if (!pose) continue;
      auto view = SeaView::make(flight.camera, pose->sea_from_camera);
      if (!view) continue;
      views_.emplace(frame.name, Placed{*std::move(view), flight.datum.ecef_from_world().inverse() *
                                                              ecef_from_sea(pose->sea_below)});
    }
  }

  /// nullopt where the frame was left out, or does not see the sea there.
  [[nodiscard]] std::optional<Eigen::Vector3d> place(const std::string& frame,
                                                     const Pixel& px) const {
    const auto found = views_.find(frame);
    if (found == views_.end()) return std::nullopt;
    const auto p = found->second.view.sea_point(px);
    if (!p) return std::nullopt;
    return (found->second.world_from_sea * *p).v;
  }

 private:
  struct Placed {
    SeaView view;
    Rigid3<World, Sea> world_from_sea;
  };
  std::map<std::string, Placed> views_;
};

/// What a version of the flight makes of the ties.
struct Disagreement {
  std::vector<double> ties_m;
  std::vector<double> pairs_m, consecutive_m;  ///< the median of each pair: of all, of neighbours
};

struct Contender {
  const char *name, *title;
  Version version;
  Disagreement disagreement{};
};

void tell_and_print(const char* name, const char* title, const Disagreement& d) {
  tell("%-28s %8.3f %8.3f   %8.3f %8.3f   %8.3f %8.3f   %6zu %5zu %5zu\n", title, median(d.ties_m),
       quantile(d.ties_m, 0.9), median(d.pairs_m), quantile(d.pairs_m, 0.9),
       median(d.consecutive_m), quantile(d.consecutive_m, 0.9), d.ties_m.size(), d.pairs_m.size(),
       d.consecutive_m.size());
  const std::string figure = std::string("brighton_ties.") + name;
  print_figure(figure + ".median_m", median(d.ties_m), "m");
  print_figure(figure + ".p90_m", quantile(d.ties_m, 0.9), "m");
  print_figure(figure + ".pair_median_m", median(d.pairs_m), "m");
  print_figure(figure + ".pair_p90_m", quantile(d.pairs_m, 0.9), "m");
  print_figure(figure + ".consecutive_pair_median_m", median(d.consecutive_m), "m");
  print_figure(figure + ".ties", static_cast<double>(d.ties_m.size()));
  print_figure(figure + ".pairs", static_cast<double>(d.pairs_m.size()));
}

Status run(const Options& options) {
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error)
    return Error{ErrorCode::Io, options.out.string() + ": cannot be made: " + error.message()};
  ReadOptions read;
  WATERSKY_TRY(read.sea_level, parse_sea_level_option(options.sea_level));
  WATERSKY_TRY(const Flight tagged, read_flight(options.data, read));

  const Checkerboard board{.image = {tagged.camera.width_px(), tagged.camera.height_px()}};
  AlignOptions align;
  align.threads = 2;
  align.camera_mask = board.white();
  WATERSKY_TRY(const AlignmentRun aligned, run_alignment(tagged, align));
  tell("%s\n%s\n", aligned.metadata.summary.c_str(), summary(aligned).c_str());
  WATERSKY_TRY(const Alignment unmasked,
               align_flight(aligned.given, {.parameters = {}, .threads = align.threads}));
  for (const Alignment* a : {&aligned.alignment, &unmasked})
    tell("%s: %zu sightings of places, %zu pairs of frames in which the flight returns\n",
         a == &unmasked ? "whole picture" : "white tiles", a->sightings, a->revisits);
  WATERSKY_TRY(const Flight by_all, watersky::aligned(aligned.given, unmasked));
  WATERSKY_TRY(const std::vector<StoredPixels> stored, stored_pixels(tagged, [&](Flight flight) {
                 return mended(std::move(flight), aligned.metadata.findings);
               }));

  const Flight& mended_flight = aligned.given;
  std::vector<Keypoints> keypoints;
  for (const ImageFrame& frame : mended_flight.frames) {
    WATERSKY_TRY(keypoints.emplace_back(),
                 find_keypoints(frame, board.black(kMargin_px), kReduction, kMostATile));
  }
  // Of the last the judge is of another kind than the adjustment's, but not of other places.
  Contender contenders[] = {{"as_tagged", "as tagged", Version(tagged)},
                            {"mended", "metadata mended", Version(mended_flight)},
                            {"aligned", "aligned by the white tiles", Version(aligned.corrected)},
                            {"aligned_by_all", "aligned by the whole picture", Version(by_all)}};
  std::string csv = "a,b,a_u_px,a_v_px,b_u_px,b_v_px";
  for (const Contender& c : contenders) csv += std::string(",") + c.name + "_m";
  csv += "\n";
  const PlacedFrames placed = place_frames(mended_flight);
  std::size_t tried = 0;
  for (const FrameOverlap& overlap : choose_pairs(placed.frames)) {
    ++tried;
    const std::size_t a = placed.frames[overlap.a].frame, b = placed.frames[overlap.b].frame;
    const std::string &name_a = mended_flight.frames[a].name,
                      &name_b = mended_flight.frames[b].name;
    const std::vector<PixelTie> ties = match(keypoints[a], keypoints[b], mended_flight.camera);
    if (ties.empty()) continue;
    tell("  %s and %s: %4zu ties, apart", name_a.c_str(), name_b.c_str(), ties.size());
    std::vector<std::string> lines;
    char text[200];
    for (const PixelTie& tie : ties) {
      std::snprintf(text, sizeof text, "%s,%s,%.1f,%.1f,%.1f,%.1f", name_a.c_str(), name_b.c_str(),
                    tie.a.x, tie.a.y, tie.b.x, tie.b.y);
      lines.emplace_back(text);
    }
    for (Contender& contender : contenders) {
      const bool is_stored = &contender == &contenders[0];
      std::vector<double> apart_m;
      for (std::size_t i = 0; i < ties.size(); ++i) {
        const auto px = [&](std::size_t frame, const cv::Point2d& p) {
          return is_stored ? stored[frame](p) : Pixel{p.x, p.y};
        };
        const auto place_a = contender.version.place(name_a, px(a, ties[i].a)),
                   place_b = contender.version.place(name_b, px(b, ties[i].b));
        apart_m.push_back(place_a && place_b ? (*place_a - *place_b).norm() : std::nan(""));
        std::snprintf(text, sizeof text, ",%.3f", apart_m.back());
        lines[i] += text;
      }
      tell(" %7.3f", median(apart_m));
      Disagreement& all = contender.disagreement;
      std::copy_if(apart_m.begin(), apart_m.end(), std::back_inserter(all.ties_m),
                   [](double m) { return std::isfinite(m); });
      if (!std::isfinite(median(apart_m))) continue;  // one of the two was left out
      all.pairs_m.push_back(median(apart_m));
      if (overlap.consecutive) all.consecutive_m.push_back(median(apart_m));
    }
    tell(" m\n");
    for (const std::string& line : lines) csv += line + "\n";
  }
  tell(
      "\nof %zu overlapping pairs, those that share ties in the black tiles: apart on the sea, m\n"
      "%-28s %-19s %-19s %-19s\n%-28s %8s %8s   %8s %8s   %8s %8s   %6s %5s %s\n",
      tried, "", "all ties", "pairs' medians", "of consecutive pairs", "", "median", "p90",
      "median", "p90", "median", "p90", "ties", "pairs", "consecutive");
  for (const Contender& c : contenders) tell_and_print(c.name, c.title, c.disagreement);
  WATERSKY_CHECK(write_file(options.out / "ties.csv", csv));
  return write_file(options.out / "table.txt", told());
}

}  // namespace

}  // namespace watersky::study

int main(int argc, char** argv) {
  using namespace watersky;
  study::Options options;
  if (const auto status = study::read_options(argc, argv, "brighton_ties",
                                              {{"", "DATA", &options.data},
                                               {"--sea-level", "LEVEL", &options.sea_level},
                                               {"--out", "FOLDER", &options.out}}))
    return *status;
  if (!std::filesystem::exists(options.data)) {
    std::fprintf(stderr,
                 "brighton_ties: skipped, %s is not here; give the folder, or set WATERSKY_DATA\n",
                 options.data.c_str());
    return 0;
  }
  cv::setNumThreads(1);
  return study::exit_status("brighton_ties", study::run(options));
}
