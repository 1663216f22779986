// SPDX-License-Identifier: MIT
#include "watersky/io/photo_flight.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "watersky/geodesy/projection.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/image_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::PhotoFile;

/// GPS is ahead of UTC by this since 2017 (no leap second since).
constexpr std::chrono::seconds kGpsMinusUtc{18};
/// A multirotor's or slow wing's usual lean when nothing was recorded.
constexpr double kAssumedTilt_deg = 5.0;
constexpr double kImageDirectionSigma_deg = 10.0;
constexpr double kTrackSigma_deg = 15.0;
constexpr double kTurnSigma_deg = 40.0;

/// The number at the end of "100_0001_0023" or "DJI_0023".
std::optional<int> index_of(const std::string& stem) {
  const std::size_t last = stem.find_last_not_of("0123456789");
  const std::string digits = stem.substr(last == std::string::npos ? 0 : last + 1);
  if (digits.empty() || digits.size() > 6) return std::nullopt;
  return std::stoi(digits);
}

double horizontal_distance_m(const Geodetic& a, const Geodetic& b) {
  const Point<Ecef> pa = ecef_from({a.latitude, a.longitude, 0}),
                    pb = ecef_from({b.latitude, b.longitude, 0});
  return (pa - pb).v.norm();
}

Angle course(const Geodetic& from, const Geodetic& to) {
  const Point<Sea> p = ecef_from_sea(from).inverse() * ecef_from(to);
  return Angle::radians(std::atan2(p.v.y(), p.v.x()));
}

struct Heading {
  Angle azimuth;
  double sigma_deg;
};

/// Which way the image top points when only a direction or the track is known.
std::optional<Heading> assumed_heading(const std::vector<const PhotoFile*>& photos,
                                       const std::vector<Geodetic>& places, std::size_t i) {
  if (const auto direction = photos[i]->metadata.image_direction)
    return Heading{*direction, kImageDirectionSigma_deg};
  constexpr double kShortest_m = 2.0;
  std::optional<Angle> in, out;
  if (i > 0 && horizontal_distance_m(places[i - 1], places[i]) > kShortest_m)
    in = course(places[i - 1], places[i]);
  if (i + 1 < places.size() && horizontal_distance_m(places[i], places[i + 1]) > kShortest_m)
    out = course(places[i], places[i + 1]);
  if (!in && !out) return std::nullopt;
  if (!in || !out) return Heading{in ? *in : *out, kTrackSigma_deg};
  const Angle turn = (*out - *in).wrapped();
  if (std::abs(turn.degrees()) < 30) return Heading{*in + turn * 0.5, kTrackSigma_deg};
  const bool nearer_before = horizontal_distance_m(places[i - 1], places[i]) <
                             horizontal_distance_m(places[i], places[i + 1]);
  return Heading{nearer_before ? *in : *out, kTurnSigma_deg};
}

/// The mark of a photograph: the same number, at the same place (a folder may hold several
/// flights' marks).
const RtkMark* mark_of(const std::vector<RtkMark>& marks, const PhotoFile& photo,
                       const Geodetic& place) {
  constexpr double kSamePlace_m = 10.0;
  const auto index = index_of(photo.path.stem().string());
  const RtkMark* best = nullptr;
  double best_m = kSamePlace_m;
  for (const RtkMark& mark : marks) {
    if (mark.index != index) continue;
    const double d = horizontal_distance_m(place, {mark.latitude, mark.longitude, 0});
    if (d < best_m) {
      best_m = d;
      best = &mark;
    }
  }
  return best;
}

