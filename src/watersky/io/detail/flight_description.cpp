// SPDX-License-Identifier: MIT
#include "watersky/io/detail/flight_description.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/photos.hpp"

namespace watersky {

namespace {

Error bad(const std::string& message) { return {ErrorCode::InvalidInput, message}; }

/// Reads keys of one mapping and remembers which were asked for.
class Mapping {
 public:
  static Result<Mapping> make(const YAML::Node& node, std::string place) {
    if (!node.IsMap()) return bad(place + " must hold key: value pairs");
    return Mapping(node, std::move(place));
  }

  [[nodiscard]] bool has(const std::string& key) {
    asked_.insert(key);
    return node_[key].IsDefined() && !node_[key].IsNull();
  }
  Result<std::string> text(const std::string& key) {
    asked_.insert(key);
    const YAML::Node value = node_[key];
    if (!value.IsDefined()) return bad(place_ + " lacks " + key);
    if (!value.IsScalar()) return bad(place_ + ": " + key + " must be a single value");
    return value.Scalar();
  }
  Result<double> number(const std::string& key, double low, double high) {
    WATERSKY_TRY(const std::string value, text(key));
    const auto x = parse_number(value);
    if (!x || *x < low || *x > high)
      return bad(place_ + ": " + key + " must be a number from " + format_number(low) + " to " +
                 format_number(high));
    return *x;
  }
  Result<double> number_or(const std::string& key, double other, double low, double high) {
    if (!has(key)) return other;
    return number(key, low, high);
  }
  Result<Mapping> mapping(const std::string& key) {
    asked_.insert(key);
    return make(node_[key], place_ + ": " + key);
  }
  void unknown_into(std::vector<std::string>& out, const std::string& prefix) const {
    for (const auto& item : node_) {
      const std::string key = item.first.IsScalar() ? item.first.Scalar() : "?";
      if (!asked_.contains(key)) out.push_back(prefix + key);
    }
  }

