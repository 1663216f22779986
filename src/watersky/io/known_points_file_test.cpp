// SPDX-License-Identifier: MIT
#include "watersky/io/known_points_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "support/temporary_folder.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/io/files.hpp"

namespace watersky {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using watersky::test::TemporaryFolder;

Result<std::vector<Anchor>> anchors_of(std::string_view text) {
  std::vector<std::string> notes;
  return parse_anchors_csv(text, "anchors.csv", notes);
}

Result<std::vector<Anchor>> gcps_of(std::string_view text) {
  std::vector<std::string> notes;
  return parse_gcp_list(text, "gcp_list.txt", notes);
}

TEST(AnchorsCsv, ReadsPlacesAndSightings) {
  const auto anchors = anchors_of(
      "anchor,lat_deg,lon_deg,height_ellipsoid_m,height_above_sea_m,sigma_m,sigma_height_m,frame,"
      "u_px,v_px,sigma_px\n"
      "cairn,78.9,11.9,41.5,,0.05,0.1,a.jpg,100.5,200,0.5\n"
      "cairn,,,,,,,b.jpg,-3,7.25,\n"
      "\"ship, stern\",,,,,3,,b.jpg,10,20,2\n"
      "floe,79,12,,0.3,,,,,,\n");
  ASSERT_TRUE(anchors) << anchors.error().message;
  ASSERT_THAT(*anchors, SizeIs(3));
  const Anchor& cairn = (*anchors)[0];
  EXPECT_EQ(cairn.name, "cairn");
  ASSERT_TRUE(cairn.place);
  EXPECT_EQ(cairn.place->above, HeightAbove::Ellipsoid);
  EXPECT_DOUBLE_EQ(cairn.place->height_m, 41.5);
  EXPECT_DOUBLE_EQ(cairn.sigma_m, 0.05);
  EXPECT_DOUBLE_EQ(cairn.sigma_height_m, 0.1);
  ASSERT_THAT(cairn.sightings, SizeIs(2));
  EXPECT_DOUBLE_EQ(cairn.sightings[0].px.u, 100.5);
  EXPECT_DOUBLE_EQ(cairn.sightings[0].sigma_px, 0.5);
  EXPECT_DOUBLE_EQ(cairn.sightings[1].px.v, 7.25);
  EXPECT_DOUBLE_EQ(cairn.sightings[1].sigma_px, 1.0);
  const Anchor& ship = (*anchors)[1];
  EXPECT_EQ(ship.name, "ship, stern");
  EXPECT_FALSE(ship.place);
  EXPECT_DOUBLE_EQ(ship.sigma_height_m, 3.0);  // of a place, unless the height has its own
  const Anchor& floe = (*anchors)[2];
  EXPECT_EQ(floe.place->above, HeightAbove::Sea);
  EXPECT_DOUBLE_EQ(floe.place->height_m, 0.3);
  EXPECT_THAT(floe.sightings, IsEmpty());
}

TEST(AnchorsCsv, AnAnchorWithoutAHeightLiesAtTheSea) {
  const auto anchors = anchors_of("anchor,lat_deg,lon_deg,frame,u_px,v_px\nx,78,11,a,1,2\n");
  ASSERT_TRUE(anchors) << anchors.error().message;
  EXPECT_EQ((*anchors)[0].place->above, HeightAbove::Sea);
  EXPECT_EQ((*anchors)[0].place->height_m, 0.0);
}

TEST(AnchorsCsv, SaysWhatIsWrongWhereAndWhatToDo) {
  const std::string head =
      "anchor,lat_deg,lon_deg,height_ellipsoid_m,height_above_sea_m,sigma_m,frame,u_px,v_px\n";
  const struct {
    const char* rows;
    const char* says;
  } cases[] = {
      {"x,91,0,,,,a,1,2\n", "anchors.csv:2: lat_deg is 91; it must be from -90 to 90"},
      {"x,78,11,,,0,a,1,2\n", "sigma_m is 0"},
      {"x,78,11,,,-1,a,1,2\n", "sigma_m is -1"},
      {"x,78,11,1,2,,a,1,2\n", "keep one of them"},
      {"x,,,5,,,a,1,2\n", "has a height but no lat_deg"},
      {"x,78,,,,,a,1,2\n", "lon_deg is \"\", not a finite number"},
      {",78,11,,,,a,1,2\n", "names no anchor"},
      {"\"x\ny\",78,11,,,,a,1,2\n", "control character"},
      {"x,78,11,,,,,1,2\n", "names no frame"},
      {"x,78,11,,,,a,nan,2\n", "u_px is \"nan\""},
      {"x,78,11,,,,a,1,2\nx,79,11,,,,b,1,2\n", "anchors.csv:3: puts x elsewhere"},
      {"x,78,11,,,,a,1,2\nx,,,,,,a,3,4\n", "marked twice in a"},
  };
  for (const auto& c : cases) {
    const auto anchors = anchors_of(head + c.rows);
    ASSERT_FALSE(anchors) << c.rows;
    EXPECT_THAT(anchors.error().message, HasSubstr(c.says)) << c.rows;
    EXPECT_THAT(anchors.error().message, HasSubstr("anchors.csv:")) << c.rows;
  }
  EXPECT_THAT(anchors_of("anchor,lat_deg,frame,u_px,v_px\n").error().message,
              HasSubstr("not both; add the other"));
  EXPECT_EQ(anchors_of("lat_deg,lon_deg\n").error().code, ErrorCode::NotFound);
}

TEST(AnchorTracksCsv, GivesMovingAnchorsTheirPositions) {
  std::vector<std::string> notes;
  auto anchors = anchors_of("anchor,frame,u_px,v_px\nship,a,1,2\n").value();
  EXPECT_THAT(check_anchors(anchors, "anchors.csv").error().message,
              HasSubstr("anchors.csv: ship has no place"));
  const Status read = parse_anchor_tracks_csv(
      "anchor,time_s,lat_deg,lon_deg,height_above_sea_m\n"
      "ship,100,78,11,12\nbuoy,100,79,11,\nship,110.5,78.001,11,12\n",
      "anchor_tracks.csv", anchors, notes);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_THAT(anchors, SizeIs(2));
  EXPECT_TRUE(check_anchors(anchors, "anchors.csv"));
  ASSERT_THAT(anchors[0].track, SizeIs(2));
  EXPECT_EQ(anchors[0].track[1].time, Time(seconds(110.5)));
  EXPECT_DOUBLE_EQ(anchors[0].track[0].place.height_m, 12.0);
  EXPECT_THAT(anchors[1].sightings, IsEmpty());
}

TEST(AnchorTracksCsv, SaysWhatIsWrongAndWhere) {
  const std::string head = "anchor,time_s,lat_deg,lon_deg,height_ellipsoid_m,height_above_sea_m\n";
  const struct {
    const char* rows;
    const char* says;
  } cases[] = {{"ship,1,78,11,,\nship,1,78,11,,\n", "anchor_tracks.csv:3: is not later"},
               {"ship,1,78,11,2,\nship,2,78,11,,2\n", "keep to one"},
               {"ship,1,,,,\n", "says no place"},
               {"cairn,1,78,11,,\n", "has a fixed place as well"}};
  for (const auto& c : cases) {
    std::vector<std::string> notes;
    auto anchors =
        anchors_of("anchor,lat_deg,lon_deg,frame,u_px,v_px\nship,,,a,1,2\ncairn,78,11,a,1,2\n")
            .value();
    const Status read = parse_anchor_tracks_csv(head + c.rows, "anchor_tracks.csv", anchors, notes);
    ASSERT_FALSE(read) << c.rows;
    EXPECT_THAT(read.error().message, HasSubstr(c.says));
  }
}

// The form that OpenDroneMap's documentation gives, in the systems that it and WebODM write.
TEST(GcpList, ReadsWhatOpenDroneMapReads) {
  const auto utm = gcps_of(
      "WGS84 UTM 33N\n"
      "# a remark\n\n"
      "433000.5 8760000.25 31.5 3044 2622 IMG_0525.jpg cairn\n"
      "433000.5\t8760000.25\t31.5\t4193 1552 IMG_0585.jpg cairn extra words\n"
      "433100 8760000 NaN 1606 2763 IMG_0525.jpg\r\n");
  ASSERT_TRUE(utm) << utm.error().message;
  ASSERT_THAT(*utm, SizeIs(2));
  const Anchor& cairn = (*utm)[0];
  EXPECT_EQ(cairn.name, "cairn");
  EXPECT_THAT(cairn.sightings, SizeIs(2));
  EXPECT_EQ(cairn.sightings[1].frame, "IMG_0585.jpg");
  EXPECT_DOUBLE_EQ(cairn.sightings[1].px.u, 4193);
  EXPECT_EQ(cairn.place->above, HeightAbove::Ellipsoid);
  EXPECT_DOUBLE_EQ(cairn.place->height_m, 31.5);
  const auto projection = Projection::from_text("EPSG:32633").value();
  const Eigen::Vector2d back =
      projection.forward(cairn.place->latitude, cairn.place->longitude).value();
  EXPECT_NEAR(back.x(), 433000.5, 1e-4);
  EXPECT_NEAR(back.y(), 8760000.25, 1e-4);
  EXPECT_EQ((*utm)[1].place->above, HeightAbove::Sea);
  EXPECT_THAT((*utm)[1].sightings, SizeIs(1));

  for (const char* header : {"EPSG:32633", "epsg:32633",
                             "+proj=utm +zone=33 +ellps=WGS84 +datum=WGS84 +units=m +no_defs"}) {
    const auto same =
        gcps_of(std::string(header) + "\n433000.5 8760000.25 31.5 3044 2622 IMG_0525.jpg cairn\n");
    ASSERT_TRUE(same) << same.error().message;
    EXPECT_DOUBLE_EQ((*same)[0].place->latitude.degrees(), cairn.place->latitude.degrees());
  }
  const auto degrees = gcps_of("EPSG:4326\n11.9 78.9 5 1 2 a.jpg\n");
  ASSERT_TRUE(degrees) << degrees.error().message;
  EXPECT_DOUBLE_EQ((*degrees)[0].place->latitude.degrees(), 78.9);
  EXPECT_DOUBLE_EQ((*degrees)[0].place->longitude.degrees(), 11.9);
}

TEST(GcpList, SaysWhatIsWrongAndWhere) {
  const struct {
    const char* text;
    const char* says;
  } cases[] = {
      {"", "gcp_list.txt: is empty"},
      {"EPSG:25833\n1 2 3 4 5 a\n", "gcp_list.txt:1: \"EPSG:25833\" is none of"},
      {"WGS84 UTM 61N\n1 2 3 4 5 a\n", "is none of"},
      {"EPSG:4326\n1 2 3 4 5\n", "gcp_list.txt:2: has 5 words"},
      {"EPSG:4326\n1 x 3 4 5 a\n", "gcp_list.txt:2: y is \"x\""},
      {"EPSG:4326\n1 nan 3 4 5 a\n", "y is \"nan\""},
      {"EPSG:4326\n78 112 3 4 5 a\n", "x is the longitude"},
      {"EPSG:4326\n1 2 3 4 5 a p\n1 3 3 4 5 b p\n", "gcp_list.txt:3: puts p elsewhere"},
      {"EPSG:4326\n1 2 3 4 5 a p\n1 2 3 4 6 a p\n", "marked twice in a"},
  };
  for (const auto& c : cases) {
    const auto anchors = gcps_of(c.text);
    ASSERT_FALSE(anchors) << c.text;
    EXPECT_THAT(anchors.error().message, HasSubstr(c.says));
  }
}

TEST(RangeCsv, ReadsTimesRangesAndSigmas) {
  std::vector<std::string> notes;
  const auto ranges = parse_range_csv(
      "time_s,range_m,sigma_m,quality\n1.5,100.25,0.05,9\n1.6,99,,9\n", "range.csv", notes);
  ASSERT_TRUE(ranges) << ranges.error().message;
  ASSERT_THAT(*ranges, SizeIs(2));
  EXPECT_EQ((*ranges)[0].time, Time(seconds(1.5)));
  EXPECT_DOUBLE_EQ((*ranges)[0].range_m, 100.25);
  EXPECT_DOUBLE_EQ((*ranges)[0].sigma_m, 0.05);
  EXPECT_EQ((*ranges)[1].sigma_m, 0.0);
  EXPECT_THAT(notes, Contains(HasSubstr("quality")));
  for (const char* rows : {"1,2,\n1,2,\n", "2,2,\n1,2,\n", "1,-2,\n", "1,nan,\n", "1,2,0\n"})
    EXPECT_FALSE(
        parse_range_csv(std::string("time_s,range_m,sigma_m\n") + rows, "range.csv", notes))
        << rows;
}

// What is written is what was meant, to the last bit.
TEST(KnownPointsFiles, ComeBackAsTheyWere) {
  std::mt19937_64 rng(3);
  const auto dice = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(rng);
  };
  const auto place = [&](HeightAbove above) {
    return AnchorPlace{Angle::degrees(dice(-90, 90)), Angle::degrees(dice(-180, 180)),
                       dice(-100, 3000), above};
  };
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Anchor> anchors(3);
    for (std::size_t k = 0; k < anchors.size(); ++k) {
      Anchor& a = anchors[k];
      a.name = "a\"" + std::to_string(k) + ",";
      a.sigma_m = dice(0.01, 3);
      a.sigma_height_m = dice(0.01, 3);
      const HeightAbove above = trial % 2 == 0 ? HeightAbove::Sea : HeightAbove::Ellipsoid;
      if (k == 1)
        for (int i = 0; i < 4; ++i)
          a.track.push_back({Time(Duration(rng() % 1000 + 1000 * i)), place(above)});
      else
        a.place = place(above);
      for (int i = 0; i < trial % 3; ++i)
        a.sightings.push_back(
            {"f" + std::to_string(i), {dice(-10, 5000), dice(-10, 5000)}, dice(0.1, 3)});
    }
    const auto same_name = [](const std::string& f) { return std::optional(f); };
    const std::string text = format_anchors_csv(anchors, same_name);
    const std::string tracks = format_anchor_tracks_csv(anchors);
    std::vector<std::string> notes;
    auto back = parse_anchors_csv(text, "anchors.csv", notes);
    ASSERT_TRUE(back) << back.error().message;
    const Status read = parse_anchor_tracks_csv(tracks, "anchor_tracks.csv", *back, notes);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_THAT(notes, IsEmpty());
    EXPECT_EQ(format_anchors_csv(*back, same_name), text);
    EXPECT_EQ(format_anchor_tracks_csv(*back), tracks);
    ASSERT_THAT(*back, SizeIs(3));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ((*back)[k].name, anchors[k].name);
      EXPECT_EQ((*back)[k].sigma_m, anchors[k].sigma_m);
      EXPECT_EQ((*back)[k].sightings.size(), anchors[k].sightings.size());
    }
  }
  // Frames that were not written take their sightings with them, but the anchor stays.
  Anchor one{.name = "one", .place = place(HeightAbove::Sea), .track = {}, .sightings = {}};
  one.sightings = {{"lost", {1, 2}, 1}, {"kept", {3, 4}, 1}};
  const std::string text =
      format_anchors_csv({one}, [](const std::string& f) -> std::optional<std::string> {
        if (f == "lost") return std::nullopt;
        return "renamed.png";
      });
  EXPECT_THAT(text, HasSubstr("renamed.png"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("lost")));
}

