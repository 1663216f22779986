// SPDX-License-Identifier: MIT
#include "watersky/wire/protobuf.hpp"

#include <gmock/gmock.h>

namespace watersky::protobuf {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

Time some_time() { return Time(std::chrono::seconds(300) + std::chrono::nanoseconds(5)); }

TEST(Protobuf, BytesAreThoseOfTheWire) {
  foxglove::GeoJSON json{"{}"};
  EXPECT_EQ(encode(json), (Bytes{0x0A, 2, '{', '}'}));
  foxglove::CompressedImage image;
  image.timestamp = some_time();
  const Bytes data = {7, 8};
  image.data = data;
  image.format = "png";
  // 300 is AC 02 as a varint.
  EXPECT_EQ(encode(image),
            (Bytes{0x0A, 5, 0x08, 0xAC, 0x02, 0x10, 5, 0x12, 2, 7, 8, 0x1A, 3, 'p', 'n', 'g'}));
  foxglove::PackedElementField field;
  field.name = "a";
  field.offset = 258;
  field.type = foxglove::NumericType::Float32;
  foxglove::Grid grid;
  grid.fields = {field};
  const Bytes bytes = encode(grid);
  const Bytes expected = {0x42, 10, 0x0A, 1, 'a', 0x15, 2, 1, 0, 0, 0x18, 7};
  EXPECT_NE(std::search(bytes.begin(), bytes.end(), expected.begin(), expected.end()), bytes.end());
}

TEST(Protobuf, NegativeZeroAndTimesBefore1970ComeBack) {
  foxglove::LocationFix fix;
  fix.latitude = -0.0;
  fix.timestamp = Time(Duration(-1));
  const auto back = decode<foxglove::LocationFix>(encode(fix));
  ASSERT_TRUE(back);
  EXPECT_TRUE(std::signbit(back->latitude));
  EXPECT_EQ(back->timestamp, fix.timestamp);
}

template <class M>
void expect_round_trip(const M& message) {
  const Bytes bytes = encode(message);
  const auto back = decode<M>(bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(encode(*back), bytes);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    const auto part = decode<M>(std::span(bytes).first(cut));
    if (!part) {
      EXPECT_THAT(part.error().message, HasSubstr("byte ")) << cut;
    }
  }
}

TEST(Protobuf, EveryMessageComesBack) {
  const Bytes data = {1, 2, 3};
  const Time t = some_time();
  foxglove::FrameTransform transform{t, "a", "b", {1, 2, 3}, {0, 0, 0, 1}};
  foxglove::CameraCalibration camera{t, "c", 4, 3, "plumb_bob", {1, 2, 3, 4, 5}, {1}, {2}, {3}};
  recording::Pose pose{t, {1, 2, 3}, {0, 0, 0, 1}, {1, 2, 3, 4, 5, 6}, {}};
  expect_round_trip(transform);
  expect_round_trip(foxglove::FrameTransforms{{transform, transform}});
  expect_round_trip(foxglove::CompressedImage{t, "c", data, "jpeg"});
  expect_round_trip(foxglove::RawImage{t, "c", 3, 1, "mono8", 3, data});
  expect_round_trip(camera);
  expect_round_trip(foxglove::Grid{
      t, "m", {}, 3, {0.5, 0.5}, 3, 1, {{"x", 0, foxglove::NumericType::Uint8}}, data});
  expect_round_trip(pose);
  expect_round_trip(
      recording::Frame{"f", t, std::nullopt, true, 7, pose, foxglove::Quaternion{0, 1, 0, 0}});
  expect_round_trip(recording::Frame{"f", std::nullopt, t, false, 0, std::nullopt, std::nullopt});
  expect_round_trip(recording::Gimbal{t, {0, 1, 0, 0}});
  expect_round_trip(recording::Range{t, 50.0, 0.1});
}

TEST(Protobuf, FieldsOfLaterVersionsAreSkipped) {
  Bytes bytes = encode(foxglove::GeoJSON{"{}"});
  const Bytes later = {0xF8, 0x01, 0x96, 0x01,                    // 31, a varint
                       0xF1, 0x01, 1,    2,    3, 4, 5, 6, 7, 8,  // 30, eight bytes
                       0xEA, 0x01, 2,    9,    9,                 // 29, delimited
                       0xE5, 0x01, 1,    2,    3, 4};             // 28, four bytes
  bytes.insert(bytes.end(), later.begin(), later.end());
  const auto back = decode<foxglove::GeoJSON>(bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->geojson, "{}");
}

TEST(Protobuf, WhatIsWrongIsToldWithItsByte) {
  const auto error = [](const Bytes& bytes) {
    const auto m = decode<foxglove::Grid>(bytes);
    return m ? std::string("none") : m.error().message;
  };
  EXPECT_THAT(error({0x12, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}),
              HasSubstr("foxglove.Grid: byte 0: a field that is longer"));
  EXPECT_THAT(error({0x0B}), HasSubstr("wire type 3"));
  EXPECT_THAT(error(Bytes(11, 0xFF)), HasSubstr("byte 0: a number is longer"));
  EXPECT_THAT(error({0x12, 1, 'm', 0x1A, 2, 0x0A, 9}), HasSubstr("byte 5"));
  EXPECT_THAT(error({0x10, 1}), HasSubstr("another type"));
}

}  // namespace
}  // namespace watersky::protobuf
