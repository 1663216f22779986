// SPDX-License-Identifier: MIT
#include "watersky/io/message_flight.hpp"

#include <algorithm>
#include <cmath>

#include "watersky/io/csv.hpp"
#include "watersky/io/detail/mcap_flight_read.hpp"
#include "watersky/io/detail/message_content.hpp"
#include "watersky/io/detail/photos.hpp"
#include "watersky/io/detail/ros_frames.hpp"
#include "watersky/io/files.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::MessageChannel;
using detail::MessageContent;
using detail::MessageFile;

struct ImageSource {
  const MessageChannel* channel;
  const std::vector<detail::RecordedImage>* images;
};

Result<ImageSource> choose_images(const MessageFile& file, const MessageContent& content,
                                  const ReadOptions& options) {
  std::vector<ImageSource> found;
  std::string names;
  for (const MessageChannel& c : file.channels()) {
    const auto at = content.images.find(c.id);
    if (at == content.images.end() || at->second.empty() || !detail::is_image_channel(c)) continue;
    if (options.image_topic && c.topic != *options.image_topic) {
      names += (names.empty() ? "" : ", ") + c.topic;
      continue;
    }
    names += (names.empty() ? "" : ", ") + c.topic;
    found.push_back({&c, &at->second});
  }
  const std::string place = file.path().string() + ": ";
  if (found.empty())
    return Error{ErrorCode::NotFound,
                 place + (names.empty() ? "holds no images that are read (sensor_msgs Image or "
                                          "CompressedImage, foxglove CompressedImage or RawImage)"
                                        : "holds no images on " + *options.image_topic +
                                              "; there are " + names)};
  if (found.size() > 1)
    return Error{ErrorCode::InvalidInput,
                 place + "holds images on " + names + "; say which with --image-topic TOPIC"};
  return found.front();
}

/// "/camera/image_raw/compressed" → "/camera/".
std::string topic_folder(std::string topic) {
  if (topic.ends_with("/compressed")) topic.resize(topic.size() - 11);
  const auto slash = topic.rfind('/');
  return slash == std::string::npos ? "" : topic.substr(0, slash + 1);
}

Result<Intrinsics> choose_lens(const MessageFile& file, const MessageContent& content,
                               const std::string& image_topic, const ImageSize& size,
                               const ReadOptions& options, std::vector<std::string>& notes) {
  const std::string name = file.path().filename().string();
  if (!options.camera_file && !options.focal_px) {
    const std::pair<const std::string, CameraModel>* camera = nullptr;
    std::size_t beside = 0;
    for (const auto& entry : content.cameras)
      if (topic_folder(entry.first) == topic_folder(image_topic)) {
        ++beside;
        camera = &entry;
      }
    if (beside == 0 && content.cameras.size() == 1) camera = &*content.cameras.begin();
    if (beside <= 1 && camera) {
      WATERSKY_TRY(const CameraModel fitted,
                   detail::fitted_to(camera->second, size.width_px, size.height_px, camera->first,
                                     name, notes));
      return Intrinsics{fitted, {camera->first, 0.0}};
    }
  }
  return detail::choose_intrinsics(resolved(file.path()).parent_path(), name, size.width_px,
                                   size.height_px, options, notes);
}

/// The body in a map that is east, north, up, and the camera on the body.
struct Motion {
  std::vector<detail::StampedMotion> enu_from_flu;
  std::optional<detail::RigidMotion> flu_from_camera;
  std::string source;
};

Result<Motion> chain_motion(const MessageContent& content, const std::string& image_frame,
                            const ReadOptions& options) {
  const std::string asked = detail::plain_frame(options.camera_frame.value_or(image_frame));
  const bool known = !asked.empty() && content.tree.has(asked);
  if (options.camera_frame && !known)
    return Error{ErrorCode::NotFound, "there is no frame " + asked +
                                          "; the recording's frames are: " + content.tree.names()};
  const std::string start = known ? asked : content.tree.only_moving();
  if (start.empty())
    return Error{ErrorCode::NotFound, "the images' frame \"" + asked +
                                          "\" is none of those that transforms tell of (" +
                                          content.tree.names() +
                                          "); say which is the camera's with --camera-frame FRAME"};
  WATERSKY_TRY(auto chain,
               content.tree.chain(start, detail::plain_frame(options.map_frame.value_or(""))));
  Motion out;
  out.enu_from_flu = std::move(chain.root_from_body);
  if (known) out.flu_from_camera = chain.body_from_start;
  out.source =
      "poses are of " + chain.body + " in " + chain.root +
      (known ? ", the camera's frame is " + start : "; the camera is no frame of the recording");
  return out;
}

