// SPDX-License-Identifier: MIT
#include "watersky/products/products.hpp"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "support/survey_products.hpp"
#include "watersky/geo/rotation.hpp"
#include "watersky/products/palette.hpp"
#include "watersky/products/qgis_style.hpp"
#include "watersky/products/run_json.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const Products& products() {
  static const Products p = test::survey_products(test::drawn_floes(400, 600, 150, 3), 0.5);
  return p;
}

std::string read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

std::size_t candidates(const Products& p) {
  return static_cast<std::size_t>(
      std::count_if(p.objects.begin(), p.objects.end(),
                    [](const auto& o) { return o.kind == ice::ObjectKind::IcebergCandidate; }));
}

TEST(Products, EverythingTheContractNamesIsThere) {
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "deep" / "out";
  std::size_t last = 0;
  std::size_t total = 0;
  const Status s =
      write_products(products(), out, {}, [&](std::string_view, std::size_t done, std::size_t all) {
        EXPECT_GE(done, last);
        last = done;
        total = all;
      });
  ASSERT_TRUE(s.ok()) << s.error().message;
  EXPECT_EQ(last, total);
  for (const char* name :
       {"probability.tif", "looks.tif", "last_seen.tif", "mosaic.tif", "ice.gpkg",
        "icebergs.geojson", "report.html", "run.json", "probability.qml"})
    EXPECT_GT(fs::file_size(out / name), 0u) << name;
  EXPECT_EQ(names_in(folder.path() / "deep"), std::set<std::string>{"out"});
}

TEST(Products, SeveralThreadsWriteTheSame) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_products(products(), folder.path() / "one", {.threads = 1}).ok());
  ASSERT_TRUE(write_products(products(), folder.path() / "four/", {.threads = 4}).ok());
  EXPECT_EQ(names_in(folder.path() / "one"), names_in(folder.path() / "four"));
  for (const char* name : {"probability.tif", "mosaic.tif", "icebergs.geojson", "report.html"})
    EXPECT_EQ(read(folder.path() / "one" / name), read(folder.path() / "four" / name)) << name;
}

TEST(Products, WhatIsThereIsNotTouched) {
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  fs::create_directory(out);
  std::ofstream(out / "mine.txt") << "precious";
  for (const bool overwrite : {false, true}) {
    const Status s = write_products(products(), out, {.overwrite = overwrite});
    ASSERT_FALSE(s.ok());
    EXPECT_EQ(s.error().code, ErrorCode::Exists);
  }
  EXPECT_EQ(check_output(out).error().code, ErrorCode::Exists);
  EXPECT_EQ(names_in(out), std::set<std::string>{"mine.txt"});
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"out"});
  EXPECT_TRUE(check_output(folder.path() / "other").ok());
}

TEST(Products, AnEarlierRunIsReplacedOnlyWhenAsked) {
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  ASSERT_TRUE(write_products(products(), out).ok());
  std::ofstream(out / "old.txt") << "x";
  EXPECT_EQ(write_products(products(), out).error().code, ErrorCode::Exists);
  EXPECT_TRUE(fs::exists(out / "old.txt"));
  ASSERT_TRUE(write_products(products(), out, {.overwrite = true}).ok());
  EXPECT_FALSE(fs::exists(out / "old.txt"));
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"out"});
}

TEST(Products, AnUnwritableFolderIsAnIoErrorAndLeavesNothing) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  const Status s = write_products(products(), folder.path() / "file" / "out");
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, ErrorCode::Io);
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"file"});
}

TEST(Products, AFullDiskIsAnIoErrorAndLeavesNothing) {
  const test::TemporaryFolder folder;
  const fs::path disk = folder.path() / "disk";
  fs::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=200k") != 0)
    GTEST_SKIP() << "a small disk cannot be mounted here (needs root)";
  // The products come to about 1 MB: each file meets the end of the disk at another place.
  for (const char* size : {"size=20k", "size=100k", "size=200k", "size=300k"}) {
    ASSERT_EQ(::mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT, size), 0);
    const Status s = write_products(products(), disk / "new" / "out");
    EXPECT_FALSE(s.ok()) << size;
    if (!s.ok()) {
      EXPECT_EQ(s.error().code, ErrorCode::Io);
      EXPECT_NE(s.error().message.find("No space left"), std::string::npos) << s.error().message;
      EXPECT_EQ(s.error().message.find(".part"), std::string::npos) << s.error().message;
    }
    EXPECT_TRUE(fs::is_empty(disk)) << size;
  }
  EXPECT_EQ(::umount(disk.c_str()), 0);
}