 private:
  Mapping(const YAML::Node& node, std::string place) : node_(node), place_(std::move(place)) {}
  YAML::Node node_;
  std::string place_;
  std::set<std::string> asked_;
};

constexpr double kFar_m = 1e7;

Result<Angle> angle(Mapping& map, const std::string& key, double limit_deg = 360) {
  WATERSKY_TRY(const double deg, map.number(key, -limit_deg, limit_deg));
  return Angle::degrees(deg);
}

Status read_mount(Mapping map, FlightDescription& out) {
  YawPitchRoll mount;
  WATERSKY_TRY(mount.roll, angle(map, "roll_deg"));
  WATERSKY_TRY(mount.pitch, angle(map, "pitch_deg"));
  WATERSKY_TRY(mount.yaw, angle(map, "yaw_deg"));
  out.mount = mount;
  int i = 0;
  for (const char* key : {"x_m", "y_m", "z_m"}) {
    WATERSKY_TRY(out.mount_lever_arm_m[i], map.number_or(key, 0.0, -1000, 1000));
    ++i;
  }
  WATERSKY_TRY(const double sigma_deg, map.number_or("sigma_deg", 0.0, 0, 180));
  out.mount_sigma_rad = Angle::degrees(sigma_deg).radians();
  // Accepted, and not used: the lever arm's own sigma is far below the position's.
  WATERSKY_TRY([[maybe_unused]] const double sigma_m, map.number_or("sigma_m", 0.0, 0, 1000));
  map.unknown_into(out.unknown_keys, "mount.");
  return {};
}

Status read_datum(Mapping map, FlightDescription& out) {
  Geodetic origin;
  WATERSKY_TRY(origin.latitude, angle(map, "lat_deg", 90));
  WATERSKY_TRY(origin.longitude, angle(map, "lon_deg", 360));
  WATERSKY_TRY(origin.height_ellipsoid_m, map.number("height_ellipsoid_m", -kFar_m, kFar_m));
  out.datum = origin;
  if (map.has("x_azimuth_deg")) {
    WATERSKY_TRY(out.datum_x_azimuth, angle(map, "x_azimuth_deg"));
  }
  map.unknown_into(out.unknown_keys, "datum.");
  return {};
}

Result<FlightDescription> describe(const YAML::Node& root, const std::string& name) {
  FlightDescription out;
  WATERSKY_TRY(Mapping map, Mapping::make(root, name));
  if (map.has("camera")) {
    WATERSKY_TRY(out.camera, map.text("camera"));
  }
  if (map.has("camera_source")) {
    WATERSKY_TRY(out.camera_source, map.text("camera_source"));
  }
  WATERSKY_TRY(out.camera_focal_sigma_px, map.number_or("camera_focal_sigma_px", 0.0, 0, 1e6));
  if (map.has("mount")) {
    WATERSKY_TRY(Mapping mount, map.mapping("mount"));
    WATERSKY_CHECK(read_mount(std::move(mount), out));
  }
  if (map.has("datum")) {
    WATERSKY_TRY(Mapping datum, map.mapping("datum"));
    WATERSKY_CHECK(read_datum(std::move(datum), out));
  }
  if (map.has("sea_above_datum_m")) {
    WATERSKY_TRY(out.sea_above_datum_m, map.number("sea_above_datum_m", -kFar_m, kFar_m));
  }
  WATERSKY_TRY(out.sea_above_datum_sigma_m, map.number_or("sea_above_datum_sigma_m", 0.0, 0, 1e4));
  WATERSKY_TRY(out.tide_m, map.number_or("tide_m", 0.0, -30, 30));
  if (map.has("sea_follows")) {
    WATERSKY_TRY(const std::string surface, map.text("sea_follows"));
    if (surface != "geoid" && surface != "ellipsoid")
      return bad(name + ": sea_follows must be geoid or ellipsoid");
    out.sea_follows_geoid = surface == "geoid";
  }
  WATERSKY_TRY(out.readout_s, map.number_or("readout_s", 0.0, 0, 10));
  if (map.has("delay_s")) {
    WATERSKY_TRY(out.delay_s, map.number("delay_s", -3600, 3600));
  }
  WATERSKY_TRY([[maybe_unused]] const double delay_sigma_s,
               map.number_or("delay_sigma_s", 0.0, 0, 3600));
  if (map.has("gimbal_frame")) {
    WATERSKY_TRY(const std::string frame, map.text("gimbal_frame"));
    if (frame == "body")
      out.gimbal_frame = GimbalReference::Body;
    else if (frame == "north")
      out.gimbal_frame = GimbalReference::NorthEastDown;
    else
      return bad(name + ": gimbal_frame must be body or north");
  }
  map.unknown_into(out.unknown_keys, "");
  return out;
}

Result<SeaLevel> sea_of(const FlightDescription& d, const Datum& datum) {
  const double at_datum_m = datum.origin().height_ellipsoid_m + *d.sea_above_datum_m + d.tide_m;
  const std::string where =
      "flight.yaml, " + format_number(*d.sea_above_datum_m) + " m above the datum" +
      (d.tide_m == 0.0 ? "" : " and a tide of " + format_number(d.tide_m) + " m");
  if (!d.sea_follows_geoid)
    return SeaLevel{[at_datum_m](const Geodetic&) -> Result<double> { return at_datum_m; }, where,
                    d.sea_above_datum_sigma_m};
  WATERSKY_TRY(const double geoid_m,
               egm96_above_ellipsoid_m(datum.origin().latitude, datum.origin().longitude));
  const double above_geoid_m = at_datum_m - geoid_m;
  return SeaLevel{[above_geoid_m](const Geodetic& p) -> Result<double> {
                    WATERSKY_TRY(const double n, egm96_above_ellipsoid_m(p.latitude, p.longitude));
                    return n + above_geoid_m;
                  },
                  where + ", along the geoid", d.sea_above_datum_sigma_m};
}

/// Quoted for YAML: in double quotes only these need an escape.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

struct SeaLines {
  double above_datum_m = 0.0;
  bool follows_geoid = false;
};

/// A sea level is a function of place; the file knows two kinds. Which one it is shows where the
/// flight was. Unsupported when it is neither.
Result<SeaLines> describe_sea(const Flight& flight) {
  const Geodetic& origin = flight.datum.origin();
  WATERSKY_TRY(const double at_datum_m, flight.sea_level->height_ellipsoid_m(origin));
  SeaLines out{at_datum_m - origin.height_ellipsoid_m, false};
  constexpr double kSame_m = 1e-3;
  double off_ellipsoid_m = 0, off_geoid_m = 0;
  std::vector<Geodetic> places;
  // A degree away the geoid has its own slope even where the flight is short.
  for (const double step_deg : {-0.5, 0.5}) {
    Geodetic p = origin;
    p.latitude = Angle::degrees(std::clamp(origin.latitude.degrees() + step_deg, -89.9, 89.9));
    places.push_back(p);
  }
  const auto& poses = flight.trajectory.poses();
  for (std::size_t i = 0; i < poses.size(); i += 1 + poses.size() / 50)
    places.push_back(flight.datum.geodetic(poses[i].world_from_body.origin()));
  for (const Geodetic& p : places) {
    WATERSKY_TRY(const double h, flight.sea_level->height_ellipsoid_m(p));
    off_ellipsoid_m = std::max(off_ellipsoid_m, std::abs(h - at_datum_m));
  }
  if (off_ellipsoid_m < kSame_m) return out;
  WATERSKY_TRY(const double geoid_at_datum_m,
               egm96_above_ellipsoid_m(origin.latitude, origin.longitude));
  for (const Geodetic& p : places) {
    WATERSKY_TRY(const double h, flight.sea_level->height_ellipsoid_m(p));
    WATERSKY_TRY(const double n, egm96_above_ellipsoid_m(p.latitude, p.longitude));
    off_geoid_m = std::max(off_geoid_m, std::abs((h - at_datum_m) - (n - geoid_at_datum_m)));
  }
  if (off_geoid_m > kSame_m)
    return Error{ErrorCode::Unsupported,
                 "the sea level follows neither the ellipsoid nor the geoid; a flight folder "
                 "cannot hold it"};
  out.follows_geoid = true;
  return out;
}

}  // namespace

Result<FlightDescription> parse_flight_yaml(const std::string& text, const std::string& name) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
  if (text.size() > kMaxBytes) return bad(name + ": is larger than a flight.yaml can be");
  try {
    return describe(YAML::Load(text), name);
  } catch (const YAML::Exception& e) {
    const std::string line = e.mark.is_null() ? "" : ":" + std::to_string(e.mark.line + 1);
    return bad(name + line + ": is no valid YAML (" + e.msg + ")");
  }
}