double median(std::vector<double> x) {
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

/// Heights above the ellipsoid, on one footing for the whole flight.
class Heights {
 public:
  static Result<Heights> make(const std::vector<const PhotoFile*>& photos,
                              std::vector<std::string>& notes) {
    Heights h;
    std::vector<double> takeoffs;
    std::size_t relative = 0;
    for (const PhotoFile* photo : photos) {
      const PhotoMetadata& m = photo->metadata;
      if (!m.relative_altitude_m) continue;
      ++relative;
      const auto absolute = m.absolute_altitude_m ? m.absolute_altitude_m : m.gps_altitude_m;
      if (!absolute) continue;
      double takeoff = *absolute - *m.relative_altitude_m;
      if (m.altitude_is_ellipsoidal) {
        WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(*m.latitude, *m.longitude));
        takeoff -= geoid_m;
      }
      takeoffs.push_back(takeoff);
    }
    if (relative == 0) return h;
    h.takeoff_ = TakeOff{takeoffs.empty() ? 0.0 : median(takeoffs), !takeoffs.empty()};
    if (relative < photos.size())
      notes.push_back(detail::counted(photos.size() - relative, "photograph") +
                      " without a height above take-off got the nominal altitude above sea level");
    return h;
  }

  [[nodiscard]] const std::optional<TakeOff>& takeoff() const { return takeoff_; }

  /// OutOfRange when the photograph knows no height.
  [[nodiscard]] Result<double> ellipsoidal_m(const PhotoMetadata& m) const {
    const auto absolute = m.absolute_altitude_m ? m.absolute_altitude_m : m.gps_altitude_m;
    if (m.altitude_is_ellipsoidal && absolute) return *absolute;
    WATERSKY_TRY(const double geoid_m, egm96_above_ellipsoid_m(*m.latitude, *m.longitude));
    if (takeoff_ && m.relative_altitude_m)
      return takeoff_->height_geoid_m + *m.relative_altitude_m + geoid_m;
    if (absolute) return *absolute + geoid_m;
    return Error{ErrorCode::OutOfRange, "it records no height"};
  }

 private:
  std::optional<TakeOff> takeoff_;
};

Result<std::vector<RtkMark>> read_marks(const fs::path& folder) {
  std::vector<RtkMark> out;
  WATERSKY_TRY(const auto files, files_with_extension(folder, {".mrk"}));
  for (const fs::path& file : files) {
    WATERSKY_TRY(const std::string text, read_text(file, std::size_t{1} << 26));
    for (RtkMark& mark : parse_rtk_marks(text)) out.push_back(mark);
  }
  return out;
}

}  // namespace

std::vector<RtkMark> parse_rtk_marks(std::string_view text) {
  std::vector<RtkMark> marks;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));

    // "1  279618.431024  [2005]  -51,N  -79,E  242,V  22.5,Lat  113.9,Lon  77.8,Ellh  0.01, 0.01,
    // 0.02  50,Q"
    std::vector<std::string> words;
    std::string word;
    for (const char c : line) {
      if (c == ' ' || c == '\t' || c == ',' || c == '[' || c == ']' || c == '\r') {
        if (!word.empty()) words.push_back(std::exchange(word, {}));
      } else {
        word += c;
      }
    }
    if (!word.empty()) words.push_back(word);
    const auto before = [&](std::string_view label) -> std::optional<double> {
      const auto it = std::find(words.begin(), words.end(), label);
      return it == words.end() || it == words.begin() ? std::nullopt : parse_number(*(it - 1));
    };
    const auto latitude = before("Lat"), longitude = before("Lon"), height = before("Ellh");
    const auto ellh = std::find(words.begin(), words.end(), "Ellh");
    if (!latitude || !longitude || !height || words.end() - ellh < 4) continue;
    const auto index = parse_number(words[0]), second = parse_number(words[1]),
               week = parse_number(words[2]);
    const auto north = parse_number(ellh[1]), east = parse_number(ellh[2]),
               up = parse_number(ellh[3]);
    if (!index || !second || !week || !north || !east || !up) continue;
    if (std::abs(*latitude) > 90 || std::abs(*longitude) > 360 || *index < 0 || *index > 1e6)
      continue;
    RtkMark mark;
    mark.index = static_cast<int>(*index);
    mark.latitude = Angle::degrees(*latitude);
    mark.longitude = Angle::degrees(*longitude);
    mark.height_ellipsoid_m = *height;
    mark.sigma_north_m = std::max(0.0, *north);
    mark.sigma_east_m = std::max(0.0, *east);
    mark.sigma_height_m = std::max(0.0, *up);
    if (*week >= 0 && *week < 10'000 && *second >= 0 && *second <= 604'800) {
      constexpr std::chrono::sys_days kGpsEpoch{std::chrono::year{1980} / 1 / 6};
      mark.utc = Time(kGpsEpoch) + std::chrono::hours(168) * static_cast<int>(*week) +
                 seconds(*second) - kGpsMinusUtc;
    }
    marks.push_back(mark);
  }
  return marks;
}

