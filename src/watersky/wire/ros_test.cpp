// SPDX-License-Identifier: MIT
#include "watersky/wire/ros.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

namespace watersky::ros {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

// As `rosmsg md5` of ROS Noetic prints them.
TEST(RosDefinition, HasTheMd5SumThatRosNodesCompare) {
  const auto sum = [](auto message) {
    return definition<decltype(message)>(Encoding::Ros1).md5sum;
  };
  EXPECT_EQ(sum(Header{}), "2176decaecbce78abc3b96ef049fabed");
  EXPECT_EQ(sum(Image{}), "060021388200f6f0f447d0fcd9c64743");
  EXPECT_EQ(sum(CompressedImage{}), "8f7a12909da2c9d3332d540a0977563f");
  EXPECT_EQ(sum(CameraInfo{}), "c9a58c1b0b154e0e6da7578cb991d214");
  EXPECT_EQ(sum(NavSatFix{}), "2d3a8cd499b9b4a0249fb98fd05cfa48");
  EXPECT_EQ(sum(Imu{}), "6a62c6daae103f4ff57a132d6f95cec2");
  EXPECT_EQ(sum(Range{}), "c005c34273dc426c67a020a87bc24148");
  EXPECT_EQ(sum(PoseStamped{}), "d3812c3cbc69362b77dc0b19b345f8f5");
  EXPECT_EQ(sum(TransformStamped{}), "b5764a33bfeb3588febc2682852579b0");
  EXPECT_EQ(sum(Odometry{}), "cd5e73d190d741a2f92e81eda573aca7");
  EXPECT_EQ(sum(OccupancyGrid{}), "3381f2d731d4076ec5c71b0759edbe4e");
  EXPECT_EQ(sum(TFMessage{}), "94810edda583a504dfda3829e70d7eec");
}

TEST(RosDefinition, CarriesTheTypesInIt) {
  const Definition ros1 = definition<TFMessage>(Encoding::Ros1);
  EXPECT_EQ(ros1.type, "tf2_msgs/TFMessage");
  EXPECT_THAT(ros1.text,
              HasSubstr("geometry_msgs/TransformStamped[] transforms\n" + std::string(80, '=') +
                        "\nMSG: geometry_msgs/TransformStamped\n"));
  EXPECT_THAT(ros1.text, HasSubstr("uint32 seq\ntime stamp\n"));
  const Definition ros2 = definition<TFMessage>(Encoding::Cdr);
  EXPECT_EQ(ros2.type, "tf2_msgs/msg/TFMessage");
  EXPECT_THAT(ros2.text, HasSubstr("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"));
  EXPECT_THAT(ros2.text, ::testing::Not(HasSubstr("seq")));
}

Header some_header() {
  return {7, Time(std::chrono::seconds(1'700'000'000) + std::chrono::nanoseconds(123'456'789)),
          "map"};
}

TEST(Ros1, BytesAreThoseOfTheWire) {
  Range m;
  m.header = {1, Time(std::chrono::seconds(2) + std::chrono::nanoseconds(3)), "ab"};
  m.radiation_type = 1;
  m.field_of_view = 1.0F;
  m.range = 2.0F;
  const Bytes expected = {1, 0, 0, 0,    2,    0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, 'a', 'b',
                          1, 0, 0, 0x80, 0x3F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40};
  EXPECT_EQ(encode(Encoding::Ros1, m), expected);
}

TEST(Cdr, BytesAreThoseOfTheWire) {
  Range m;
  m.header = {1, Time(std::chrono::seconds(2) + std::chrono::nanoseconds(3)), "ab"};
  m.radiation_type = 1;
  m.field_of_view = 1.0F;
  m.range = 2.0F;
  // Encapsulation, stamp, "ab" and its zero, the type right behind it, then floats aligned.
  const Bytes expected = {0, 1, 0,    0,    2, 0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0,    'a', 'b', 0, 1,
                          0, 0, 0x80, 0x3F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40, 0,   0,   0, 0};
  EXPECT_EQ(encode(Encoding::Cdr, m), expected);
}

TEST(Cdr, ARangeOfBeforeIronHasNoVariance) {
  Range m;
  m.range = 2.0F;
  m.variance = 0.25F;
  Bytes bytes = encode(Encoding::Cdr, m);
  EXPECT_EQ(decode<Range>(Encoding::Cdr, bytes)->variance, 0.25F);
  bytes.resize(bytes.size() - 4);
  const auto old = decode<Range>(Encoding::Cdr, bytes);
  ASSERT_TRUE(old) << old.error().message;
  EXPECT_EQ(old->range, 2.0F);
  EXPECT_EQ(old->variance, 0.0F);
}

/// Made of 4-byte fields only, so that swapping words turns the byte order.
TEST(Cdr, IsReadInBigEndianToo) {
  PoseStamped m;
  m.header = {0, some_header().stamp, "abc"};
  m.pose.position.x = 1.5;
  m.pose.orientation.w = 0.25;
  Bytes bytes = encode(Encoding::Cdr, m);
  bytes[1] = 0;
  for (const std::size_t at : {4u, 8u, 12u})
    std::reverse(bytes.begin() + at, bytes.begin() + at + 4);
  for (std::size_t at = 4 + 16; at < bytes.size(); at += 8)
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at) + 8);
  const auto back = decode<PoseStamped>(Encoding::Cdr, bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->header.stamp, m.header.stamp);
  EXPECT_EQ(back->header.frame_id, "abc");
  EXPECT_EQ(back->pose.position.x, 1.5);
  EXPECT_EQ(back->pose.orientation.w, 0.25);
}

template <class M>
void expect_round_trip(const M& message) {
  for (const Encoding encoding : {Encoding::Ros1, Encoding::Cdr}) {
    const Bytes bytes = encode(encoding, message);
    const auto back = decode<M>(encoding, bytes);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(encode(encoding, *back), bytes);
    // Cut anywhere it is an error that says where, or (a field that may lack) reads the same.
    for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
      const auto part = decode<M>(encoding, std::span(bytes).first(cut));
      if (part)
        EXPECT_TRUE((std::same_as<M, Range>)) << cut;
      else
        EXPECT_THAT(part.error().message, HasSubstr("byte ")) << cut;
    }
  }
}