TEST(Products, NothingSeenIsNotWritten) {
  const test::TemporaryFolder folder;
  Products empty = products();
  empty.rasters = {};
  EXPECT_EQ(write_products(empty, folder.path() / "out").error().code, ErrorCode::OutOfRange);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

/// A run whose map was seen once by a camera 100 m above the sea: P(ice) 0.7 in the west and 0.4 in
/// the east, and a hole of what was not known.
MapRun small_run() {
  const Projection projection = Projection::from_text("EPSG:32633").value();
  MapRun run{.flight_name = "small",
             .reference = {projection, 433000.0, 8759000.0, 0.5},
             .map = IceMap::make({.cell_m = 0.5}).value(),
             .options = {},
             .calibration = {},
             .mount = {},
             .sea_level = {},
             .datum = {}};
  Eigen::Matrix3d intrinsics;
  intrinsics << 100, 0, 39.5, 0, 100, 29.5, 0, 0, 1;
  const CameraModel camera = CameraModel::make(LensModel::Pinhole, 80, 60, intrinsics).value();
  const Rigid3<Sea, Camera> sea_from_camera(camera_rotation({0_deg, -90_deg, 0_deg}),
                                            Point<Sea>{{0.0, 0.0, -100.0}});
  Eigen::Matrix3d sea_from_grid;
  sea_from_grid << 0, -0.5, 0, 0.5, 0, 0, 0, 0, 1;
  const GridView view =
      make_grid_view(SeaView::make(camera, sea_from_camera).value(), sea_from_grid).value();
  cv::Mat evidence(60, 80, CV_32F, cv::Scalar(log_odds(0.4)));
  evidence.colRange(0, 40).setTo(log_odds(0.7));
  evidence(cv::Rect(60, 20, 9, 9)).setTo(std::numeric_limits<float>::quiet_NaN());
  evidence.at<float>(10, 70) = 3.0F;  // a speck
  EXPECT_TRUE(run.map.update(view, evidence, Time(seconds(1))).ok());
  return run;
}

TEST(Smoothing, WithoutCouplingIsTheRawMapToTheBit) {
  const MapRun run = small_run();
  Products p = products_of(run);
  ASSERT_TRUE(add_smoothing(p, run, {.coupling = 0.0}).ok());
  const cv::Mat& raw = p.rasters.probability;
  ASSERT_EQ(p.smoothing->probability.size(), raw.size());
  for (int r = 0; r < raw.rows; ++r)
    for (int c = 0; c < raw.cols; ++c) {
      const float x = raw.at<float>(r, c), y = p.smoothing->probability.at<float>(r, c);
      ASSERT_TRUE(x == y || (x != x && y != y)) << r << ", " << c;
      ASSERT_EQ(p.smoothing->most_likely.at<std::uint8_t>(r, c), x != x ? 255 : x > 0.5F ? 1 : 0);
    }
}

TEST(Smoothing, StandsBesideTheRawMapAndLeavesItAsItIs) {
  const MapRun run = small_run();
  const Products raw = products_of(run);
  Products p = products_of(run);
  ASSERT_TRUE(add_smoothing(p, run).ok());
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_products(raw, folder.path() / "raw").ok());
  ASSERT_TRUE(write_products(p, folder.path() / "smoothed").ok());
  std::set<std::string> more = names_in(folder.path() / "raw");
  more.insert({"smoothed.tif", "smoothed.qml", "most_likely.tif", "most_likely.qml"});
  EXPECT_EQ(names_in(folder.path() / "smoothed"), more);
  for (const char* name : {"probability.tif", "looks.tif", "icebergs.geojson"})
    EXPECT_EQ(read(folder.path() / "raw" / name), read(folder.path() / "smoothed" / name)) << name;
  EXPECT_NE(read(folder.path() / "smoothed" / "report.html").find("most_likely.tif"),
            std::string::npos);

  EXPECT_TRUE(run_json(raw)["smoothing"].is_null());
  const json smoothing = run_json(p)["smoothing"];
  EXPECT_EQ(smoothing["coupling"], p.smoothing->coupling);
  EXPECT_EQ(smoothing["coupling_is"], "chosen from the map");
  EXPECT_EQ(run_json(p)["parameters"]["smoothing"]["coupling"]["value"], -1.0);
  EXPECT_EQ(run_json(p)["figures"].dump(), run_json(raw)["figures"].dump());

  GDALAllRegister();
  const std::unique_ptr<GDALDataset> file(
      GDALDataset::Open((folder.path() / "smoothed" / "most_likely.tif").c_str(), GDAL_OF_RASTER));
  ASSERT_TRUE(file);
  EXPECT_EQ(file->GetRasterBand(1)->GetRasterDataType(), GDT_Byte);
  EXPECT_EQ(file->GetRasterBand(1)->GetNoDataValue(), 255.0);
}