Result<RecordedFlight> read_photo_flight(const fs::path& folder, const ReadOptions& options,
                                         const Progress& progress) {
  WATERSKY_TRY(detail::PhotoSet set, detail::read_photo_set(folder, progress));
  std::vector<std::string> notes;
  WATERSKY_TRY(Intrinsics intrinsics,
               detail::choose_intrinsics(folder, set.photos.front(), options, notes));

  std::vector<LeftOut> left_out = std::move(set.left_out);
  std::vector<const PhotoFile*> photos;
  for (const PhotoFile& photo : set.photos) {
    if (photo.metadata.latitude)
      photos.push_back(&photo);
    else
      left_out.push_back({photo.path.filename().string(), "it records no position"});
  }
  if (photos.empty())
    return Error{ErrorCode::NotFound,
                 folder.string() + ": none of its " +
                     detail::counted(set.photos.size(), "photograph") +
                     " records a position; give the autopilot's log (--log FILE)"};
  // By the camera's clock where all have it: file numbers wrap from 9999 to 1.
  const auto timed = [](const PhotoFile* p) { return p->metadata.taken_local.has_value(); };
  if (std::all_of(photos.begin(), photos.end(), timed))
    std::stable_sort(photos.begin(), photos.end(), [](const PhotoFile* a, const PhotoFile* b) {
      return *a->metadata.taken_local < *b->metadata.taken_local;
    });

  WATERSKY_TRY(const Heights heights, Heights::make(photos, notes));
  WATERSKY_TRY(const std::vector<RtkMark> marks, read_marks(folder));
  const auto has_gimbal = [](const PhotoFile* p) { return p->metadata.gimbal.has_value(); };
  const auto has_flight = [](const PhotoFile* p) { return p->metadata.flight.has_value(); };
  // With neither anywhere, what is assumed (straight down) is an attitude against the ground too.
  const bool by_gimbal = std::any_of(photos.begin(), photos.end(), has_gimbal) ||
                         std::none_of(photos.begin(), photos.end(), has_flight);

  std::vector<Geodetic> places;
  std::vector<const PhotoFile*> placed;
  for (const PhotoFile* photo : photos) {
    const PhotoMetadata& m = photo->metadata;
    const auto height = heights.ellipsoidal_m(m);
    if (!height && height.error().code != ErrorCode::OutOfRange) return height.error();
    if (!height) {
      left_out.push_back({photo->path.filename().string(), height.error().message});
      continue;
    }
    places.push_back({*m.latitude, *m.longitude, *height});
    placed.push_back(photo);
  }
  if (placed.empty())
    return Error{ErrorCode::NotFound, folder.string() + ": its photographs record no height"};

  Flight flight(resolved(folder).filename().string(), Datum(places.front()), intrinsics.camera);
  flight.calibration = intrinsics.source;
  flight.delay_s = options.delay_s;
  if (by_gimbal) {
    flight.gimbal_reference = GimbalReference::NorthEastDown;
    flight.mount.rotation = camera_rotation(options.mount.value_or(YawPitchRoll{}));
    if (options.mount) notes.emplace_back(detail::kMountOnGimbalNote);
  } else {
    flight.mount.rotation =
        camera_rotation(options.mount.value_or(YawPitchRoll{{}, Angle::degrees(-90), {}}));
    flight.mount.assumed = !options.mount;
    if (flight.mount.assumed) notes.emplace_back(detail::kAssumedMountNote);
  }

  const ImageSize size{intrinsics.camera.width_px(), intrinsics.camera.height_px()};
  std::size_t assumed = 0, local_times = 0, timeless = 0, marked = 0, ellipsoidal = 0;
  double assumed_heading_sigma_deg = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const PhotoMetadata& m = placed[i]->metadata;
    const std::string name = placed[i]->path.filename().string();
    std::optional<PoseSigma> sigma;
    if (m.rtk_sigma_north_m && m.rtk_sigma_east_m && m.rtk_sigma_height_m)
      sigma = PoseSigma{{*m.rtk_sigma_north_m, *m.rtk_sigma_east_m, *m.rtk_sigma_height_m},
                        Eigen::Vector3d::Zero()};
    const RtkMark* mark = mark_of(marks, *placed[i], places[i]);
    if (mark) {
      ++marked;
      sigma = PoseSigma{{mark->sigma_north_m, mark->sigma_east_m, mark->sigma_height_m},
                        Eigen::Vector3d::Zero()};
    }

    std::optional<YawPitchRoll> attitude = by_gimbal ? m.gimbal : m.flight;
    if (!attitude) {
      if (!options.assume_nadir) {
        left_out.push_back({name, by_gimbal && m.flight
                                      ? "it records no gimbal attitude, unlike others of the flight"
                                      : "it records a position but no attitude (--assume-nadir "
                                        "takes it as looking straight down)"});
        continue;
      }
      const auto heading = assumed_heading(placed, places, i);
      if (!heading) {
        left_out.push_back(
            {name, "it records no attitude and its heading cannot be told from the track"});
        continue;
      }
      attitude = YawPitchRoll{heading->azimuth, Angle::degrees(by_gimbal ? -90 : 0), {}};
      if (!sigma) sigma.emplace();
      sigma->roll_pitch_yaw_rad = {Angle::degrees(kAssumedTilt_deg).radians(),
                                   Angle::degrees(kAssumedTilt_deg).radians(),
                                   Angle::degrees(heading->sigma_deg).radians()};
      assumed_heading_sigma_deg = std::max(assumed_heading_sigma_deg, heading->sigma_deg);
      ++assumed;
    }

    ImageFrame frame;
    frame.name = name;
    frame.load = image_loader(placed[i]->path, size);
    frame.file = placed[i]->path;
    frame.captured_at = mark && mark->utc ? mark->utc : m.utc();
    if (!frame.captured_at && m.taken_local) {
      const double offset_h = options.camera_utc_offset_h.value_or(0.0);
      frame.captured_at = *m.taken_local - seconds(offset_h * 3600);
      if (!options.camera_utc_offset_h) ++local_times;
    }
    if (!frame.captured_at) ++timeless;
    const Eigen::Quaterniond world_from_ned = flight.datum.world_from_ned_rotation(places[i]);
    const YawPitchRoll body = by_gimbal ? m.flight.value_or(YawPitchRoll{}) : *attitude;
    frame.own_pose =
        StampedPose{frame.captured_at.value_or(Time{}),
                    {world_from_ned * rotation_from(body), flight.datum.world(places[i])},
                    sigma};
    if (by_gimbal) frame.own_gimbal = rotation_from(*attitude);
    if (m.altitude_is_ellipsoidal) ++ellipsoidal;
    flight.frames.push_back(std::move(frame));
  }

  flight.times_are_utc = local_times == 0 && timeless == 0;
  if (timeless > 0)
    notes.push_back(detail::counted(timeless, "photograph") +
                    " without any recorded time: 0 stands where a time should, and says nothing");
  if (local_times > 0)
    notes.push_back(
        "the photographs' clock names no time zone: times are the camera's own, not UTC");
  if (assumed > 0)
    notes.push_back(detail::counted(assumed, "photograph") +
                    " without attitude taken as looking straight down: " +
                    format_number(kAssumedTilt_deg) + "° of roll and pitch, up to " +
                    format_number(assumed_heading_sigma_deg) + "° of heading (one sigma)");
  if (marked > 0)
    notes.push_back("RTK marks (.MRK) gave the sigmas of " + detail::counted(marked, "photograph"));
  if (ellipsoidal > 0)
    notes.push_back("RTK altitudes of " + detail::counted(ellipsoidal, "photograph") +
                    " count as heights above the ellipsoid");
  flight.left_out = std::move(left_out);
  for (std::string& note : notes) flight.notes.push_back(std::move(note));
  return RecordedFlight{std::move(flight), heights.takeoff()};
}

}  // namespace watersky