TEST(KnownPointsFiles, WhatIsGivenGoesBeforeWhatLiesThere) {
  const TemporaryFolder folder;
  const std::string head = "anchor,lat_deg,lon_deg,frame,u_px,v_px\n";
  ASSERT_TRUE(write_file(folder.path() / "anchors.csv", head + "there,78,11,a,1,2\n"));
  ASSERT_TRUE(write_file(folder.path() / "gcp_list.txt", "EPSG:4326\n11 78 0 1 2 a list\n"));
  ASSERT_TRUE(write_file(folder.path() / "other.csv", head + "given,78,11,a,1,2\n"));
  ASSERT_TRUE(write_file(folder.path() / "range.csv", "time_s,range_m\n1,100\n"));
  Eigen::Matrix3d matrix;
  matrix << 60, 0, 31.5, 0, 60, 23.5, 0, 0, 1;
  Flight flight("f", Datum(), CameraModel::make(LensModel::Pinhole, 64, 48, matrix).value());
  ASSERT_TRUE(read_known_points(folder.path(), {}, {}, flight));
  EXPECT_EQ(flight.anchors.at(0).name, "there");
  EXPECT_THAT(flight.ranges, SizeIs(1));
  ASSERT_TRUE(read_known_points(folder.path(), folder.path() / "other.csv", {}, flight));
  EXPECT_EQ(flight.anchors.at(0).name, "given");
  std::filesystem::remove(folder.path() / "anchors.csv");
  ASSERT_TRUE(read_known_points(folder.path(), {}, {}, flight));
  EXPECT_EQ(flight.anchors.at(0).name, "list");
  ASSERT_TRUE(write_file(folder.path() / "range.csv", "time_s,range_m\n1,far\n"));
  const Status wrong = read_known_points(folder.path(), {}, {}, flight);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("range.csv:2: range_m is \"far\""));
  EXPECT_EQ(read_known_points(folder.path(), folder.path() / "none.csv", {}, flight).error().code,
            ErrorCode::NotFound);
}

}  // namespace
}  // namespace watersky