TEST(RunJson, KeepsTheContractOfFrames) {
  const json run = json::parse(run_json_text(products()));
  EXPECT_EQ(run["frames"]["total"], 31);
  EXPECT_EQ(run["frames"]["used"], 28);
  ASSERT_EQ(run["frames"]["left_out"].size(), 3u);
  EXPECT_EQ(run["frames"]["left_out"][2]["file"], "<b>bad</b>.jpg");
  EXPECT_EQ(run["frames"]["left_out"][0]["reason"], products().left_out[0].reason);
}

TEST(RunJson, TellsParametersWithTheirUnitsAndFiguresWithTheirs) {
  const json run = run_json(products());
  EXPECT_EQ(run["parameters"]["mapping"]["cell_m"]["unit"], "m");
  EXPECT_EQ(run["parameters"]["mapping"]["p_ice_if_ice"]["value"], 0.7);
  EXPECT_EQ(run["parameters"]["objects"]["isolation_gap_m"]["value"], 3.0);
  EXPECT_NEAR(run["figures"]["ice_concentration"].get<double>(), products().concentration.expected,
              1e-12);
  EXPECT_EQ(run["figures"]["iceberg_candidates"], candidates(products()));
  EXPECT_EQ(run["projection"]["name"], "EPSG:32633");
  EXPECT_NEAR(run["extent"]["corners_from_north_west_clockwise"][0]["lat_deg"].get<double>(), 78.9,
              0.01);
  for (const char* name : {"watersky", "opencv", "gdal", "proj"})
    EXPECT_FALSE(run["versions"][name].get<std::string>().empty());
  EXPECT_TRUE(run["mount"].is_null());
}

TEST(RunJson, IsUtf8WhateverTheFileNamesHold) {
  Products p = products();
  p.left_out.push_back({"bad\xff\xfe.jpg", "caf\xe9"});
  EXPECT_FALSE(json::parse(run_json_text(p), nullptr, false).is_discarded());
}

struct Package {
  test::TemporaryFolder folder;
  std::unique_ptr<GDALDataset> data;
  Package() {
    EXPECT_TRUE(write_products(products(), folder.path() / "out").ok());
    GDALAllRegister();
    data.reset(GDALDataset::Open((folder.path() / "out" / "ice.gpkg").c_str(), GDAL_OF_VECTOR));
  }
};

TEST(GeoPackage, HoldsItsLayersAndTheirFeatures) {
  const Package package;
  ASSERT_TRUE(package.data);
  OGRLayer* footprints = package.data->GetLayerByName("footprints");
  OGRLayer* floes = package.data->GetLayerByName("floes");
  OGRLayer* icebergs = package.data->GetLayerByName("icebergs");
  OGRLayer* tracks = package.data->GetLayerByName("tracks");
  ASSERT_TRUE(footprints && floes && icebergs && tracks);
  EXPECT_EQ(footprints->GetFeatureCount(), 28);
  EXPECT_GT(candidates(products()), 0u);
  EXPECT_EQ(icebergs->GetFeatureCount(), static_cast<GIntBig>(candidates(products())));
  EXPECT_EQ(floes->GetFeatureCount() + icebergs->GetFeatureCount(),
            static_cast<GIntBig>(products().objects.size()));
  EXPECT_STREQ(floes->GetSpatialRef()->GetAuthorityCode(nullptr), "32633");

  const std::unique_ptr<OGRFeature> frame(footprints->GetNextFeature());
  EXPECT_STREQ(frame->GetFieldAsString("file"), "frame_0.jpg");
  EXPECT_EQ(std::string(frame->GetFieldAsString("captured")).substr(0, 19), "2018/08/05 01:00:44");
  EXPECT_NEAR(frame->GetFieldAsDouble("off_nadir_deg"), Angle::radians(0.02).degrees(), 1e-9);
  EXPECT_DOUBLE_EQ(frame->GetFieldAsDouble("height_above_sea_m"), 100.0);

  const std::unique_ptr<OGRFeature> track(tracks->GetNextFeature());
  EXPECT_STREQ(track->GetFieldAsString("kind"), "aircraft");
  EXPECT_EQ(track->GetGeometryRef()->toLineString()->getNumPoints(), 28);
}

