// SPDX-License-Identifier: MIT
#include "watersky/io/camera_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "watersky/io/files.hpp"

namespace watersky {

namespace {

// Sensor widths by the makers' data sheets, or pixel pitch times pixels where a sheet gives the
// pitch. For 1/2.3" cameras, whose sheets give only the type, 6.17 mm is what EXIF focal lengths
// and published calibrations of these models agree on. Zoom and interchangeable lenses have a
// wider sigma: EXIF rounds their focal length.
constexpr double kFixed = 0.02, kZoom = 0.04, kThermal = 0.03;

constexpr KnownCamera kCameras[] = {
    // DJI
    {"FC200", "DJI Phantom 2 Vision", 6.17, 4384, 3288, 0, kFixed, true},
    {"FC300C", "DJI Phantom 3 Standard", 6.17, 4000, 3000, 3.61, kFixed},
    {"FC300S", "DJI Phantom 3 Advanced", 6.17, 4000, 3000, 3.61, kFixed},
    {"FC300X", "DJI Phantom 3 Professional", 6.17, 4000, 3000, 3.61, kFixed},
    {"FC330", "DJI Phantom 4", 6.17, 4000, 3000, 3.61, kFixed},
    {"FC350", "DJI Zenmuse X3", 6.17, 4000, 3000, 3.61, kFixed},
    {"FC550", "DJI Zenmuse X5", 17.3, 4608, 3456, 15, kFixed},
    {"FC6310", "DJI Phantom 4 Pro", 13.2, 5472, 3648, 8.8, kFixed},
    {"FC6310S", "DJI Phantom 4 Pro V2", 13.2, 5472, 3648, 8.8, kFixed},
    {"FC6310R", "DJI Phantom 4 RTK", 13.2, 5472, 3648, 8.8, kFixed},
    {"FC6360", "DJI Phantom 4 Multispectral", 4.96, 1600, 1300, 5.74, kFixed},
    {"FC6510", "DJI Zenmuse X4S", 13.2, 5472, 3648, 8.8, kFixed},
    {"FC6520", "DJI Zenmuse X5S", 17.3, 5280, 3956, 15, kFixed},
    {"FC6540", "DJI Zenmuse X7", 23.5, 6016, 4008, 0, kFixed},
    {"FC220", "DJI Mavic Pro", 6.17, 4000, 3000, 4.73, kFixed},
    {"FC2103", "DJI Mavic Air", 6.17, 4056, 3040, 4.49, kFixed},
    {"FC2204", "DJI Mavic 2 Zoom", 6.17, 4000, 3000, 0, kZoom},
    {"L1D-20c", "DJI Mavic 2 Pro", 13.2, 5472, 3648, 10.26, kFixed},
    {"FC7203", "DJI Mavic Mini", 6.17, 4000, 3000, 4.49, kFixed},
    {"FC7303", "DJI Mini 2", 6.17, 4000, 3000, 4.49, kFixed},
    {"FC3170", "DJI Mavic Air 2", 6.4, 8000, 6000, 4.5, kFixed},
    {"FC3411", "DJI Air 2S", 13.2, 5472, 3648, 8.38, kFixed},
    {"FC3582", "DJI Mini 3 Pro", 9.6, 8064, 6048, 6.72, kFixed},
    {"L2D-20c", "DJI Mavic 3", 17.3, 5280, 3956, 12.29, kFixed},
    {"M3E", "DJI Mavic 3 Enterprise", 17.3, 5280, 3956, 12.29, kFixed},
    {"ZenmuseP1", "DJI Zenmuse P1", 35.9, 8192, 5460, 0, kFixed},
    // Thermal cores: pitch times pixels.
    {"XT2", "DJI Zenmuse XT2", 640 * 0.017, 640, 512, 0, kThermal},
    {"Vue Pro 640", "FLIR Vue Pro 640", 640 * 0.017, 640, 512, 0, kThermal},
    {"Vue Pro R 640", "FLIR Vue Pro R 640", 640 * 0.017, 640, 512, 0, kThermal},
    {"Tau 640", "FLIR Tau 2 640", 640 * 0.017, 640, 512, 0, kThermal},
    {"Boson 640", "FLIR Boson 640", 640 * 0.012, 640, 512, 0, kThermal},
    {"Boson 320", "FLIR Boson 320", 320 * 0.012, 320, 256, 0, kThermal},
    // Multispectral
    {"RedEdge", "MicaSense RedEdge", 1280 * 0.00375, 1280, 960, 0, kFixed},
    {"RedEdge-M", "MicaSense RedEdge-M", 1280 * 0.00375, 1280, 960, 0, kFixed},
    {"Altum", "MicaSense Altum", 2064 * 0.00345, 2064, 1544, 0, kFixed},
    {"Sequoia", "Parrot Sequoia", 1280 * 0.00375, 1280, 960, 0, kFixed},
    {"Anafi", "Parrot Anafi", 5344 * 0.00112, 5344, 4016, 0, kFixed},
    // Sony, Canon, Nikon, Ricoh, Olympus, Panasonic: lenses change, EXIF must say.
    {"ILCE-5100", "Sony A5100", 23.5, 6000, 4000, 0, kZoom},
    {"ILCE-6000", "Sony A6000", 23.5, 6000, 4000, 0, kZoom},
    {"ILCE-QX1", "Sony QX1", 23.2, 5456, 3632, 0, kZoom},
    {"ILCE-7R", "Sony A7R", 35.9, 7360, 4912, 0, kZoom},
    {"ILCE-7RM2", "Sony A7R II", 35.9, 7952, 5304, 0, kZoom},
    {"ILCE-7RM4", "Sony A7R IV", 35.7, 9504, 6336, 0, kZoom},
    {"NEX-5N", "Sony NEX-5N", 23.4, 4912, 3264, 0, kZoom},
    {"NEX-7", "Sony NEX-7", 23.5, 6000, 4000, 0, kZoom},
    {"DSC-RX1RM2", "Sony RX1R II", 35.9, 7952, 5304, 35, kFixed},
    {"DSC-RX100", "Sony RX100", 13.2, 5472, 3648, 0, kZoom},
    {"DSC-WX220", "Sony WX220", 6.17, 4896, 3672, 0, kZoom},
    {"Canon PowerShot S100", "Canon PowerShot S100", 7.44, 4000, 3000, 0, kZoom},
    {"Canon PowerShot S110", "Canon PowerShot S110", 7.44, 4000, 3000, 0, kZoom},
    {"Canon PowerShot SX260 HS", "Canon PowerShot SX260 HS", 6.17, 4000, 3000, 0, kZoom},
    {"Canon IXUS 127 HS", "Canon IXUS 127 HS", 6.17, 4608, 3456, 0, kZoom},
    {"Canon EOS M", "Canon EOS M", 22.3, 5184, 3456, 0, kZoom},
    {"Canon EOS 5D Mark II", "Canon EOS 5D Mark II", 36.0, 5616, 3744, 0, kZoom},
    {"NIKON D800", "Nikon D800", 35.9, 7360, 4912, 0, kZoom},
    {"GR", "Ricoh GR", 23.7, 4928, 3264, 18.3, kFixed},
    {"GR II", "Ricoh GR II", 23.7, 4928, 3264, 18.3, kFixed},
    {"E-PL7", "Olympus E-PL7", 17.3, 4608, 3456, 0, kZoom},
    {"DMC-GH4", "Panasonic GH4", 17.3, 4608, 3456, 0, kZoom},
    {"iXM-100", "Phase One iXM-100", 43.9, 11664, 8750, 0, kFixed},
    {"S.O.D.A.", "senseFly S.O.D.A.", 12.75, 5472, 3648, 10.6, kFixed},
    // Raspberry Pi camera modules; 1640x1232 is version 2 binned over the whole sensor.
    {"RP_ov5647", "Raspberry Pi camera 1", 2592 * 0.0014, 2592, 1944, 3.6, kFixed},
    {"RP_imx219", "Raspberry Pi camera 2", 3280 * 0.00112, 3280, 2464, 3.04, kFixed},
    {"RP_imx477", "Raspberry Pi HQ camera", 4056 * 0.00155, 4056, 3040, 0, kZoom},
    {"RP_imx708", "Raspberry Pi camera 3", 4608 * 0.0014, 4608, 2592, 4.74, kFixed},
    // Action cameras see far too wide for a pinhole, and their modes crop.
    {"HERO4 Black", "GoPro Hero 4 Black", 6.17, 4000, 3000, 0, kFixed, true},
    {"HERO4 Silver", "GoPro Hero 4 Silver", 6.17, 4000, 3000, 0, kFixed, true},
    {"HERO5 Black", "GoPro Hero 5 Black", 6.17, 4000, 3000, 0, kFixed, true},
    {"HERO7 Black", "GoPro Hero 7 Black", 6.17, 4000, 3000, 0, kFixed, true},
};

Error unknown(const std::string& why) {
  return {
      ErrorCode::NotFound,
      why +
          "; give a calibration file (--camera FILE) or the focal length in pixels (--focal-px F)"};
}

std::string format(const char* pattern, double x) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, x);
  return text;
}

