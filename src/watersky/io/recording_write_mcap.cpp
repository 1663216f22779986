// SPDX-License-Identifier: MIT
#include "watersky/io/recording_write.hpp"

#include <optional>

#include "watersky/camera/calibration_file.hpp"
#include "watersky/io/detail/flight_description.hpp"
#include "watersky/io/detail/mcap_flight_read.hpp"
#include "watersky/io/detail/timeline.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/known_points_file.hpp"
#include "watersky/wire/mcap_writer.hpp"
#include "watersky/wire/protobuf.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::RigidMotion;

foxglove::Vector3 vector_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
foxglove::Quaternion quaternion_of(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

recording::Pose recorded(const StampedPose& pose) {
  recording::Pose out{pose.time,
                      vector_of(pose.world_from_body.origin().v),
                      quaternion_of(pose.world_from_body.rotation()),
                      {},
                      {}};
  if (pose.sigma) {
    const Eigen::Vector3d &p = pose.sigma->position_north_east_down_m,
                          &a = pose.sigma->roll_pitch_yaw_rad;
    out.sigma = {p.x(), p.y(), p.z(), a.x(), a.y(), a.z()};
  }
  if (pose.covariance)
    for (Eigen::Index i = 0; i < 36; ++i)
      out.covariance.push_back((*pose.covariance)(i / 6, i % 6));
  return out;
}

class FlightWriter {
 public:
  FlightWriter(const Flight& flight, const WriteRecordingOptions& options, mcap::Writer& writer)
      : flight_(flight), options_(options), writer_(writer) {}

  Result<std::vector<LeftOut>> write(const Progress& progress) {
    WATERSKY_CHECK(attach_description());
    WATERSKY_CHECK(detail::for_timeline(
        flight_, {[&](const StampedPose& p) { return pose(p); },
                  [&](const StampedRotation& g) { return gimbal(g); },
                  [&](const RangeSample& r) {
                    return put(range_, "/watersky/range", r.time, r.time, 0,
                               recording::Range{r.time, r.range_m, r.sigma_m});
                  },
                  [&](std::size_t i, Time time) {
                    report(progress, "writing images", i, flight_.frames.size());
                    return frame(i, time);
                  }}));
    report(progress, "writing images", flight_.frames.size(), flight_.frames.size());
    mcap::Metadata left_out{detail::kLeftOutMetadata, {}};
    for (const LeftOut& l : flight_.left_out) left_out.values[l.file] = l.reason;
    for (const LeftOut& l : left_out_) left_out.values[l.file] = l.reason;
    if (!left_out.values.empty()) WATERSKY_CHECK(writer_.add_metadata(left_out));
    return left_out_;
  }

 private:
  template <class M>
  Status put(std::optional<std::uint16_t>& channel, const char* topic, Time log_time,
             Time publish_time, std::uint32_t sequence, const M& message) {
    if (!channel) {
      const protobuf::Schema schema = protobuf::schema<M>();
      WATERSKY_TRY(const std::uint16_t id,
                   writer_.add_schema({0, schema.name, "protobuf", schema.descriptors}));
      WATERSKY_TRY(const std::uint16_t added, writer_.add_channel({0, id, topic, "protobuf", {}}));
      channel = added;
    }
    const auto bytes = protobuf::encode(message);
    return writer_.write({*channel, sequence, log_time, publish_time, bytes});
  }

  Status attach(const char* name, const char* media_type, const std::string& text) {
    return writer_.attach({name, media_type, {}, {}, {text.begin(), text.end()}});
  }

  Status attach_description() {
    WATERSKY_TRY(const std::string yaml, detail::flight_yaml(flight_));
    WATERSKY_CHECK(attach(detail::kFlightYaml, "application/yaml", yaml));
    WATERSKY_CHECK(
        attach(detail::kCameraYaml, "application/yaml", format_calibration(flight_.camera)));
    if (flight_.anchors.empty()) return {};
    WATERSKY_CHECK(attach(kAnchorsFile, "text/csv",
                          format_anchors_csv(flight_.anchors, [](const std::string& f) {
                            return std::optional(f);
                          })));
    const std::string tracks = format_anchor_tracks_csv(flight_.anchors);
    return tracks.empty() ? Status() : attach(kAnchorTracksFile, "text/csv", tracks);
  }

  Status transform(Time time, const char* parent, const char* child, const RigidMotion& m) {
    return put(tf_, "/tf", time, time, 0,
               foxglove::FrameTransform{time, parent, child, vector_of(m.translation_m),
                                        quaternion_of(m.rotation)});
  }

  /// What shows a pose; the camera's place on its platform stands before the first.
  Status show(Time time, const Rigid3<World, Body>& pose) {
    if (!mount_shown_) {
      mount_shown_ = true;
      WATERSKY_CHECK(transform(time,
                               flight_.gimbal_reference ? detail::kGimbalFrame : detail::kBodyFrame,
                               detail::kCameraFrame, detail::platform_from_camera(flight_)));
    }
    WATERSKY_CHECK(transform(time, detail::kMapFrame, detail::kBodyFrame,
                             detail::map_from_base(flight_, pose)));
    const Geodetic g = flight_.datum.geodetic(pose.origin());
    foxglove::LocationFix fix;
    fix.timestamp = time;
    fix.frame_id = detail::kBodyFrame;
    fix.latitude = g.latitude.degrees();
    fix.longitude = g.longitude.degrees();
    fix.altitude = g.height_ellipsoid_m;
    return put(fix_, "/fix", time, time, 0, fix);
  }

  Status pose(const StampedPose& p) {
    WATERSKY_CHECK(put(pose_, "/watersky/pose", p.time, p.time, 0, recorded(p)));
    return show(p.time, p.world_from_body);
  }

  Status gimbal(const StampedRotation& g) {
    WATERSKY_CHECK(put(gimbal_, "/watersky/gimbal", g.time, g.time, 0,
                       recording::Gimbal{g.time, quaternion_of(g.rotation)}));
    return show_gimbal(g, std::nullopt);
  }

  Status show_gimbal(const StampedRotation& g, const std::optional<StampedPose>& own) {
    const auto motion = detail::base_from_gimbal(flight_, g, own);
    return motion ? transform(g.time, detail::kBodyFrame, detail::kGimbalFrame, *motion) : Status();
  }

  Status frame(std::size_t i, Time time) {
    const ImageFrame& f = flight_.frames[i];
    const auto image = detail::image_bytes(f, options_);
    if (!image) {
      left_out_.push_back({f.name, image.error().message});
      return {};
    }
    recording::Frame told;
    told.name = f.name;
    told.captured_at = f.captured_at;
    told.received_at = f.received_at;
    told.has_counter = f.counter.has_value();
    told.counter = f.counter.value_or(0);
    if (f.own_pose) {
      told.own_pose = recorded(*f.own_pose);
      WATERSKY_CHECK(show(time, f.own_pose->world_from_body));
    }
    if (f.own_gimbal) {
      told.own_gimbal = quaternion_of(*f.own_gimbal);
      WATERSKY_CHECK(show_gimbal({time, *f.own_gimbal}, f.own_pose));
    }
    const auto sequence = static_cast<std::uint32_t>(i);
    WATERSKY_CHECK(put(frame_, "/watersky/frame", time, time, sequence, told));
    WATERSKY_CHECK(put(camera_, "/camera/calibration", time, time, sequence, calibration(time)));
    return put(image_, detail::kImageTopic, time, time, sequence,
               foxglove::CompressedImage{time, detail::kCameraFrame, image->bytes,
                                         image->extension == ".png" ? "png" : "jpeg"});
  }

  foxglove::CameraCalibration calibration(Time time) const {
    const CameraModel& camera = flight_.camera;
    foxglove::CameraCalibration out;
    out.timestamp = time;
    out.frame_id = detail::kCameraFrame;
    out.width = static_cast<std::uint32_t>(camera.width_px());
    out.height = static_cast<std::uint32_t>(camera.height_px());
    auto distortion = detail::distortion_of(camera, "kannala_brandt");
    out.distortion_model = std::move(distortion.model);
    out.d = std::move(distortion.d);
    const Eigen::Matrix3d& k = camera.camera_matrix();
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) {
        out.k[static_cast<std::size_t>(3 * row + column)] = k(row, column);
        out.p[static_cast<std::size_t>(4 * row + column)] = k(row, column);
        out.r[static_cast<std::size_t>(3 * row + column)] = row == column ? 1.0 : 0.0;
      }
    return out;
  }

  const Flight& flight_;
  const WriteRecordingOptions& options_;
  mcap::Writer& writer_;
  bool mount_shown_ = false;
  std::optional<std::uint16_t> pose_, gimbal_, range_, frame_, tf_, fix_, camera_, image_;
  std::vector<LeftOut> left_out_;
};

}  // namespace

Result<std::vector<LeftOut>> write_mcap_flight(const Flight& flight, const fs::path& path,
                                               const WriteRecordingOptions& options,
                                               const Progress& progress) {
  std::error_code ec;
  if (!options.replace && fs::exists(path, ec))
    return Error{ErrorCode::Exists,
                 path.string() + ": is there already; remove it or name another file"};
  WATERSKY_TRY(PartialFile file, PartialFile::beside(path));
  // LZ4: what is beside the images is small, and they do not shrink.
  WATERSKY_TRY(mcap::Writer writer,
               mcap::Writer::open([&](std::span<const std::uint8_t> b) { return file.append(b); },
                                  {.profile = "",
                                   .library = "watersky",
                                   .compression = Compression::Lz4,
                                   .chunk_bytes = options.chunk_bytes}));
  WATERSKY_TRY(auto left_out, FlightWriter(flight, options, writer).write(progress));
  WATERSKY_CHECK(writer.close());
  WATERSKY_CHECK(file.publish());
  return left_out;
}

}  // namespace watersky
