// SPDX-License-Identifier: MIT
/// Our bags before @foxglove/rosbag.
#include "watersky/wire/rosbag.hpp"

#include <gmock/gmock.h>

#include "node_support.hpp"
#include "watersky/wire/ros.hpp"

namespace watersky::test {
namespace {

TEST(RosbagPeer, ReadsOursInEveryCompressionAndDecodesEveryMessage) {
  WATERSKY_NEEDS_NODE();
  for (const auto compression : {Compression::None, Compression::Lz4, Compression::Bz2}) {
    std::vector<std::uint8_t> file;
    auto writer = *rosbag::Writer::open(
        [&](std::span<const std::uint8_t> bytes) {
          file.insert(file.end(), bytes.begin(), bytes.end());
          return Status();
        },
        {.compression = compression, .chunk_bytes = 2000});
    const auto connection = [&](const ros::Definition& d, const std::string& topic, bool latching) {
      return *writer.add_connection({0, topic, d.type, d.md5sum, d.text, "/watersky", latching});
    };
    const auto tf = connection(ros::definition<ros::TFMessage>(ros::Encoding::Ros1), "/tf", false);
    const auto fix = connection(ros::definition<ros::NavSatFix>(ros::Encoding::Ros1), "/fix", true);
    for (std::uint32_t i = 0; i < 50; ++i) {
      const Time t(std::chrono::seconds(1'700'000'000 + i) + std::chrono::nanoseconds(7));
      const ros::Header header{i, t, "map"};
      const auto moved =
          ros::encode(ros::Encoding::Ros1,
                      ros::TFMessage{{{header, "base_link", {{1.0 * i, 2, 3}, {0, 0, 0, 1}}}}});
      ASSERT_TRUE(writer.write({tf, t, moved}));
      ros::NavSatFix nav{};
      nav.header = header;
      nav.latitude = 78 + 0.001 * i;
      const auto place = ros::encode(ros::Encoding::Ros1, nav);
      ASSERT_TRUE(writer.write({fix, t, place}));
    }
    const auto beginning = writer.close();
    ASSERT_TRUE(beginning);
    std::copy(beginning->begin(), beginning->end(), file.begin());

    const TemporaryFolder folder;
    const auto path = folder.path() / "ours.bag";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(file.data()),
               static_cast<std::streamsize>(file.size()));
    auto found = node("check_rosbag.mjs", "'" + path.string() + "'");
    ASSERT_FALSE(found.is_discarded());
    EXPECT_GT(found["chunks"], 2);
    ASSERT_EQ(found["messages"]["/tf"].size(), 50u);
    ASSERT_EQ(found["messages"]["/fix"].size(), 50u);
    auto& last = found["messages"]["/tf"][49];
    EXPECT_EQ(last["time"]["sec"], 1'700'000'049);
    EXPECT_EQ(last["time"]["nsec"], 7);
    EXPECT_EQ(last["message"]["transforms"][0]["transform"]["translation"]["x"], 49);
    EXPECT_EQ(last["message"]["transforms"][0]["child_frame_id"], "base_link");
    EXPECT_EQ(found["messages"]["/fix"][0]["message"]["latitude"], 78);
    EXPECT_EQ(found["connections"][0]["md5sum"], "94810edda583a504dfda3829e70d7eec");
    EXPECT_EQ(found["connections"][1]["caller"], "/watersky");
    EXPECT_EQ(found["connections"][1]["latching"], true);
  }
}

}  // namespace
}  // namespace watersky::test
