// SPDX-License-Identifier: MIT
/// Our MCAP files before @mcap/core, and its files before us.
#include <gmock/gmock.h>

#include "node_support.hpp"
#include "watersky/wire/mcap_reader.hpp"
#include "watersky/wire/mcap_writer.hpp"
#include "watersky/wire/protobuf.hpp"
#include "watersky/wire/ros.hpp"

namespace watersky::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Time at_ms(std::int64_t ms) { return Time(std::chrono::milliseconds(ms)); }

void write_bytes(const std::filesystem::path& file, const Bytes& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// A file with a message of each type, in each encoding that it has.
class Recording {
 public:
  explicit Recording(Compression compression)
      : writer_(*mcap::Writer::open(
            [this](std::span<const std::uint8_t> bytes) {
              file_.insert(file_.end(), bytes.begin(), bytes.end());
              return Status();
            },
            {.profile = "",
             .library = "watersky",
             .compression = compression,
             .chunk_bytes = 500})) {}

  template <class M>
  void add_proto(const M& message) {
    const protobuf::Schema schema = protobuf::schema<M>();
    add("/" + schema.name, schema.name, "protobuf", schema.descriptors, "protobuf",
        protobuf::encode(message));
  }
  template <class M>
  void add_ros(const M& message) {
    for (const auto encoding : {ros::Encoding::Ros1, ros::Encoding::Cdr}) {
      const bool ros1 = encoding == ros::Encoding::Ros1;
      const ros::Definition definition = ros::definition<M>(encoding);
      add((ros1 ? "/ros1/" : "/ros2/") + std::string(M::kType.name), definition.type,
          ros1 ? "ros1msg" : "ros2msg", Bytes(definition.text.begin(), definition.text.end()),
          ros1 ? "ros1" : "cdr", ros::encode(encoding, message));
    }
  }
  Bytes close() {
    EXPECT_TRUE(writer_.attach({"note.txt", "text/plain", at_ms(1), at_ms(2), {'h', 'i'}}));
    EXPECT_TRUE(writer_.add_metadata({"m", {{"k", "v"}}}));
    EXPECT_TRUE(writer_.close());
    return file_;
  }

 private:
  void add(const std::string& topic, const std::string& name, const std::string& schema_encoding,
           const Bytes& schema, const std::string& encoding, const Bytes& data) {
    const auto id = writer_.add_schema({0, name, schema_encoding, schema});
    const auto channel = writer_.add_channel({0, *id, topic, encoding, {}});
    ++time_ms_;
    EXPECT_TRUE(writer_.write({*channel, 7, at_ms(time_ms_), at_ms(time_ms_ + 1), data}));
  }
  Bytes file_;
  mcap::Writer writer_;
  std::int64_t time_ms_ = 1'700'000'000'000;
};

TEST(McapPeer, ReadsOursByTheIndexAndAsAStreamAndDecodesEveryMessage) {
  WATERSKY_NEEDS_NODE();
  const Time t(std::chrono::seconds(1'700'000'000) + std::chrono::nanoseconds(250));
  const Bytes pixels = {1, 2, 250};
  for (const auto compression : {Compression::None, Compression::Lz4, Compression::Zstd}) {
    Recording recording(compression);
    foxglove::LocationFix fix{t,
                              "map",
                              78.9,
                              11.9,
                              30.5,
                              {1, 2, 3, 4, 5, 6, 7, 8, 9},
                              foxglove::PositionCovarianceType::Known};
    recording.add_proto(fix);
    recording.add_proto(foxglove::FrameTransform{t, "map", "base_link", {1, 2, 3}, {0, 0, 0, 1}});
    recording.add_proto(foxglove::FrameTransforms{{{t, "a", "b", {}, {}}, {t, "c", "d", {}, {}}}});
    recording.add_proto(foxglove::CompressedImage{t, "camera", pixels, "jpeg"});
    recording.add_proto(foxglove::RawImage{t, "camera", 3, 1, "mono8", 3, pixels});
    recording.add_proto(
        foxglove::CameraCalibration{t, "camera", 640, 480, "plumb_bob", {1, 2}, {3}, {4}, {5}});
    recording.add_proto(foxglove::Grid{t,
                                       "map",
                                       {{1, 2, 3}, {0, 0, 0, 1}},
                                       3,
                                       {0.5, 0.25},
                                       3,
                                       1,
                                       {{"p", 0, foxglove::NumericType::Uint8}},
                                       pixels});
    recording.add_proto(foxglove::GeoJSON{"{}"});
    recording.add_proto(
        recording::Frame{"f.png", t, std::nullopt, true, 12, std::nullopt, std::nullopt});
    const ros::Header header{3, t, "map"};
    recording.add_ros(ros::CompressedImage{header, "png", pixels});
    recording.add_ros(ros::Image{header, 1, 3, "mono8", 0, 3, pixels});
    ros::CameraInfo info{};
    info.width = 640;
    info.d = {0.5, 0.25};
    info.roi.do_rectify = true;
    recording.add_ros(info);
    ros::NavSatFix nav{};
    nav.header = header;
    nav.latitude = 78.9;
    nav.position_covariance[8] = 4;
    nav.position_covariance_type = 2;
    recording.add_ros(nav);
    recording.add_ros(ros::TFMessage{{{header, "base_link", {{1, 2, 3}, {0, 0, 1, 0}}}}});
    recording.add_ros(ros::Odometry{header, "base_link", {{{{1, 2, 3}}, {}}, {}}, {}});
    recording.add_ros(ros::Range{header, 1, 0.5F, 0.25F, 50.0F, 12.5F, 0.0F});
    recording.add_ros(ros::Imu{header, {0, 1, 0, 0}, {}, {}, {}, {{}}, {}});
    recording.add_ros(ros::PoseStamped{header, {{{1, 2, 3}}, {}}});
    const std::vector<std::int8_t> cells = {-1, 0, 100};
    recording.add_ros(ros::OccupancyGrid{header, {t, 0.5F, 3, 1, {}}, cells});

    const TemporaryFolder folder;
    const auto file = folder.path() / "ours.mcap";
    write_bytes(file, recording.close());
    auto found = node("check_mcap.mjs", "'" + file.string() + "'");
    ASSERT_FALSE(found.is_discarded());
    const auto first = [&](const std::string& topic) {
      auto& all = found["messages"][topic];
      EXPECT_EQ(all.size(), 1u) << topic;
      return all.empty() ? nlohmann::json() : all[0]["message"];
    };
    EXPECT_EQ(found["messages"].size(), 9u + 2 * 10u);
    EXPECT_EQ(found["streamed"].size(), 9u + 2 * 10u);
    EXPECT_TRUE(found["stream_done"]);
    EXPECT_TRUE(found["has_data_crc"]);
    EXPECT_EQ(found["statistics"]["messageCount"], 29);
    EXPECT_GT(found["chunks"].size(), 3u);
    EXPECT_EQ(found["attachments"][0]["text"], "hi");
    EXPECT_EQ(found["metadata"][0]["values"]["k"], "v");
    EXPECT_EQ(found["messages"]["/foxglove.LocationFix"][0]["log_time"], "1700000000001000000");
    EXPECT_EQ(found["messages"]["/foxglove.LocationFix"][0]["sequence"], 7);

    auto location = first("/foxglove.LocationFix");
    EXPECT_EQ(location["latitude"], 78.9);
    EXPECT_EQ(location["position_covariance"], nlohmann::json({1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(location["position_covariance_type"], "KNOWN");
    EXPECT_EQ(location["timestamp"]["seconds"], 1'700'000'000);
    EXPECT_EQ(location["timestamp"]["nanos"], 250);
    EXPECT_EQ(first("/foxglove.FrameTransform")["child_frame_id"], "base_link");
    EXPECT_EQ(first("/foxglove.FrameTransforms")["transforms"][1]["parent_frame_id"], "c");
    EXPECT_EQ(first("/foxglove.CompressedImage")["data"], nlohmann::json({1, 2, 250}));
    EXPECT_EQ(first("/foxglove.RawImage")["step"], 3);
    EXPECT_EQ(first("/foxglove.CameraCalibration")["D"], nlohmann::json({1, 2}));
    EXPECT_EQ(first("/foxglove.Grid")["fields"][0]["type"], "UINT8");
    EXPECT_EQ(first("/foxglove.Grid")["cell_size"]["y"], 0.25);
    EXPECT_EQ(first("/foxglove.GeoJSON")["geojson"], "{}");
    EXPECT_EQ(first("/watersky.Frame")["counter"], 12);
    for (const std::string ros : {"/ros1/", "/ros2/"}) {
      EXPECT_EQ(first(ros + "CompressedImage")["data"], nlohmann::json({1, 2, 250}));
      EXPECT_EQ(first(ros + "Image")["encoding"], "mono8");
      EXPECT_EQ(first(ros + "CameraInfo")[ros == "/ros1/" ? "D" : "d"],
                nlohmann::json({0.5, 0.25}));
      EXPECT_EQ(first(ros + "CameraInfo")["roi"]["do_rectify"], true);
      EXPECT_EQ(first(ros + "NavSatFix")["latitude"], 78.9);
      EXPECT_EQ(first(ros + "NavSatFix")["position_covariance"][8], 4);
      EXPECT_EQ(first(ros + "NavSatFix")["position_covariance_type"], 2);
      EXPECT_EQ(first(ros + "TFMessage")["transforms"][0]["transform"]["rotation"]["z"], 1);
      EXPECT_EQ(first(ros + "TFMessage")["transforms"][0]["header"]["frame_id"], "map");
      EXPECT_EQ(first(ros + "Odometry")["pose"]["pose"]["position"]["z"], 3);
      EXPECT_EQ(first(ros + "Range")["range"], 12.5);
      EXPECT_EQ(first(ros + "Imu")["orientation"]["y"], 1);
      EXPECT_EQ(first(ros + "PoseStamped")["pose"]["orientation"]["w"], 1);
      EXPECT_EQ(first(ros + "OccupancyGrid")["data"], nlohmann::json({-1, 0, 100}));
    }
  }
}

TEST(McapPeer, WritesFilesThatWeReadByTheIndexAndWithoutIt) {
  WATERSKY_NEEDS_NODE();
  const TemporaryFolder folder;
  const auto file = folder.path() / "theirs.mcap";
  const auto wrote = node("write_mcap.mjs", "'" + file.string() + "'");
  ASSERT_FALSE(wrote.is_discarded());
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string bytes = text.str();
  const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
  for (const bool use_summary : {true, false}) {
    const auto reader = mcap::Reader::open(source, {.use_summary = use_summary});
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_EQ(reader->indexed(), use_summary);
    EXPECT_TRUE(reader->damage().empty());
    std::uint32_t n = 0;
    const auto damage = reader->for_each([&](const mcap::Message& m, const mcap::Location&) {
      EXPECT_EQ(m.sequence, n);
      EXPECT_EQ(m.log_time,
                Time(std::chrono::seconds(1'700'000'000)) + std::chrono::milliseconds(10 * n));
      EXPECT_EQ(reader->channels().at(m.channel).topic, n % 2 == 0 ? "/one" : "/two");
      const auto json = nlohmann::json::parse(m.data.begin(), m.data.end());
      EXPECT_EQ(json["i"], n);
      EXPECT_EQ(json["text"].get<std::string>().size(), n);
      ++n;
    });
    ASSERT_TRUE(damage);
    EXPECT_TRUE(damage->empty());
    EXPECT_EQ(n, 100u);
    EXPECT_GT(reader->chunks().size(), 2u);
    const auto attachment = reader->read(reader->attachments().at(0));
    ASSERT_TRUE(attachment) << attachment.error().message;
    EXPECT_EQ(std::string(attachment->data.begin(), attachment->data.end()), "attached");
    EXPECT_EQ(reader->read(reader->metadata().at(0))->values.at("k"), "v");
  }
}

}  // namespace
}  // namespace watersky::test
