// SPDX-License-Identifier: MIT
#include "watersky/io/polygons.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include "watersky/io/files.hpp"

namespace watersky {
namespace {

Result<std::vector<GeoPolygon>> read(const std::string& text,
                                     const std::string& name = "land.geojson") {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(write_file(folder.path() / name, text).ok());
  return read_polygons(folder.path() / name);
}

constexpr const char* kSquare =
    R"({"type":"Polygon","coordinates":[[[11,78],[12,78],[12,79],[11,79],[11,78]],)"
    R"([[11.2,78.2],[11.4,78.2],[11.4,78.4],[11.2,78.2]]]})";

TEST(Polygons, AreReadFromGeoJsonInAnyWrapping) {
  const std::string square = kSquare;
  const std::string feature = R"({"type":"Feature","properties":{},"geometry":)" + square + "}";
  for (const std::string& text :
       {square, feature, R"({"type":"FeatureCollection","features":[)" + feature + "]}",
        R"({"type":"GeometryCollection","geometries":[{"type":"Point","coordinates":[1,2]},)" +
            square + "]}"}) {
    const auto polygons = read(text);
    ASSERT_TRUE(polygons.ok()) << polygons.error().message;
    ASSERT_EQ(polygons->size(), 1U);
    const auto& rings = polygons->front().rings_lon_lat_deg;
    ASSERT_EQ(rings.size(), 2U);
    EXPECT_EQ(rings[0].size(), 4U);
    EXPECT_EQ(rings[0][1], Eigen::Vector2d(12, 78));
    EXPECT_EQ(rings[1].size(), 3U);
  }
  const auto two = read(R"({"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[1,1],[0,0]]],)"
                        R"([[[5,5],[6,5],[6,6],[5,5]]]]})");
  ASSERT_TRUE(two.ok()) << two.error().message;
  EXPECT_EQ(two->size(), 2U);
}

TEST(Polygons, ComeInLongitudeAndLatitudeWhateverTheFileHas) {
  // UTM 33: its central meridian is 15° E, where the easting is 500 km.
  const auto polygons = read(
      R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:32633"}},)"
      R"("features":[{"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":)"
      R"([[[500000,8700000],[500000,8760000],[510000,8760000],[500000,8700000]]]}}]})");
  ASSERT_TRUE(polygons.ok()) << polygons.error().message;
  const Eigen::Vector2d p = polygons->front().rings_lon_lat_deg[0][0];
  EXPECT_NEAR(p.x(), 15.0, 1e-9);
  EXPECT_NEAR(p.y(), 78.37, 0.02);
}

TEST(Polygons, AreRefusedWhenTheyAreNone) {
  EXPECT_THAT(read(R"({"type":"Point","coordinates":[11,78]})").error().message,
              testing::HasSubstr("holds no polygon"));
  EXPECT_FALSE(read("not json at all").ok());
  EXPECT_FALSE(read("").ok());
  EXPECT_THAT(
      read(R"({"type":"Polygon","coordinates":[[[500000,78],[12,78],[12,79],[500000,78]]]})")
          .error()
          .message,
      testing::HasSubstr("no longitude and latitude"));
  EXPECT_EQ(read_polygons("/nowhere/land.geojson").error().code, ErrorCode::NotFound);
}

}  // namespace
}  // namespace watersky