namespace detail {

Result<Flight> described_flight(const FlightDescription& d, std::string name, const Datum& datum,
                                const CameraModel& camera, const ReadOptions& options) {
  Flight flight(std::move(name), datum, camera);
  for (const std::string& key : d.unknown_keys)
    flight.notes.push_back("flight.yaml: " + key + " means nothing to us and was ignored");
  flight.calibration =
      options.focal_px ? CalibrationSource{"--focal-px " + format_number(*options.focal_px), 0.0}
      : options.camera_file
          ? CalibrationSource{options.camera_file->string(), 0.0}
          : CalibrationSource{d.camera_source.empty() ? d.camera : d.camera_source,
                              d.camera_focal_sigma_px};
  flight.gimbal_reference = d.gimbal_frame;

  const std::optional<YawPitchRoll> mount = options.mount ? options.mount : d.mount;
  const YawPitchRoll otherwise =
      flight.gimbal_reference ? YawPitchRoll{} : YawPitchRoll{{}, Angle::degrees(-90), {}};
  flight.mount.rotation = camera_rotation(mount.value_or(otherwise));
  flight.mount.lever_arm_m = d.mount_lever_arm_m;
  flight.mount.sigma_rad = options.mount ? 0.0 : d.mount_sigma_rad;
  flight.mount.assumed = !mount && !flight.gimbal_reference;
  if (flight.mount.assumed) flight.notes.emplace_back(kAssumedMountNote);
  flight.readout_s = d.readout_s;
  flight.delay_s = options.delay_s ? options.delay_s : d.delay_s;

  if (d.sea_above_datum_m) {
    WATERSKY_TRY(flight.sea_level, sea_of(d, flight.datum));
  } else if (d.tide_m != 0.0) {
    flight.notes.emplace_back(
        "flight.yaml: tide_m goes with sea_above_datum_m, which is not there; it was ignored");
  }
  return flight;
}

Result<std::string> flight_yaml(const Flight& f) {
  const Geodetic& o = f.datum.origin();
  const YawPitchRoll mount =
      yaw_pitch_roll(f.mount.rotation * forward_right_down_from_camera().conjugate());
  const Eigen::Vector3d& arm = f.mount.lever_arm_m;
  std::string y = "camera: camera.yaml\n";
  if (!f.calibration.description.empty())
    y += "camera_source: " + quoted(f.calibration.description) + "\n";
  if (f.calibration.focal_sigma_px > 0)
    y += "camera_focal_sigma_px: " + format_number(f.calibration.focal_sigma_px) + "\n";
  // An assumed mount is not written down as if somebody had measured it.
  if (!f.mount.assumed) {
    y += "mount: {roll_deg: " + format_number(mount.roll.degrees()) +
         ", pitch_deg: " + format_number(mount.pitch.degrees()) +
         ", yaw_deg: " + format_number(mount.yaw.degrees()) + ", x_m: " + format_number(arm.x()) +
         ", y_m: " + format_number(arm.y()) + ", z_m: " + format_number(arm.z());
    if (f.mount.sigma_rad > 0)
      y += ", sigma_deg: " + format_number(Angle::radians(f.mount.sigma_rad).degrees());
    y += "}\n";
  }
  y += "datum: {lat_deg: " + format_number(o.latitude.degrees()) +
       ", lon_deg: " + format_number(o.longitude.degrees()) +
       ", height_ellipsoid_m: " + format_number(o.height_ellipsoid_m) +
       ", x_azimuth_deg: " + format_number(f.datum.x_azimuth().degrees()) + "}\n";
  if (f.sea_level) {
    WATERSKY_TRY(const SeaLines sea, describe_sea(f));
    y += "sea_above_datum_m: " + format_number(sea.above_datum_m) + "\n";
    if (f.sea_level->sigma_m > 0)
      y += "sea_above_datum_sigma_m: " + format_number(f.sea_level->sigma_m) + "\n";
    if (sea.follows_geoid) y += "sea_follows: geoid\n";
  }
  if (f.readout_s > 0) y += "readout_s: " + format_number(f.readout_s) + "\n";
  if (f.delay_s) y += "delay_s: " + format_number(*f.delay_s) + "\n";
  if (f.gimbal_reference)
    y += std::string("gimbal_frame: ") +
         (*f.gimbal_reference == GimbalReference::Body ? "body" : "north") + "\n";
  return y;
}

}  // namespace detail

}  // namespace watersky
