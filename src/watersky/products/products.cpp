// SPDX-License-Identifier: MIT
#include "watersky/products/products.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "watersky/io/files.hpp"
#include "watersky/io/geotiff.hpp"
#include "watersky/products/detail/run_folder.hpp"
#include "watersky/products/palette.hpp"
#include "watersky/products/qgis_style.hpp"
#include "watersky/products/report.hpp"
#include "watersky/products/run_json.hpp"
#include "watersky/products/vector_files.hpp"
#include "watersky/store/map_file.hpp"

namespace watersky {

namespace fs = std::filesystem;

namespace {

bool is_earlier_run(const fs::path& folder) {
  std::ifstream file(folder / "run.json");
  const nlohmann::json run = nlohmann::json::parse(file, nullptr, false);
  return run.is_object() && run.contains("watersky");
}

struct Task {
  std::string file;
  std::function<Status(const fs::path&)> write;
};

std::vector<Task> tasks_for(const Products& products) {
  const RasterPlace place{products.geotransform, products.projection.wkt()};
  const auto text = [&](const char* description, const char* unit) {
    return RasterText{
        description, unit, {{"TIFFTAG_SOFTWARE", "Watersky"}, {"flight", products.flight_name}}};
  };
  double first_s = 0;
  double last_s = 1;
  const cv::Mat& times = products.rasters.last_seen_s;
  bool any = false;
  for (int r = 0; r < times.rows; ++r) {
    const double* t = times.ptr<double>(r);
    for (int c = 0; c < times.cols; ++c) {
      if (t[c] != t[c]) continue;
      first_s = any ? std::min(first_s, t[c]) : t[c];
      last_s = any ? std::max(last_s, t[c]) : t[c];
      any = true;
    }
  }
  double most_looks = 1;
  for (int r = 0; r < products.rasters.looks.rows; ++r) {
    const std::uint16_t* n = products.rasters.looks.ptr<std::uint16_t>(r);
    for (int c = 0; c < products.rasters.looks.cols; ++c)
      most_looks = std::max<double>(most_looks, n[c]);
  }

  // The longest first, so that several threads end together.
  std::vector<Task> tasks;
  if (!products.mosaic_bgra.empty())
    tasks.push_back({"mosaic.tif", [&products, place, text](const fs::path& path) {
                       return write_mosaic_geotiff(path, products.mosaic_bgra, place,
                                                   text("photographs on the sea plane", ""));
                     }});
  if (products.map)
    tasks.push_back({kMapFileName, [&products](const fs::path& path) {
                       return write_map_file(disk(), path, products.map->header,
                                             products.map->tiles);
                     }});
  tasks.push_back(
      {"report.html", [&products](const fs::path& path) { return write_report(path, products); }});
  tasks.push_back({"probability.tif", [&products, place, text](const fs::path& path) {
                     return write_geotiff(path, products.rasters.probability, place,
                                          text("probability of ice", "1"));
                   }});
  if (products.smoothing) {
    tasks.push_back({"smoothed.tif", [&products, place, text](const fs::path& path) {
                       return write_geotiff(path, products.smoothing->probability, place,
                                            text("probability of ice, smoothed", "1"));
                     }});
    tasks.push_back({"most_likely.tif", [&products, place, text](const fs::path& path) {
                       return write_geotiff(path, products.smoothing->most_likely, place,
                                            text("most likely map: 0 water, 1 ice", "1"));
                     }});
    for (const char* style : {"smoothed.qml", "most_likely.qml"})
      tasks.push_back({style, [](const fs::path& path) {
                         return write_file(path, raster_qml(kProbabilityRamp, 0, 1, ""));
                       }});
  }
  tasks.push_back(
      {"ice.gpkg", [&products](const fs::path& path) { return write_geopackage(path, products); }});
  tasks.push_back({"last_seen.tif", [&products, place, text](const fs::path& path) {
                     return write_geotiff(
                         path, products.rasters.last_seen_s, place,
                         text(products.times_are_utc
                                  ? "time of the last look, UTC since 1970"
                                  : "time of the last look by the camera's clock, since 1970",
                              "s"));
                   }});
  tasks.push_back({"looks.tif", [&products, place, text](const fs::path& path) {
                     return write_geotiff(path, products.rasters.looks, place,
                                          text("frames that showed the cell", "1"));
                   }});
  tasks.push_back({"icebergs.geojson", [&products](const fs::path& path) {
                     return write_icebergs_geojson(path, products);
                   }});
  tasks.push_back({"probability.qml", [](const fs::path& path) {
                     return write_file(path, raster_qml(kProbabilityRamp, 0, 1, ""));
                   }});
  tasks.push_back({"looks.qml", [most_looks](const fs::path& path) {
                     return write_file(path,
                                       raster_qml(kCountRamp, 1, std::max(2.0, most_looks), ""));
                   }});
  tasks.push_back({"last_seen.qml", [first_s, last_s](const fs::path& path) {
                     return write_file(
                         path, raster_qml(kCountRamp, first_s, std::max(first_s + 1, last_s), "s"));
                   }});
  tasks.push_back({"run.json", [&products](const fs::path& path) {
                     return write_file(path, run_json_text(products));
                   }});
  return tasks;
}

/// Progress is told from the calling thread only, as its contract has it.
Status run_tasks(const std::vector<Task>& tasks, const fs::path& folder, int threads,
                 const Progress& progress) {
  std::atomic<std::size_t> next{0};
  std::vector<Status> results(tasks.size());
  const auto work = [&](bool tells) {
    for (std::size_t i; (i = next++) < tasks.size();) {
      if (tells) report(progress, "write", i, tasks.size());
      results[i] = tasks[i].write(folder / tasks[i].file);
    }
  };
  {
    std::vector<std::jthread> others;
    for (int i = 1; i < std::min(threads, static_cast<int>(tasks.size())); ++i)
      others.emplace_back([&] { work(false); });
    work(true);
  }
  for (const Status& result : results) WATERSKY_CHECK(result);
  report(progress, "write", tasks.size(), tasks.size());
  return {};
}

}  // namespace

void analyse(Products& products) {
  // Shapes are those of the evidence: a growler whose place is uncertain is no smaller for it.
  ice::Rasters sharp = products.rasters;
  if (!products.evidence_probability.empty()) sharp.probability = products.evidence_probability;
  products.concentration = ice::concentration(sharp.probability, products.ground_cell_m(),
                                              products.object_parameters.ice_probability);
  products.objects = ice::find_objects(sharp, products.ground_cell_m(), products.object_parameters);
  products.floes = ice::floe_statistics(products.objects);
}

Status check_output(const fs::path& out, const WriteOptions& options) {
  std::error_code error;
  const fs::path folder = resolved(out);
  if (!fs::exists(fs::symlink_status(folder, error))) return {};
  if (!options.overwrite)
    return Error{ErrorCode::Exists, out.string() +
                                        ": is already there; choose another output folder, or "
                                        "replace an earlier run with --overwrite"};
  if (!fs::is_directory(folder, error) || !is_earlier_run(folder))
    return Error{ErrorCode::Exists,
                 out.string() +
                     ": is already there and no run of watersky (it holds no run.json of ours), so "
                     "it is not replaced; choose another output folder"};
  return {};
}

Status write_products(const Products& products, const fs::path& out, const WriteOptions& options,
                      const Progress& progress) {
  WATERSKY_CHECK(check_output(out, options));
  if (products.rasters.probability.empty())
    return Error{ErrorCode::OutOfRange,
                 out.string() + ": not written: no cell of the map was seen"};
  WATERSKY_TRY(PartialFolder partial, PartialFolder::beside(out));
  if (const Status written =
          run_tasks(tasks_for(products), partial.path(), options.threads, progress);
      !written) {
    return detail::named_as_asked(written.error(), partial.path(), out);
  }
  return partial.publish();
}

}  // namespace watersky