/// Where World stands so that the body's positions are those that the fixes tell.
Result<Datum> fit_datum(const std::vector<detail::RecordedFix>& fixes, const Trajectory& in_world,
                        std::vector<std::string>& notes) {
  constexpr auto kMaxGap = std::chrono::seconds(2);
  std::vector<std::pair<Geodetic, Eigen::Vector3d>> pairs;
  for (const auto& fix : fixes)
    if (const auto pose = in_world.at(fix.time, kMaxGap))
      pairs.emplace_back(fix.place, pose->world_from_body.origin().v);
  if (pairs.empty())
    return Error{ErrorCode::NotFound,
                 "no NavSatFix lies between poses in time, so the map's place "
                 "is not known; give --datum LAT,LON,HEIGHT"};
  Datum datum(pairs.front().first);
  double spread_m = 0.0;
  // Axes turn with the place (1 m a kilometre in the Arctic): each pass leaves that fraction.
  for (int pass = 0; pass < 8; ++pass) {
    std::array<std::vector<double>, 3> off;
    for (const auto& [place, p] : pairs) {
      const Eigen::Vector3d d = datum.world(place).v - p;
      for (int k = 0; k < 3; ++k) off[static_cast<std::size_t>(k)].push_back(d[k]);
    }
    Eigen::Vector3d median;
    for (std::size_t k = 0; k < 3; ++k) {
      std::nth_element(off[k].begin(),
                       off[k].begin() + static_cast<std::ptrdiff_t>(off[k].size() / 2),
                       off[k].end());
      median[static_cast<Eigen::Index>(k)] = off[k][off[k].size() / 2];
    }
    datum = Datum(datum.geodetic(Point<World>{median}));
  }
  for (const auto& [place, p] : pairs)
    spread_m = std::max(spread_m, (datum.world(place).v - p).head<2>().norm());
  char text[200];
  std::snprintf(text, sizeof text,
                "the map stands where %zu fixes say; they and the poses differ by %.1f m at most",
                pairs.size(), spread_m);
  notes.emplace_back(text);
  if (spread_m > 30.0)
    notes.emplace_back(
        "so much that the map frame may not be east, north, up: its heading would then be wrong");
  return datum;
}

Trajectory in_world(const std::vector<detail::StampedMotion>& motions) {
  std::vector<StampedPose> poses;
  poses.reserve(motions.size());
  for (const auto& [time, m] : motions)
    poses.push_back({time,
                     Rigid3<World, Body>(detail::ned_from_enu_rotation() * m.rotation *
                                             detail::frd_from_flu_rotation(),
                                         Point<World>{detail::ned_from_enu(m.translation_m)}),
                     {},
                     {}});
  auto made = Trajectory::make(std::move(poses));
  return made ? std::move(*made) : Trajectory();
}

/// Positions of fixes, between those around each attitude.
Result<Trajectory> fix_trajectory(const MessageContent& content, const Datum& datum) {
  constexpr auto kMaxGap = std::chrono::seconds(2);
  std::vector<StampedPose> positions;
  for (const auto& fix : content.fixes)
    positions.push_back(
        {fix.time,
         Rigid3<World, Body>(Eigen::Quaterniond::Identity(), datum.world(fix.place)),
         {},
         {}});
  WATERSKY_TRY(const Trajectory track, Trajectory::make(std::move(positions)));
  std::vector<StampedPose> poses;
  for (const auto& attitude : content.attitudes) {
    const auto position = track.at(attitude.time, kMaxGap);
    if (!position) continue;
    const Point<World> p = position->world_from_body.origin();
    poses.push_back(
        {attitude.time,
         Rigid3<World, Body>(datum.world_from_ned_rotation(datum.geodetic(p)) *
                                 detail::ned_from_enu_rotation() * attitude.enu_from_flu *
                                 detail::frd_from_flu_rotation(),
                             p),
         {},
         {}});
  }
  return Trajectory::make(std::move(poses));
}

void set_mount(Flight& flight, const std::optional<detail::RigidMotion>& flu_from_camera,
               const ReadOptions& options) {
  if (flu_from_camera) {
    flight.mount.rotation = detail::frd_from_flu_rotation() * flu_from_camera->rotation;
    flight.mount.lever_arm_m = detail::frd_from_flu(flu_from_camera->translation_m);
  }
  if (options.mount || !flu_from_camera) {
    flight.mount.rotation =
        camera_rotation(options.mount.value_or(YawPitchRoll{{}, Angle::degrees(-90), {}}));
    flight.mount.assumed = !options.mount;
    if (flight.mount.assumed) flight.notes.emplace_back(detail::kAssumedMountNote);
  }
}

