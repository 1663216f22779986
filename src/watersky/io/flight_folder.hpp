// SPDX-License-Identifier: MIT
#pragma once
/// The flight folder: flight.yaml, frames.csv, poses.csv, images/, and gimbal.csv, known points and
/// ranges where there are any. Any recording can be written as one and read back as the same
/// flight.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/read_options.hpp"

namespace watersky {

/// flight.yaml.
struct FlightDescription {
  std::string camera = "camera.yaml";  ///< beside flight.yaml
  std::string camera_source;           ///< where that came from first; may be empty
  double camera_focal_sigma_px = 0.0;
  std::optional<YawPitchRoll> mount;
  Eigen::Vector3d mount_lever_arm_m = Eigen::Vector3d::Zero();
  double mount_sigma_rad = 0.0;
  std::optional<Geodetic> datum;
  Angle datum_x_azimuth;
  std::optional<double> sea_above_datum_m;
  double sea_above_datum_sigma_m = 0.0;
  double tide_m = 0.0;             ///< the sea stands this much higher than sea_above_datum_m says
  bool sea_follows_geoid = false;  ///< otherwise it is parallel to the ellipsoid
  double readout_s = 0.0;
  std::optional<double> delay_s;
  std::optional<GimbalReference> gimbal_frame;
  std::vector<std::string> unknown_keys;
};

/// InvalidInput naming file and key.
[[nodiscard]] Result<FlightDescription> parse_flight_yaml(const std::string& text,
                                                          const std::string& name);

/// poses.csv in either form; `datum` stands for World. Times must rise strictly: the error names
/// the line. `notes` gets the columns that mean nothing to us.
[[nodiscard]] Result<std::vector<StampedPose>> parse_poses_csv(std::string_view text,
                                                               const std::string& name,
                                                               const Datum& datum,
                                                               std::vector<std::string>& notes);
/// The first position of a poses.csv in geodetic form; nullopt for the other form.
[[nodiscard]] Result<std::optional<Geodetic>> first_place_of_poses_csv(std::string_view text,
                                                                       const std::string& name);

/// gimbal.csv.
[[nodiscard]] Result<std::vector<StampedRotation>> parse_gimbal_csv(std::string_view text,
                                                                    const std::string& name);

[[nodiscard]] Result<Flight> read_flight_folder(const std::filesystem::path& folder,
                                                const ReadOptions& options = {},
                                                const Progress& progress = {});

enum class StoredImages {
  Png,
  Jpeg,  ///< 16 bit images are PNG all the same: nothing is lost
  Keep   ///< image files are copied as they are; what else there is (of a video) becomes as Jpeg
};

/// A file that lies in the folder beside the flight and appears with it.
struct CompanionFile {
  std::string name;
  /// Its bytes, asked for when all frames are written: of these some could not be.
  std::function<Result<std::string>(const std::vector<LeftOut>& not_written)> bytes;
};

struct WriteFlightOptions {
  StoredImages images = StoredImages::Png;
  int jpeg_quality = 95;
  bool keep_as_png = false;  ///< with Keep: what else there is becomes as Png instead
  /// Takes the place of what is at `folder`: the caller has asked whether it may.
  bool replace = false;
  std::vector<CompanionFile> companions{};
};

/// Writes a new folder; Exists when there is something at `folder`, unless it is to be replaced.
/// It appears whole or not at all. Returns the frames that could not be written (an image that
/// cannot be read, no time) and why. Frames that carry their own pose get a row in poses.csv at
/// their time; of several at one time the later are put a microsecond on, as poses must differ in
/// time.
[[nodiscard]] Result<std::vector<LeftOut>> write_flight_folder(
    const Flight& flight, const std::filesystem::path& folder,
    const WriteFlightOptions& options = {}, const Progress& progress = {});

}  // namespace watersky