Result<Intrinsics> pinhole(double focal_px, const PhotoMetadata& photo, const std::string& source,
                           double relative_sigma) {
  WATERSKY_TRY(Intrinsics out, intrinsics_from_focal_px(focal_px, photo.width_px, photo.height_px));
  out.source = {source + format(": %.0f px", focal_px) + format(" ± %.1f %%", 100 * relative_sigma),
                relative_sigma * focal_px};
  return out;
}

/// Whether an image shows the sensor's whole width, perhaps binned or scaled: any other size may
/// be a crop, and then nobody knows what it shows.
bool shows_full_width(const KnownCamera& camera, int width_px, int height_px) {
  const int longer = std::max(width_px, height_px), shorter = std::min(width_px, height_px);
  if (longer == camera.width_px || longer * 2 == camera.width_px) return true;
  const double aspect = static_cast<double>(longer) / shorter;
  return longer < camera.width_px &&
         std::abs(aspect * camera.height_px / camera.width_px - 1.0) < 0.005;
}

}  // namespace

const KnownCamera* find_known_camera(std::string_view make, std::string_view model) {
  const std::string wanted = lower(model);
  const auto it = std::find_if(std::begin(kCameras), std::end(kCameras),
                               [&](const KnownCamera& c) { return lower(c.model) == wanted; });
  if (it != std::end(kCameras)) return &*it;
  // libcamera names the sensor by where it hangs: "/base/soc/i2c0mux/i2c@1/imx219@10".
  if (lower(make).starts_with("raspberry")) {
    for (const KnownCamera& c : kCameras)
      if (c.model.starts_with("RP_") && wanted.find(c.model.substr(3)) != std::string::npos)
        return &c;
  }
  return nullptr;
}