std::vector<ImageFrame> frames_of(const std::shared_ptr<const MessageFile>& file,
                                  const ImageSource& source, const ImageSize& size,
                                  const ReadOptions& options) {
  std::vector<ImageFrame> frames;
  const MessageChannel channel = *source.channel;
  for (std::size_t i = 0; i < source.images->size(); ++i) {
    const detail::RecordedImage& image = (*source.images)[i];
    ImageFrame frame;
    frame.name = file->path().filename().string() + "#" + std::to_string(i);
    (options.delay_s ? frame.received_at : frame.captured_at) = image.stamp;
    if (!image.stamp) frame.received_at = image.log_time;
    if (image.sequence != 0) frame.counter = image.sequence;
    detail::set_image(frame, file, channel, image.where, size);
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

bool is_message_recording(const fs::path& file) { return detail::is_message_file(file); }

Result<RecordedFlight> read_message_flight(const fs::path& path, const ReadOptions& options,
                                           const Progress& progress) {
  if (options.log)
    return Error{ErrorCode::Usage, path.string() + ": has its poses; --log does not go with it"};
  WATERSKY_TRY(const auto file, MessageFile::open(path));
  if (file->mcap() && detail::is_flight_of_ours(*file)) {
    WATERSKY_TRY(Flight flight, detail::read_mcap_flight(file, options, progress));
    return RecordedFlight{std::move(flight), std::nullopt};
  }
  const auto here = [&](const Error& e) { return e.at(path.string()); };
  WATERSKY_TRY(const MessageContent content, detail::read_content(*file, progress));
  WATERSKY_TRY(const ImageSource source, choose_images(*file, content, options));
  std::vector<std::string> notes = content.notes;

  // The first image that can be decoded tells the size; the others are held to it.
  std::optional<ImageSize> size;
  std::string why;
  for (const detail::RecordedImage& image : *source.images) {
    const auto data = file->read(image.where);
    const auto decoded = data ? detail::decode_image_message(
                                    *source.channel, *data, {.color = false}, source.channel->topic)
                              : Result<cv::Mat>(data.error());
    if (decoded) {
      size = ImageSize{decoded->cols, decoded->rows};
      break;
    }
    if (why.empty()) why = decoded.error().message;
  }
  if (!size) return here({ErrorCode::InvalidInput, "no image can be decoded: " + why});
  WATERSKY_TRY(Intrinsics lens,
               choose_lens(*file, content, source.channel->topic, *size, options, notes));

  std::optional<Motion> motion;
  if (!content.tree.empty()) {
    auto chain = chain_motion(content, source.images->front().frame_id, options);
    if (chain)
      motion = std::move(*chain);
    else if (content.fixes.empty() || content.attitudes.empty() || options.camera_frame ||
             options.map_frame)
      return here(chain.error());
    else
      notes.push_back("transforms were not used: " + chain.error().message);
  }
  if (!motion && (content.fixes.empty() || content.attitudes.empty()))
    return here({ErrorCode::NotFound,
                 "says not where it was seen from: there are neither transforms (/tf), odometry or "
                 "poses, nor NavSatFix with Imu"});

  std::optional<Datum> datum;
  if (options.datum) datum.emplace(*options.datum);
  Trajectory trajectory;
  if (motion) {
    trajectory = in_world(motion->enu_from_flu);
    notes.push_back(motion->source);
    if (!datum) {
      const auto fitted = fit_datum(content.fixes, trajectory, notes);
      if (!fitted) return here(fitted.error());
      datum = *fitted;
    }
  } else {
    if (!datum) datum.emplace(content.fixes.front().place);
    auto made = fix_trajectory(content, *datum);
    if (!made) return here(made.error());
    trajectory = std::move(*made);
    if (trajectory.empty())
      return here(
          {ErrorCode::NotFound, "NavSatFix and Imu never overlap in time, so there is no pose"});
    notes.emplace_back("positions are NavSatFix's, attitudes Imu's");
  }
  Flight flight(resolved(path).filename().string(), *datum, lens.camera);
  flight.calibration = lens.source;
  flight.notes = std::move(notes);
  flight.trajectory = std::move(trajectory);
  flight.delay_s = options.delay_s;
  flight.ranges = content.ranges;
  set_mount(flight, motion ? motion->flu_from_camera : std::nullopt, options);
  flight.frames = frames_of(file, source, *size, options);
  std::stable_sort(
      flight.frames.begin(), flight.frames.end(), [](const ImageFrame& a, const ImageFrame& b) {
        return std::max(a.captured_at, a.received_at) < std::max(b.captured_at, b.received_at);
      });
  return RecordedFlight{std::move(flight), std::nullopt};
}

}  // namespace watersky
