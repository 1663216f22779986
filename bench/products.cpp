// SPDX-License-Identifier: MIT
/// How long each product takes to write: 2500 x 2000 cells with a mosaic, one thread,
/// disk permitting. With a folder's name it leaves the products there, to look at.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include "support/survey_products.hpp"
#include "watersky/io/geotiff.hpp"
#include "watersky/products/report.hpp"
#include "watersky/products/run_json.hpp"
#include "watersky/products/vector_files.hpp"

int main(int argc, char** argv) {
  using namespace watersky;
  cv::setNumThreads(1);
  const test::TemporaryFolder folder;
  Products p = test::survey_products(test::drawn_floes(2000, 2500, 2500, 1), 0.1);
  const RasterPlace place{p.geotransform, p.projection.wkt()};
  const auto figure = [&](const std::string& name, const std::function<Status()>& work) {
    double best_s = 1e9;
    for (int run = 0; run < 3; ++run) {
      const auto start = std::chrono::steady_clock::now();
      if (const Status s = work(); !s) {
        std::fprintf(stderr, "%s\n", s.error().message.c_str());
        return;
      }
      best_s = std::min(
          best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    std::printf("{\"name\":\"products.2500x2000.%s\",\"value\":%.4f,\"unit\":\"s\"}\n",
                name.c_str(), best_s);
  };
  if (argc > 1) {
    const Status s = write_products(p, argv[1], {.overwrite = true});
    if (!s) std::fprintf(stderr, "%s\n", s.error().message.c_str());
    return s ? 0 : 1;
  }
  const std::filesystem::path& f = folder.path();
  figure("analyse", [&] {
    analyse(p);
    return Status();
  });
  figure("probability_tif",
         [&] { return write_geotiff(f / "p.tif", p.rasters.probability, place, {}); });
  figure("looks_tif", [&] { return write_geotiff(f / "l.tif", p.rasters.looks, place, {}); });
  figure("last_seen_tif",
         [&] { return write_geotiff(f / "s.tif", p.rasters.last_seen_s, place, {}); });
  figure("mosaic_tif", [&] { return write_mosaic_geotiff(f / "m.tif", p.mosaic_bgra, place, {}); });
  figure("ice_gpkg", [&] { return write_geopackage(f / "i.gpkg", p); });
  figure("icebergs_geojson", [&] { return write_icebergs_geojson(f / "i.geojson", p); });
  figure("report_html", [&] { return write_report(f / "r.html", p); });
  figure("run_json", [&] { return run_json_text(p).empty() ? Status(Error{}) : Status(); });
  figure("all", [&] { return write_products(p, f / "out", {.overwrite = true}); });
  std::printf("{\"name\":\"products.2500x2000.objects\",\"value\":%zu,\"unit\":\"1\"}\n",
              p.objects.size());
  for (const auto& entry : std::filesystem::directory_iterator(f / "out"))
    std::printf("{\"name\":\"products.2500x2000.size.%s\",\"value\":%ju,\"unit\":\"B\"}\n",
                entry.path().filename().c_str(), static_cast<std::uintmax_t>(entry.file_size()));
  return 0;
}
