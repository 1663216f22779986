// SPDX-License-Identifier: MIT
#include "watersky/io/detail/photos.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/flir.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/name_time.hpp"

namespace watersky {

namespace {

/// "A,B,C", each within ± `most`; nullopt otherwise.
std::optional<std::array<double, 3>> three_numbers(std::string_view text,
                                                   const std::array<double, 3>& most) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t comma = text.find(',');
    const auto x = parse_number(text.substr(0, comma));
    const bool last = comma == std::string_view::npos;
    if (!x || std::abs(*x) > most[i] || last != (i == 2)) return std::nullopt;
    out[i] = *x;
    if (!last) text.remove_prefix(comma + 1);
  }
  return out;
}

Error not_the_form(const char* option, std::string_view text, const char* form) {
  return {ErrorCode::Usage,
          std::string(option) + " \"" + std::string(text.substr(0, 60)) + "\" is not " + form};
}

}  // namespace

Result<YawPitchRoll> parse_mount_option(std::string_view text) {
  const auto angle = three_numbers(text, {360, 360, 360});
  if (!angle) return not_the_form("--mount", text, "ROLL,PITCH,YAW in degrees, e.g. 0,-90,0");
  const auto& [roll, pitch, yaw] = *angle;
  return YawPitchRoll{Angle::degrees(yaw), Angle::degrees(pitch), Angle::degrees(roll)};
}

Result<Eigen::Vector3d> parse_lever_arm_option(std::string_view text) {
  const auto at = three_numbers(text, {100, 100, 100});
  if (!at) return not_the_form("--lever-arm", text, "FORWARD,RIGHT,DOWN in metres, e.g. 0.3,0,0.1");
  return Eigen::Vector3d((*at)[0], (*at)[1], (*at)[2]);
}

Result<Geodetic> parse_datum_option(std::string_view text) {
  const auto value = three_numbers(text, {90, 360, 1e6});
  if (!value)
    return not_the_form("--datum", text,
                        "LAT,LON,HEIGHT in degrees and metres above the ellipsoid, e.g. "
                        "78.9,11.9,30");
  return Geodetic{Angle::degrees((*value)[0]), Angle::degrees((*value)[1]), (*value)[2]};
}

Result<Time> parse_video_start_option(std::string_view text) {
  if (const auto time = parse_iso8601(text)) return *time;
  if (const auto time = parse_time_seconds(text)) return *time;
  return Error{
      ErrorCode::Usage,
      "--video-start \"" + std::string(text.substr(0, 60)) +
          "\" is neither a time that says its zone, e.g. 2018-08-05T01:00:44.80Z, nor seconds "
          "since 1970"};
}

}  // namespace watersky