Result<Intrinsics> intrinsics_from_focal_px(double focal_px, int width_px, int height_px) {
  if (!(focal_px > 0)) return Error{ErrorCode::Usage, "--focal-px must be positive"};
  Eigen::Matrix3d a;
  a << focal_px, 0, (width_px - 1) / 2.0, 0, focal_px, (height_px - 1) / 2.0, 0, 0, 1;
  WATERSKY_TRY(CameraModel camera, CameraModel::make(LensModel::Pinhole, width_px, height_px, a));
  return Intrinsics{std::move(camera), {"--focal-px" + format(" %.6g", focal_px), 0.0}};
}

Result<Intrinsics> intrinsics_from(const PhotoMetadata& photo) {
  const std::string name = photo.camera_name().empty() ? "unnamed camera" : photo.camera_name();
  const KnownCamera* known = find_known_camera(photo.make, photo.model);
  const bool full_size = !known || std::max(photo.width_px, photo.height_px) == known->width_px;

  if (photo.dewarp.size() == 9 && photo.dewarp[0] > 0 && photo.dewarp[1] > 0 && full_size) {
    const auto& d = photo.dewarp;
    Eigen::Matrix3d a;
    a << d[0], 0, (photo.width_px - 1) / 2.0 + d[2], 0, d[1], (photo.height_px - 1) / 2.0 + d[3], 0,
        0, 1;
    std::vector<double> distortion;
    if (!photo.dewarped) distortion = {d[4], d[5], d[6], d[7], d[8]};
    if (auto camera = CameraModel::make(LensModel::Pinhole, photo.width_px, photo.height_px, a,
                                        std::move(distortion)))
      return Intrinsics{
          std::move(*camera),
          {"the maker's calibration in XMP (" + name + format("): %.0f px ± 0.2 %%", d[0]),
           0.002 * d[0]}};
  }
  if (known && known->wide_fisheye)
    return unknown("the " + std::string(known->common_name) +
                   " has a wide fisheye lens that only a calibration describes");
  // A focal length far from any lens's is another unit or another sensor of the camera.
  if (photo.calibrated_focal_px && full_size && *photo.calibrated_focal_px > 0.3 * photo.width_px &&
      *photo.calibrated_focal_px < 20.0 * photo.width_px)
    return pinhole(*photo.calibrated_focal_px, photo, "CalibratedFocalLength in XMP (" + name + ")",
                   0.01);

  if (known) {
    const double focal_mm = photo.focal_length_mm.value_or(known->focal_mm);
    if (focal_mm > 0) {
      const int longer = std::max(photo.width_px, photo.height_px);
      if (!shows_full_width(*known, photo.width_px, photo.height_px))
        return unknown("a " + std::string(known->common_name) + " image of " +
                       std::to_string(photo.width_px) + "x" + std::to_string(photo.height_px) +
                       " pixels is a crop that nobody can know");
      return pinhole(focal_mm / known->sensor_width_mm * longer, photo,
                     (photo.focal_length_mm ? "EXIF focal length and the table of cameras ("
                                            : "the table of cameras (") +
                         std::string(known->common_name) + ")",
                     known->focal_sigma);
    }
  }
  if (photo.focal_length_mm && photo.focal_plane_px_per_mm && full_size)
    return pinhole(*photo.focal_length_mm * *photo.focal_plane_px_per_mm, photo,
                   "EXIF focal length and focal plane resolution (" + name + ")", 0.03);
  if (photo.focal_length_35mm_mm) {
    // The equivalence is by the diagonal, 43.27 mm, of the uncropped image, which may be taller
    // than this one; hence the wide sigma.
    const double diagonal_px = std::hypot(photo.width_px, photo.height_px);
    return pinhole(*photo.focal_length_35mm_mm / 43.27 * diagonal_px, photo,
                   "EXIF 35 mm equivalent focal length (" + name + ")", 0.08);
  }
  return unknown(photo.focal_length_mm
                     ? "the sensor of the " + name + " is not in the table of cameras"
                     : "the photographs do not say their focal length (" + name + ")");
}

}  // namespace watersky