TEST(GeoPackage, OutlinesHaveTheAreaTheirFieldsSay) {
  const Package package;
  ASSERT_TRUE(package.data);
  for (const char* name : {"floes", "icebergs"}) {
    OGRLayer* layer = package.data->GetLayerByName(name);
    ASSERT_TRUE(layer);
    int seen = 0;
    while (const std::unique_ptr<OGRFeature> f{layer->GetNextFeature()}) {
      EXPECT_NEAR(f->GetGeometryRef()->toMultiPolygon()->get_Area(), f->GetFieldAsDouble("area_m2"),
                  1e-3);
      EXPECT_NEAR(f->GetFieldAsDouble("lat_deg"), 78.9, 0.01);
      EXPECT_NEAR(f->GetFieldAsDouble("lon_deg"), 11.9, 0.02);
      ++seen;
    }
    EXPECT_GT(seen, 0);
  }
}

TEST(GeoPackage, EveryLayerHasADefaultStyleThatIsWellFormed) {
  const Package package;
  ASSERT_TRUE(package.data);
  OGRLayer* styles = package.data->GetLayerByName("layer_styles");
  ASSERT_TRUE(styles);
  std::set<std::string> styled;
  while (const std::unique_ptr<OGRFeature> f{styles->GetNextFeature()}) {
    styled.insert(f->GetFieldAsString("f_table_name"));
    EXPECT_STREQ(f->GetFieldAsString("f_geometry_column"), "geom");
    EXPECT_EQ(f->GetFieldAsInteger("useAsDefault"), 1);
    for (const char* column : {"styleQML", "styleSLD"}) {
      CPLXMLNode* xml = CPLParseXMLString(f->GetFieldAsString(column));
      EXPECT_TRUE(xml) << column;
      CPLDestroyXMLNode(xml);
    }
  }
  EXPECT_EQ(styled, (std::set<std::string>{"footprints", "floes", "icebergs", "tracks"}));
  EXPECT_EQ(package.data->GetLayerByName("floes")->GetGeometryColumn(), std::string("geom"));
}

TEST(GeoJson, IsRfc7946) {
  const Package package;
  const json collection = json::parse(read(package.folder.path() / "out" / "icebergs.geojson"));
  EXPECT_EQ(collection["type"], "FeatureCollection");
  EXPECT_FALSE(collection.contains("crs"));
  ASSERT_EQ(collection["features"].size(), candidates(products()));
  for (const json& feature : collection["features"]) {
    EXPECT_GT(feature["properties"]["length_m"].get<double>(), 0);
    const json polygons = feature["geometry"]["type"] == "MultiPolygon"
                              ? feature["geometry"]["coordinates"]
                              : json::array({feature["geometry"]["coordinates"]});
    for (const json& polygon : polygons) {
      const json& outer = polygon[0];
      double twice = 0;
      for (std::size_t i = 0; i + 1 < outer.size(); ++i) {
        EXPECT_NEAR(outer[i][0].get<double>(), 11.9, 0.02);
        EXPECT_NEAR(outer[i][1].get<double>(), 78.9, 0.01);
        twice += outer[i][0].get<double>() * outer[i + 1][1].get<double>() -
                 outer[i + 1][0].get<double>() * outer[i][1].get<double>();
      }
      EXPECT_GT(twice, 0) << "the outer line must run counter-clockwise";
      EXPECT_EQ(outer.front(), outer.back());
    }
  }
}

TEST(GeoJson, NoCandidatesIsAnEmptyCollection) {
  const test::TemporaryFolder folder;
  Products p = products();
  p.objects.clear();
  ASSERT_TRUE(write_products(p, folder.path() / "out").ok());
  EXPECT_TRUE(json::parse(read(folder.path() / "out" / "icebergs.geojson"))["features"].empty());
}

TEST(Palette, RampsGrowLighterAllTheWay) {
  for (const Ramp ramp : {Ramp(kProbabilityRamp), Ramp(kCountRamp)}) {
    double last = -1;
    for (int i = 0; i <= 100; ++i) {
      const Rgb c = color_at(ramp, i / 100.0);
      const double luma = 0.2126 * c.red + 0.7152 * c.green + 0.0722 * c.blue;
      EXPECT_GE(luma, last);
      last = luma;
    }
  }
  EXPECT_EQ(hex(color_at(kProbabilityRamp, -1)), hex(kProbabilityRamp.front().color));
  EXPECT_EQ(color_at(kProbabilityRamp, 2), kProbabilityRamp.back().color);
}

TEST(QgisStyle, RasterStylesAreWellFormedAndSpanTheirRange) {
  const std::string qml = raster_qml(kCountRamp, 1533430844.8, 1533430914.8, "s");
  CPLXMLNode* xml = CPLParseXMLString(qml.c_str());
  EXPECT_TRUE(xml);
  CPLDestroyXMLNode(xml);
  EXPECT_NE(qml.find("value=\"1533430844.8\""), std::string::npos);
  EXPECT_NE(qml.find("value=\"1533430914.8\""), std::string::npos);
}

}  // namespace
}  // namespace watersky