namespace watersky::detail {

namespace fs = std::filesystem;

namespace {

std::string described(const PhotoFile& photo) {
  const PhotoMetadata& m = photo.metadata;
  std::string text = photo.path.filename().string() + " (";
  if (!m.camera_name().empty()) text += m.camera_name() + ", ";
  text += std::to_string(m.width_px) + "x" + std::to_string(m.height_px);
  if (m.focal_length_mm) text += ", " + format_number(*m.focal_length_mm) + " mm";
  return text + ")";
}

bool same_camera(const PhotoMetadata& a, const PhotoMetadata& b) {
  const auto focal = [](const PhotoMetadata& m) { return m.focal_length_mm.value_or(0.0); };
  return a.width_px == b.width_px && a.height_px == b.height_px && a.make == b.make &&
         a.model == b.model && std::abs(focal(a) - focal(b)) <= 0.01 * focal(a);
}

}  // namespace

std::string counted(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

Result<PhotoSet> read_photo_set(const fs::path& folder, const Progress& progress) {
  WATERSKY_TRY(std::vector<fs::path> files, list_images(folder));
  std::error_code ignored;
  if (files.empty() && fs::is_directory(folder / "images", ignored)) {
    WATERSKY_TRY(files, list_images(folder / "images"));
  }
  if (files.empty())
    return Error{
        ErrorCode::NotFound,
        folder.string() + ": holds no photographs (.jpg, .png, .tif), nor does its folder images"};
  PhotoSet set;
  for (std::size_t i = 0; i < files.size(); ++i) {
    report(progress, "reading photographs", i, files.size());
    auto metadata = read_photo_metadata(files[i]);
    if (!metadata) {
      set.left_out.push_back({files[i].filename().string(), metadata.error().message});
      continue;
    }
    PhotoFile photo{files[i], std::move(*metadata)};
    if (!set.photos.empty() && !same_camera(set.photos.front().metadata, photo.metadata))
      return Error{ErrorCode::InvalidInput,
                   folder.string() + ": two cameras are mixed, " + described(set.photos.front()) +
                       " and " + described(photo) +
                       "; put each camera's photographs into a folder of its own"};
    set.photos.push_back(std::move(photo));
  }
  report(progress, "reading photographs", files.size(), files.size());
  if (set.photos.empty())
    return Error{ErrorCode::InvalidInput,
                 folder.string() + ": none of its " + counted(files.size(), "photograph") +
                     " can be read; the first: " + set.left_out.front().reason};
  return set;
}

Result<CameraModel> fitted_to(const CameraModel& camera, int width_px, int height_px,
                              const std::string& calibration, const std::string& image,
                              std::vector<std::string>& notes) {
  const auto size = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
  if (camera.width_px() == width_px && camera.height_px() == height_px) return camera;
  // One pixel of rounding is what a scaled image may be off its calibration's shape.
  const double scale = static_cast<double>(width_px) / camera.width_px();
  if (std::abs(scale * camera.height_px() - height_px) > 1.0)
    return Error{ErrorCode::InvalidInput,
                 calibration + " is for images of " + size(camera.width_px(), camera.height_px()) +
                     ", but " + image + " has " + size(width_px, height_px) +
                     "; give the calibration of this camera in this mode (--camera)"};
  notes.push_back("the calibration for " + size(camera.width_px(), camera.height_px()) +
                  " was scaled to the images' " + size(width_px, height_px));
  return camera.scaled_to(width_px, height_px);
}

namespace {

/// nullopt when neither an option nor a calibration in the folder says.
Result<std::optional<Intrinsics>> given_intrinsics(const fs::path& folder, const std::string& image,
                                                   int w, int h, const ReadOptions& options,
                                                   std::vector<std::string>& notes) {
  if (options.camera_file && options.focal_px)
    return Error{ErrorCode::Usage, "--camera and --focal-px exclude each other; give one"};
  if (options.focal_px) {
    WATERSKY_TRY(Intrinsics intrinsics, intrinsics_from_focal_px(*options.focal_px, w, h));
    return std::optional(std::move(intrinsics));
  }
  std::optional<fs::path> file = options.camera_file;
  std::error_code ignored;
  for (const char* name : {"camera.yaml", "camera.yml", "camera.xml"})
    if (!file && fs::exists(folder / name, ignored)) file = folder / name;
  if (!file) return std::optional<Intrinsics>();
  WATERSKY_TRY(const CameraModel camera, read_calibration(*file));
  WATERSKY_TRY(CameraModel fitted, fitted_to(camera, w, h, file->string(), image, notes));
  return std::optional(Intrinsics{std::move(fitted), {file->filename().string(), 0.0}});
}

}  // namespace

namespace {

/// Counts instead of pictures are nothing that a reader may keep to itself.
void note_thermal(const PhotoFile& photo, std::vector<std::string>& notes) {
  const auto bytes = read_bytes(photo.path);
  if (!bytes) return;
  const auto found = find_flir_image(*bytes, photo.path.filename().string());
  if (!found || !*found) return;
  const FlirImage& image = **found;
  std::string text = photo.path.filename().string() + " holds FLIR thermal counts of " +
                     std::to_string(image.counts.cols) + "x" + std::to_string(image.counts.rows);
  if (image.counts.cols == photo.metadata.width_px &&
      image.counts.rows == photo.metadata.height_px) {
    text += ", which are used instead of the pictures (experimental)";
    const auto middle =
        image.counts.at<std::uint16_t>(image.counts.rows / 2, image.counts.cols / 2);
    const auto kelvin = image.scale ? kelvin_of(middle, *image.scale)
                                    : Result<double>(Error{ErrorCode::NotFound, ""});
    if (kelvin) {
      char temperature[120];
      std::snprintf(temperature, sizeof temperature,
                    "; by its own calibration its middle looks like a black body of %.1f K",
                    *kelvin);
      text += temperature;
    } else {
      text += "; it says no calibration, so they stay counts";
    }
  } else {
    text += ", not of the pictures' size: the pictures are used";
  }
  notes.push_back(text + ".");
}

}  // namespace

Result<Intrinsics> choose_intrinsics(const fs::path& folder, const PhotoFile& photo,
                                     const ReadOptions& options, std::vector<std::string>& notes) {
  note_thermal(photo, notes);
  WATERSKY_TRY(auto given,
               given_intrinsics(folder, photo.path.filename().string(), photo.metadata.width_px,
                                photo.metadata.height_px, options, notes));
  if (given) return std::move(*given);
  return intrinsics_from(photo.metadata);
}

Result<Intrinsics> choose_intrinsics(const fs::path& folder, const std::string& image, int width_px,
                                     int height_px, const ReadOptions& options,
                                     std::vector<std::string>& notes) {
  WATERSKY_TRY(auto given, given_intrinsics(folder, image, width_px, height_px, options, notes));
  if (given) return std::move(*given);
  return Error{
      ErrorCode::NotFound,
      image +
          ": does not say which lens filmed it; give --camera FILE (an OpenCV calibration) "
          "or --focal-px F (the focal length in pixels of the full image)"};
}

}  // namespace watersky::detail
