// SPDX-License-Identifier: MIT
#include <optional>

#include "watersky/io/detail/timeline.hpp"
#include "watersky/io/files.hpp"
#include "watersky/io/recording_write.hpp"
#include "watersky/wire/ros.hpp"
#include "watersky/wire/rosbag.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

using detail::RigidMotion;

class BagWriter {
 public:
  BagWriter(const Flight& flight, const WriteRecordingOptions& options, rosbag::Writer& writer)
      : flight_(flight), options_(options), writer_(writer) {}

  Result<std::vector<LeftOut>> write(const Progress& progress) {
    WATERSKY_CHECK(detail::for_timeline(
        flight_, {[&](const StampedPose& p) { return pose(p.time, p.world_from_body); },
                  [&](const StampedRotation& g) { return gimbal(g); },
                  [&](const RangeSample& r) { return range(r); },
                  [&](std::size_t i, Time) {
                    report(progress, "writing images", i, flight_.frames.size());
                    return frame(i);
                  }}));
    report(progress, "writing images", flight_.frames.size(), flight_.frames.size());
    return left_out_;
  }

 private:
  template <class M>
  Status put(std::optional<std::uint32_t>& connection, const char* topic, Time time,
             const M& message, bool latching = false) {
    if (!connection) {
      ros::Definition d = ros::definition<M>(ros::Encoding::Ros1);
      WATERSKY_TRY(const std::uint32_t id,
                   writer_.add_connection({0, topic, std::move(d.type), std::move(d.md5sum),
                                           std::move(d.text), "/watersky", latching}));
      connection = id;
    }
    const auto bytes = ros::encode(ros::Encoding::Ros1, message);
    return writer_.write({*connection, time, bytes});
  }

  static ros::TFMessage transform(Time time, const char* parent, const char* child,
                                  const RigidMotion& m) {
    ros::TransformStamped t;
    t.header = {0, time, parent};
    t.child_frame_id = child;
    t.transform.translation = {m.translation_m.x(), m.translation_m.y(), m.translation_m.z()};
    t.transform.rotation = {m.rotation.x(), m.rotation.y(), m.rotation.z(), m.rotation.w()};
    return {{std::move(t)}};
  }

  Status pose(Time time, const Rigid3<World, Body>& world_from_body) {
    if (!mount_written_) {
      mount_written_ = true;
      WATERSKY_CHECK(
          put(tf_static_, "/tf_static", time,
              transform(time, flight_.gimbal_reference ? detail::kGimbalFrame : detail::kBodyFrame,
                        detail::kCameraFrame, detail::platform_from_camera(flight_)),
              true));
    }
    WATERSKY_CHECK(put(tf_, "/tf", time,
                       transform(time, detail::kMapFrame, detail::kBodyFrame,
                                 detail::map_from_base(flight_, world_from_body))));
    const Geodetic g = flight_.datum.geodetic(world_from_body.origin());
    ros::NavSatFix fix;
    fix.header = {sequence_++, time, detail::kBodyFrame};
    fix.latitude = g.latitude.degrees();
    fix.longitude = g.longitude.degrees();
    fix.altitude = g.height_ellipsoid_m;
    return put(fix_, "/fix", time, fix);
  }

  Status gimbal(const StampedRotation& g, const std::optional<StampedPose>& own = std::nullopt) {
    const auto motion = detail::base_from_gimbal(flight_, g, own);
    if (!motion) return {};
    return put(tf_, "/tf", g.time,
               transform(g.time, detail::kBodyFrame, detail::kGimbalFrame, *motion));
  }

  Status range(const RangeSample& r) {
    ros::Range m;
    m.header = {0, r.time, detail::kBodyFrame};
    m.radiation_type = 1;
    m.range = static_cast<float>(r.range_m);
    return put(range_, "/range", r.time, m);
  }

  Status frame(std::size_t i) {
    const ImageFrame& f = flight_.frames[i];
    const auto time = flight_.capture_time(f);
    if (!time) {
      left_out_.push_back({f.name, time.error().message});
      return {};
    }
    const auto image = detail::image_bytes(f, options_);
    if (!image) {
      left_out_.push_back({f.name, image.error().message});
      return {};
    }
    if (f.own_pose) WATERSKY_CHECK(pose(*time, f.own_pose->world_from_body));
    if (f.own_gimbal) WATERSKY_CHECK(gimbal({*time, *f.own_gimbal}, f.own_pose));
    const ros::Header header{static_cast<std::uint32_t>(f.counter.value_or(0)), *time,
                             detail::kCameraFrame};
    ros::CameraInfo info;
    info.header = header;
    info.width = static_cast<std::uint32_t>(flight_.camera.width_px());
    info.height = static_cast<std::uint32_t>(flight_.camera.height_px());
    auto distortion = detail::distortion_of(flight_.camera, "equidistant");
    info.distortion_model = std::move(distortion.model);
    info.d = std::move(distortion.d);
    const Eigen::Matrix3d& k = flight_.camera.camera_matrix();
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) {
        info.k[static_cast<std::size_t>(3 * row + column)] = k(row, column);
        info.p[static_cast<std::size_t>(4 * row + column)] = k(row, column);
        info.r[static_cast<std::size_t>(3 * row + column)] = row == column ? 1.0 : 0.0;
      }
    WATERSKY_CHECK(put(info_, "/camera/camera_info", *time, info));
    return put(
        image_, "/camera/image/compressed", *time,
        ros::CompressedImage{header, image->extension == ".png" ? "png" : "jpeg", image->bytes});
  }

  const Flight& flight_;
  const WriteRecordingOptions& options_;
  rosbag::Writer& writer_;
  bool mount_written_ = false;
  std::uint32_t sequence_ = 0;
  std::optional<std::uint32_t> tf_, tf_static_, fix_, range_, info_, image_;
  std::vector<LeftOut> left_out_;
};

}  // namespace

Result<std::vector<LeftOut>> write_bag_flight(const Flight& flight, const fs::path& path,
                                              const WriteRecordingOptions& options,
                                              const Progress& progress) {
  std::error_code ec;
  if (!options.replace && fs::exists(path, ec))
    return Error{ErrorCode::Exists,
                 path.string() + ": is there already; remove it or name another file"};
  WATERSKY_TRY(PartialFile file, PartialFile::beside(path));
  WATERSKY_TRY(rosbag::Writer writer, rosbag::Writer::open([&](std::span<const std::uint8_t> b) {
                 return file.append(b);
               }));
  WATERSKY_TRY(auto left_out, BagWriter(flight, options, writer).write(progress));
  WATERSKY_TRY(const auto beginning, writer.close());
  WATERSKY_CHECK(file.overwrite_beginning(beginning));
  WATERSKY_CHECK(file.publish());
  return left_out;
}

}  // namespace watersky
