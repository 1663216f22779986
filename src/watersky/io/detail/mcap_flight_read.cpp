// SPDX-License-Identifier: MIT
#include "watersky/io/detail/mcap_flight_read.hpp"

#include <algorithm>
#include <map>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/io/camera_table.hpp"
#include "watersky/io/detail/flight_description.hpp"
#include "watersky/io/detail/message_content.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/known_points_file.hpp"
#include "watersky/wire/protobuf.hpp"

namespace watersky::detail {

namespace {

/// An attachment's text; nullopt when there is none of that name.
Result<std::optional<std::string>> attached(const mcap::Reader& reader, const std::string& name) {
  for (const mcap::AttachmentIndex& index : reader.attachments()) {
    if (index.name != name) continue;
    WATERSKY_TRY(const mcap::Attachment attachment, reader.read(index));
    return std::optional(std::string(attachment.data.begin(), attachment.data.end()));
  }
  return std::optional<std::string>();
}

Eigen::Quaterniond quaternion_of(const foxglove::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

Result<StampedPose> pose_of(const recording::Pose& p) {
  const Eigen::Quaterniond q = quaternion_of(p.rotation);
  if (!(std::abs(q.norm() - 1.0) < 1e-3))
    return Error{ErrorCode::InvalidInput, "a pose's rotation is none"};
  StampedPose out;
  out.time = p.timestamp;
  out.world_from_body =
      Rigid3<World, Body>(q, Point<World>{{p.position.x, p.position.y, p.position.z}});
  if (p.sigma.size() == 6)
    out.sigma =
        PoseSigma{{p.sigma[0], p.sigma[1], p.sigma[2]}, {p.sigma[3], p.sigma[4], p.sigma[5]}};
  if (p.covariance.size() == 36) {
    out.covariance.emplace();
    for (Eigen::Index i = 0; i < 36; ++i)
      (*out.covariance)(i / 6, i % 6) = p.covariance[static_cast<std::size_t>(i)];
  }
  return out;
}

/// What the messages of a recording of ours say.
struct Messages {
  std::vector<StampedPose> poses;
  std::vector<StampedRotation> gimbal;
  std::vector<RangeSample> ranges;
  std::vector<std::pair<std::uint32_t, recording::Frame>> frames;  ///< by sequence, in order
  std::map<std::uint32_t, mcap::Location> images;                  ///< by sequence
  const MessageChannel* image_channel = nullptr;
  std::vector<std::string> notes;
};

Status use(const RecordedMessage& m, Messages& out) {
  const std::string& type = m.channel.type;
  if (type == "watersky.Pose") {
    WATERSKY_TRY(const auto x, protobuf::decode<recording::Pose>(m.data));
    WATERSKY_TRY(StampedPose pose, pose_of(x));
    out.poses.push_back(std::move(pose));
  } else if (type == "watersky.Gimbal") {
    WATERSKY_TRY(const auto x, protobuf::decode<recording::Gimbal>(m.data));
    out.gimbal.push_back({x.timestamp, quaternion_of(x.rotation)});
  } else if (type == "watersky.Range") {
    WATERSKY_TRY(const auto x, protobuf::decode<recording::Range>(m.data));
    out.ranges.push_back({x.timestamp, x.range, x.sigma});
  } else if (type == "watersky.Frame") {
    WATERSKY_TRY(auto x, protobuf::decode<recording::Frame>(m.data));
    out.frames.emplace_back(m.sequence, std::move(x));
  } else {
    out.images.insert_or_assign(m.sequence, m.where);
    out.image_channel = &m.channel;
  }
  return {};
}

Result<Messages> read_messages(const MessageFile& file, const Progress& progress) {
  std::set<std::uint32_t> channels;
  for (const MessageChannel& c : file.channels())
    if (c.type.starts_with("watersky.") || c.topic == kImageTopic) channels.insert(c.id);
  Messages out;
  out.notes = file.notes();
  std::size_t n = 0, bad = 0;
  WATERSKY_TRY(const auto damage,
               file.for_each(
                   [&](const RecordedMessage& m) {
                     if (n++ % 256 == 0) report(progress, "reading messages", n, 0);
                     const Status used = use(m, out);
                     if (!used && bad++ == 0)
                       out.notes.push_back(used.error().at(m.channel.topic).message);
                   },
                   channels));
  report(progress, "reading messages", n, n);
  add_new_notes(out.notes, damage);
  return out;
}

}  // namespace

bool is_flight_of_ours(const MessageFile& file) {
  const mcap::Reader* reader = file.mcap();
  return reader &&
         std::any_of(reader->attachments().begin(), reader->attachments().end(),
                     [](const mcap::AttachmentIndex& a) { return a.name == kFlightYaml; });
}

void set_image(ImageFrame& frame, const std::shared_ptr<const MessageFile>& file,
               const MessageChannel& channel, const mcap::Location& where,
               const std::optional<ImageSize>& expected) {
  const std::string name = frame.name;
  frame.load = [file, channel, where, expected,
                name](const ImageRequest& request) -> Result<cv::Mat> {
    WATERSKY_TRY(const auto data, file->read(where));
    WATERSKY_TRY(cv::Mat image, decode_image_message(channel, data, request, name));
    if (expected) WATERSKY_CHECK(check_image_size(image, request, *expected, name));
    return image;
  };
  if (!channel.type.ends_with("CompressedImage")) return;
  frame.encoded = [file, channel, where, name]() -> Result<EncodedImage> {
    WATERSKY_TRY(const auto data, file->read(where));
    WATERSKY_TRY(auto encoded, encoded_of(channel, data, name));
    if (!encoded) return Error{ErrorCode::NotFound, name + ": is not compressed"};
    return std::move(*encoded);
  };
}

Result<Flight> read_mcap_flight(const std::shared_ptr<const MessageFile>& file,
                                const ReadOptions& options, const Progress& progress) {
  const mcap::Reader& reader = *file->mcap();
  const auto here = [&](const Error& e) { return e.at(file->path().string()); };
  if (options.camera_file && options.focal_px)
    return Error{ErrorCode::Usage, "--camera and --focal-px exclude each other; give one"};
  auto yaml = attached(reader, kFlightYaml);
  if (!yaml) return here(yaml.error());
  const auto description = parse_flight_yaml(yaml->value_or(""), kFlightYaml);
  if (!description) return here(description.error());
  if (!description->datum) return here({ErrorCode::NotFound, "its flight.yaml names no datum"});

  std::vector<std::string> notes;
  const auto camera = [&]() -> Result<CameraModel> {
    if (options.camera_file) return read_calibration(*options.camera_file);
    WATERSKY_TRY(const auto text, attached(reader, kCameraYaml));
    if (!text) return Error{ErrorCode::NotFound, "holds no camera.yaml; give --camera FILE"};
    WATERSKY_TRY(const CameraModel own, parse_calibration(*text, kCameraYaml));
    if (!options.focal_px) return own;
    WATERSKY_TRY(const Intrinsics given,
                 intrinsics_from_focal_px(*options.focal_px, own.width_px(), own.height_px()));
    return given.camera;
  }();
  if (!camera) return here(camera.error());
  WATERSKY_TRY(
      Flight flight,
      described_flight(*description, resolved(file->path()).filename().string(),
                       Datum(*description->datum, description->datum_x_azimuth), *camera, options));
  WATERSKY_TRY(Messages messages, read_messages(*file, progress));
  flight.notes.insert(flight.notes.end(), messages.notes.begin(), messages.notes.end());
  auto trajectory = Trajectory::make(std::move(messages.poses));
  if (!trajectory) return here(trajectory.error());
  flight.trajectory = std::move(*trajectory);
  auto gimbal = RotationTrack::make(std::move(messages.gimbal));
  if (!gimbal) return here(gimbal.error());
  flight.gimbal = std::move(*gimbal);
  flight.ranges = std::move(messages.ranges);

  const ImageSize size{flight.camera.width_px(), flight.camera.height_px()};
  for (const auto& [sequence, f] : messages.frames) {
    const auto image = messages.images.find(sequence);
    if (image == messages.images.end()) {
      flight.left_out.push_back({f.name, "its image is not in the recording"});
      continue;
    }
    ImageFrame frame;
    frame.name = f.name;
    frame.captured_at = f.captured_at;
    frame.received_at = f.received_at;
    if (f.has_counter) frame.counter = f.counter;
    if (f.own_pose) {
      auto own = pose_of(*f.own_pose);
      if (!own) return here(own.error());
      frame.own_pose = std::move(*own);
    }
    if (f.own_gimbal) frame.own_gimbal = quaternion_of(*f.own_gimbal);
    set_image(frame, file, *messages.image_channel, image->second, size);
    flight.frames.push_back(std::move(frame));
  }
  for (const mcap::MetadataIndex& index : reader.metadata()) {
    if (index.name != kLeftOutMetadata) continue;
    const auto left_out = reader.read(index);
    if (!left_out) return here(left_out.error());
    for (const auto& [name, reason] : left_out->values) flight.left_out.push_back({name, reason});
  }
  WATERSKY_TRY(const auto anchors, attached(reader, kAnchorsFile));
  WATERSKY_TRY(const auto tracks, attached(reader, kAnchorTracksFile));
  if (anchors && !options.anchors_file) {
    auto parsed = parse_anchors_csv(*anchors, kAnchorsFile, flight.notes);
    if (!parsed) return here(parsed.error());
    flight.anchors = std::move(*parsed);
    if (tracks)
      if (const Status added =
              parse_anchor_tracks_csv(*tracks, kAnchorTracksFile, flight.anchors, flight.notes);
          !added)
        return here(added.error());
  }
  return flight;
}

}  // namespace watersky::detail
