// SPDX-License-Identifier: MIT
/// The doctor on what the libraries can do as they are installed here.
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "doctor.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/gdal_session.hpp"

namespace watersky::cli {

namespace {

struct NeededDriver {
  const char* name;
  const char* able;  ///< what its creation options must know; "" for nothing
  Health without;
  const char* use;
};
constexpr NeededDriver kDrivers[] = {
    {"MEM", "", Health::Fault, "rasters in the making"},
    {"GTiff", "", Health::Fault, "images and rasters read"},
    {"COG", "", Health::Fault, "maps written"},
    {"COG", "JPEG", Health::Warning, "mosaics written: map with --no-mosaic"},
    {"PNG", "", Health::Fault, "the report's pictures"},
    {"GPKG", "", Health::Fault, "vectors written"},
    {"GeoJSON", "", Health::Fault, "icebergs written, masks read"},
    {"ESRI Shapefile", "", Health::Warning, "masks read"},
};

Finding gdal_drivers() {
  Finding f{.name = "gdal.drivers"};
  std::string missing;
  for (const NeededDriver& driver : kDrivers) {
    const bool there = has_gdal_driver(driver.name, driver.able);
    const std::string name =
        driver.name + (*driver.able ? std::string(" with ") + driver.able : std::string());
    f.details[name] = there;
    if (there) {
      f.value += (f.value.empty() ? "" : ", ") + name;
      continue;
    }
    missing += (missing.empty() ? "" : ", ") + name + " (" + driver.use + ")";
    f.health = std::max(f.health, driver.without);
  }
  if (missing.empty()) return f;
  f.value = "missing: " + missing;
  f.remedy = "install libgdal32 of Debian; is GDAL_SKIP set?";
  return f;
}

Finding projections() {
  Finding f{.name = "proj"};
  // UTM 33 needs proj.db; its origin lies at 500 km east.
  const auto utm = Projection::from_text("EPSG:32633");
  const auto origin = utm ? utm->forward(Angle::degrees(0), Angle::degrees(15))
                          : Result<Eigen::Vector2d>(utm.error());
  if (!origin || std::abs(origin->x() - 500000.0) > 0.001) {
    f.health = Health::Fault;
    f.value = origin ? "UTM is computed wrong" : origin.error().message;
    f.remedy = "install proj-data and libproj25; is PROJ_LIB or PROJ_DATA set?";
    return f;
  }
  f.value = "projections by EPSG code";
  return f;
}

Finding geoid() {
  Finding f{.name = "proj.geoid"};
  const auto height_m = egm96_above_ellipsoid_m(Angle::degrees(78.9), Angle::degrees(11.9));
  if (!height_m) {
    f.health = Health::Warning;
    f.value = "no EGM96 geoid: --sea-level geoid:M and heights above sea level cannot be used";
    f.remedy = "install proj-data";
  } else if (std::abs(*height_m - 36.5647) > 0.01) {  // PROJ's own cct
    f.health = Health::Warning;
    f.value = "the EGM96 geoid is wrong at 78.9 N 11.9 E by " +
              std::to_string(*height_m - 36.5647) + " m";
    f.remedy = "reinstall proj-data; is PROJ_LIB or PROJ_DATA set?";
  } else {
    f.value = "EGM96";
  }
  return f;
}

bool in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access(folder.append("/").append(program).c_str(), X_OK) == 0) return true;
  return false;
}

Finding video() {
  Finding f{.name = "video", .value = "ffmpeg and ffprobe"};
  const bool both = in_path("ffmpeg") && in_path("ffprobe");
  f.details = {{"ffmpeg", both}};
  if (!both) {
    f.health = Health::Warning;
    f.value = "videos cannot be read: ffmpeg or ffprobe is missing";
    f.remedy = "install ffmpeg";
  }
  return f;
}

/// For programs that feed the library from a camera; Watersky itself reads video by ffmpeg.
Finding video_backends() {
  Finding f{.name = "video.opencv", .details = {{"backends", nlohmann::json::array()}}};
  std::istringstream build(cv::getBuildInformation());
  bool section = false;
  for (std::string line; std::getline(build, line);) {
    if (line.find("Video I/O:") != std::string::npos) {
      section = true;
      continue;
    }
    if (!section) continue;
    if (line.find_first_not_of(" \t") == std::string::npos) break;  // the section's end
    for (const char* backend : {"FFMPEG", "GStreamer", "v4l/v4l2"})
      if (line.find(std::string(backend) + ":") != std::string::npos &&
          line.find("YES") != std::string::npos) {
        f.value += (f.value.empty() ? "" : ", ") + std::string(backend);
        f.details["backends"].push_back(backend);
      }
  }
  if (f.value.empty()) {
    f.health = Health::Warning;
    f.value = "OpenCV was built without FFmpeg, GStreamer and V4L2: no live camera through it";
    f.remedy = "install libopencv-videoio-dev of Debian";
  }
  return f;
}

}  // namespace

std::vector<Finding> examine_libraries() {
  return {gdal_drivers(), projections(), geoid(), video(), video_backends()};
}

}  // namespace watersky::cli