TEST(Ros, EveryMessageComesBackInBothEncodings) {
  const Header header = some_header();
  const Bytes pixels = {1, 2, 3, 4, 5};
  const std::vector<std::int8_t> cells = {-1, 0, 100};
  CameraInfo info{header, 4,   6, "plumb_bob", {1, 2, 3, 4, 5},   {9, 8},
                  {1},    {2}, 1, 1,           {1, 2, 3, 4, true}};
  NavSatFix fix{header, {-1, 3}, 78.9, 11.9, 30.5, {1, 2}, 2};
  Odometry odometry{header, "base_link", {{{{1, 2, 3}}, {0, 0, 1, 0}}, {5}}, {}};
  TFMessage tf{{{header, "a", {{1, 2, 3}, {0, 1, 0, 0}}}, {header, "bcd", {}}}};
  expect_round_trip(header);
  expect_round_trip(Image{header, 1, 5, "mono8", 0, 5, pixels});
  expect_round_trip(CompressedImage{header, "jpeg", pixels});
  expect_round_trip(info);
  expect_round_trip(fix);
  expect_round_trip(Imu{header, {}, {-1}, {1, 2, 3}, {}, {4, 5, 6}, {}});
  expect_round_trip(Range{header, 1, 0.1F, 0.2F, 50.0F, 12.0F, 0.0F});
  expect_round_trip(PoseStamped{header, {{{1, 2, 3}}, {}}});
  expect_round_trip(tf.transforms[0]);
  expect_round_trip(tf);
  expect_round_trip(odometry);
  expect_round_trip(OccupancyGrid{header, {header.stamp, 0.5F, 3, 1, {}}, cells});
  const auto grid = encode(Encoding::Cdr, OccupancyGrid{header, {}, cells});
  EXPECT_EQ(decode<OccupancyGrid>(Encoding::Cdr, grid)->data[0], -1);
  EXPECT_EQ(decode<CameraInfo>(Encoding::Cdr, encode(Encoding::Cdr, info))->d.size(), 5u);
}

TEST(Ros, FourThousandMillionItemsAreAnError) {
  Bytes bytes(8, 0);
  std::fill(bytes.begin(), bytes.begin() + 4, std::uint8_t{0xFF});
  EXPECT_FALSE(decode<TFMessage>(Encoding::Ros1, bytes));
  const Bytes cdr = {0, 1, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF};
  EXPECT_FALSE(decode<TFMessage>(Encoding::Cdr, cdr));
  EXPECT_EQ(decode<TFMessage>(Encoding::Cdr, Bytes{0, 3, 0, 0, 0, 0, 0, 0}).error().code,
            ErrorCode::Unsupported);
}

}  // namespace
}  // namespace watersky::ros
