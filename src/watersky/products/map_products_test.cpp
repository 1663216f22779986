// SPDX-License-Identifier: MIT
#include "watersky/products/map_products.hpp"

#include <gdal_priv.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "support/map_tiles.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/products/run_json.hpp"

namespace watersky {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

StoredMap some_map(const std::string& name, unsigned seed, int tiles = 6) {
  MapHeader header = test::some_header(name);
  header.wkt = Projection::from_text(header.projection).value().wkt();
  std::vector<TileItem> items;
  for (int i = 0; i < tiles; ++i)
    items.push_back(
        item_in_memory({i % 3 - 1, i / 3}, 0, 1, test::some_tile(seed + static_cast<unsigned>(i))));
  return {header, TileSet(header.sources, items)};
}

cv::Mat read_band(const fs::path& file, int type) {
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> d(GDALDataset::Open(file.c_str()));
  EXPECT_TRUE(d) << file;
  if (!d) return {};
  EXPECT_STREQ(d->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  GDALRasterBand* band = d->GetRasterBand(1);
  cv::Mat out(band->GetYSize(), band->GetXSize(), type);
  EXPECT_EQ(band->RasterIO(GF_Read, 0, 0, out.cols, out.rows, out.data, out.cols, out.rows,
                           type == CV_8U    ? GDT_Byte
                           : type == CV_16U ? GDT_UInt16
                           : type == CV_32F ? GDT_Float32
                                            : GDT_Float64,
                           0, 0, nullptr),
            CE_None);
  return out;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int r = 0; r < a.rows; ++r)
    if (std::memcmp(a.ptr(r), b.ptr(r), static_cast<std::size_t>(a.cols) * a.elemSize()) != 0)
      return false;
  return true;
}

TEST(MapProducts, HoldTheCellsOfTheMergedMap) {
  const test::TemporaryFolder folder;
  const auto merged = merge_maps({some_map("a", 1), some_map("b", 40)}, {"a", "b"});
  ASSERT_TRUE(merged);
  const auto run = write_map_products(*merged, {"a", "b"}, folder.path() / "out");
  ASSERT_TRUE(run) << run.error().message;
  const auto box = seen_box(merged->tiles);
  ASSERT_TRUE(box);
  const auto rasters = rasters_of(*merged, *box);
  ASSERT_TRUE(rasters);
  const fs::path out = folder.path() / "out";
  EXPECT_TRUE(same(read_band(out / "probability.tif", CV_32F), rasters->probability));
  EXPECT_TRUE(same(read_band(out / "looks.tif", CV_16U), rasters->looks));
  EXPECT_TRUE(same(read_band(out / "last_seen.tif", CV_64F), rasters->last_seen_s));
  EXPECT_EQ((*run)["figures"]["seen_cells"], cv::countNonZero(rasters->looks));
  EXPECT_EQ((*run)["sources"].size(), 2u);
  const auto again = open_map(disk(), out);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->tiles == merged->tiles);
  EXPECT_EQ(write_map_products(*merged, {}, out).error().code, ErrorCode::Exists);
  EXPECT_TRUE(write_map_products(*merged, {}, out, {.overwrite = true}));
}

TEST(MapProducts, OfAnEmptyMapAreNone) {
  const test::TemporaryFolder folder;
  const auto run = write_map_products(some_map("a", 1, 0), {"a"}, folder.path() / "out");
  ASSERT_FALSE(run);
  EXPECT_THAT(run.error().message, HasSubstr("no cell of the map was seen"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(MapProducts, ChangesAreARasterOfClassesAndTheirAreas) {
  const test::TemporaryFolder folder;
  const StoredMap a = some_map("a", 1), b = some_map("b", 40);
  const auto diff = MapDiff::of(a, b, "a", "b");
  ASSERT_TRUE(diff);
  ASSERT_TRUE(write_diff(*diff, folder.path() / "changes.tif"));
  const cv::Mat classes = read_band(folder.path() / "changes.tif", CV_8U);
  const auto figures = diff_json(*diff);
  ASSERT_TRUE(figures);
  for (int i = 0; i < static_cast<int>(kCellChanges); ++i) {
    const auto& change = (*figures)["changes"][std::string(name_of(static_cast<CellChange>(i)))];
    EXPECT_EQ(change["cells"], cv::countNonZero(classes == i)) << i;
    EXPECT_GT(change["cells"], 0) << i;
    EXPECT_NEAR(change["area_m2"].get<double>(), 0.25 * change["cells"].get<double>(),
                0.001 * change["cells"].get<double>());
  }
  EXPECT_TRUE(fs::exists(folder.path() / "changes.qml"));
}

TEST(MapProducts, AMapIsWhereItsHeaderSays) {
  const test::TemporaryFolder folder;
  StoredMap map = some_map("a", 1, 0);
  MapTile tile;
  test::look(tile, 10, 20, 500, test::at_second(3));
  map.tiles = TileSet(map.header.sources, {item_in_memory({2, -1}, 0, 1, tile)});
  ASSERT_TRUE(write_map_products(map, {"a"}, folder.path() / "out"));
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> d(
      GDALDataset::Open((folder.path() / "out" / "probability.tif").c_str()));
  ASSERT_TRUE(d);
  double gt[6];
  ASSERT_EQ(d->GetGeoTransform(gt), CE_None);
  EXPECT_EQ(gt[0], map.header.anchor_easting_m + (2 * 256 + 10) * 0.5);
  EXPECT_EQ(gt[3], map.header.anchor_northing_m - (-256 + 20) * 0.5);
  EXPECT_EQ(d->GetRasterXSize(), 1);
}

}  // namespace
}  // namespace watersky
