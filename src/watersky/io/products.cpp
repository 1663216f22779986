// SPDX-License-Identifier: MIT
#include "watersky/io/products.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "watersky/io/detail/file_output.hpp"
#include "watersky/io/geotiff.hpp"
#include "watersky/io/palette.hpp"
#include "watersky/io/qgis_style.hpp"
#include "watersky/io/report.hpp"
#include "watersky/io/run_json.hpp"
#include "watersky/io/vector_files.hpp"

namespace watersky::io {

namespace fs = std::filesystem;

namespace {

/// A folder that is removed with all that is in it, unless it was kept.
class Scratch {
 public:
  explicit Scratch(fs::path path) : path_(std::move(path)) {}
  ~Scratch() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }
  void keep() { path_.clear(); }

 private:
  fs::path path_;
};

bool is_earlier_run(const fs::path& folder) {
  std::ifstream file(folder / "run.json");
  const nlohmann::json run = nlohmann::json::parse(file, nullptr, false);
  return run.is_object() && run.contains("watersky");
}

Error refused(const fs::path& out, const std::error_code& error) {
  return {ErrorCode::Io, out.string() + ": cannot be written: " + error.message() +
                             "; choose another output folder, or free space there"};
}

/// The folder itself, whether or not it was given with a slash at its end.
fs::path folder_of(const fs::path& out) {
  const fs::path absolute = fs::absolute(out).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

struct Task {
  std::string file;
  std::function<Status(const fs::path&)> write;
};

std::vector<Task> tasks_for(const Products& products) {
  const RasterPlace place{products.geotransform, products.projection.wkt()};
  const auto text = [&](const char* description, const char* unit) {
    return RasterText{description, unit, {{"TIFFTAG_SOFTWARE", "Watersky"}, {"flight", products.flight_name}}};
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
    for (int c = 0; c < products.rasters.looks.cols; ++c) most_looks = std::max<double>(most_looks, n[c]);
  }

  // The longest first, so that several threads end together.
  std::vector<Task> tasks;
  if (!products.mosaic_bgra.empty())
    tasks.push_back({"mosaic.tif", [&products, place, text](const fs::path& path) {
                       return write_mosaic_geotiff(path, products.mosaic_bgra, place, text("photographs on the sea plane", ""));
                     }});
  tasks.push_back({"report.html", [&products](const fs::path& path) { return write_report(path, products); }});
  tasks.push_back({"probability.tif", [&products, place, text](const fs::path& path) {
                     return write_geotiff(path, products.rasters.probability, place, text("probability of ice", "1"));
                   }});
  tasks.push_back({"ice.gpkg", [&products](const fs::path& path) { return write_geopackage(path, products); }});
  tasks.push_back({"last_seen.tif", [&products, place, text](const fs::path& path) {
                     return write_geotiff(path, products.rasters.last_seen_s, place, text("time of the last look, UTC since 1970", "s"));
                   }});
  tasks.push_back({"looks.tif", [&products, place, text](const fs::path& path) {
                     return write_geotiff(path, products.rasters.looks, place, text("frames that showed the cell", "1"));
                   }});
  tasks.push_back({"icebergs.geojson", [&products](const fs::path& path) { return write_icebergs_geojson(path, products); }});
  tasks.push_back({"probability.qml", [](const fs::path& path) {
                     return detail::write_file(path, raster_qml(kProbabilityRamp, 0, 1, ""));
                   }});
  tasks.push_back({"looks.qml", [most_looks](const fs::path& path) {
                     return detail::write_file(path, raster_qml(kCountRamp, 1, std::max(2.0, most_looks), ""));
                   }});
  tasks.push_back({"last_seen.qml", [first_s, last_s](const fs::path& path) {
                     return detail::write_file(path, raster_qml(kCountRamp, first_s, std::max(first_s + 1, last_s), "s"));
                   }});
  tasks.push_back({"run.json", [&products](const fs::path& path) { return detail::write_file(path, run_json_text(products)); }});
  return tasks;
}

/// Progress is told from the calling thread only, as its contract has it.
Status run_tasks(const std::vector<Task>& tasks, const fs::path& folder, int threads, const Progress& progress) {
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
  products.concentration = ice::concentration(products.rasters.probability, products.cell_m(),
                                              products.object_parameters.ice_probability);
  products.objects =
      ice::find_objects(products.rasters, products.cell_m(), products.object_parameters);
  products.floes = ice::floe_statistics(products.objects);
}

Status check_output(const fs::path& out, const WriteOptions& options) {
  std::error_code error;
  const fs::path folder = folder_of(out);
  if (!fs::exists(fs::symlink_status(folder, error))) return {};
  if (!options.overwrite)
    return Error{ErrorCode::Exists, out.string() + ": is already there; choose another output folder, or allow an earlier run to be replaced (--force)"};
  if (!fs::is_directory(folder, error) || !is_earlier_run(folder))
    return Error{ErrorCode::Exists, out.string() + ": is already there and no run of watersky (it holds no run.json of ours), so it is not replaced; choose another output folder"};
  return {};
}

Status write_products(const Products& products, const fs::path& out, const WriteOptions& options,
                      const Progress& progress) {
  WATERSKY_CHECK(check_output(out, options));
  if (products.rasters.probability.empty())
    return Error{ErrorCode::OutOfRange, out.string() + ": not written: no cell of the map was seen"};
  const fs::path target = folder_of(out);
  const fs::path parent = target.parent_path();
  const std::string id = std::to_string(::getpid());
  const auto beside = [&](const char* what) {
    return parent / std::string(".").append(target.filename().string()).append(what).append(id);
  };

  // Folders above OUT that are missing are made, and taken back if the rest fails.
  fs::path first_made;
  for (fs::path p = parent; !p.empty() && !fs::exists(p); p = p.parent_path()) first_made = p;
  Scratch made(first_made);
  std::error_code error;
  fs::create_directories(parent, error);
  if (error) return refused(out, error);

  Scratch scratch(beside(".part."));
  fs::create_directory(scratch.path(), error);
  if (error) return refused(out, error);
  if (const Status written = run_tasks(tasks_for(products), scratch.path(), options.threads, progress); !written) {
    Error e = written.error();
    // The folder that the user asked for, not the one it was to be renamed from.
    if (const std::size_t at = e.message.find(scratch.path().string()); at != std::string::npos)
      e.message.replace(at, scratch.path().string().size(), out.string());
    return e;
  }

  // An earlier run is moved aside until the new one stands in its place.
  if (fs::exists(target)) {
    const fs::path aside = beside(".old.");
    fs::rename(target, aside, error);
    if (error) return refused(out, error);
    fs::rename(scratch.path(), target, error);
    if (error) {
      std::error_code ignored;
      fs::rename(aside, target, ignored);
      return refused(out, error);
    }
    std::error_code ignored;
    fs::remove_all(aside, ignored);
  } else {
    fs::rename(scratch.path(), target, error);
    if (error) return refused(out, error);
  }
  scratch.keep();
  made.keep();
  return {};
}

}  // namespace watersky::io
