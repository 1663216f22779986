// SPDX-License-Identifier: MIT
/// The wall time of `watersky map` on the Brighton Beach photographs (18 JPEGs of 4000x2250) at
/// 0.10 m cells, colour mosaic and all products included, against decoding the same JPEGs once
/// to RGB in memory with libjpeg-turbo; one thread each, alternating in one run. Mapping alone,
/// with
/// --no-align: what alignment adds is map_align's figure.
///
///   map_brighton [DATA]   DATA: the folder brighton_beach; by default
///   $WATERSKY_DATA/brighton_beach
#include <turbojpeg.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "bench.hpp"

namespace fs = std::filesystem;
using namespace watersky;

namespace {

std::vector<std::vector<unsigned char>> read_jpegs(const fs::path& folder) {
  std::vector<std::vector<unsigned char>> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".JPG") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return files;
}

bool decode_all(const std::vector<std::vector<unsigned char>>& files,
                std::vector<unsigned char>& rgb) {
  tjhandle decoder = tjInitDecompress();
  bool ok = true;
  for (const auto& file : files) {
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    const auto size = static_cast<unsigned long>(file.size());
    ok &= tjDecompressHeader3(decoder, file.data(), size, &width, &height, &subsampling,
                              &colorspace) == 0;
    rgb.resize(3UL * static_cast<unsigned long>(width) * static_cast<unsigned long>(height));
    ok &= tjDecompress2(decoder, file.data(), size, rgb.data(), width, 0, height, TJPF_RGB, 0) == 0;
  }
  tjDestroy(decoder);
  return ok;
}

}  // namespace

int main(int argc, char** argv) {
  const char* data = std::getenv("WATERSKY_DATA");
  const fs::path flight =
      argc > 1 ? fs::path(argv[1]) : fs::path(data ? data : "") / "brighton_beach";
  if (!fs::exists(flight / "images")) {
    std::fprintf(
        stderr,
        "map_brighton: %s holds no images; give the folder brighton_beach, or set WATERSKY_DATA\n",
        flight.c_str());
    return 1;
  }
  const fs::path program =
      fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "watersky";
  const fs::path out =
      fs::temp_directory_path() /
      ("watersky_bench_" +
       std::to_string(std::chrono::steady_clock::now().time_since_epoch().count()));
  const std::string command =
      "'" + program.string() + "' map '" + flight.string() + "' -o '" + out.string() +
      "' --sea-level takeoff:-2 --cell-m 0.1 --threads 1 --quiet --overwrite --no-align";

  const auto files = read_jpegs(flight / "images");
  std::vector<unsigned char> rgb;
  std::vector<double> decode, map, ratio;
  for (int i = 0; i < 7; ++i) {
    bool ok = true;
    decode.push_back(bench::seconds_of([&] { ok &= decode_all(files, rgb); }));
    map.push_back(bench::seconds_of([&] { ok &= std::system(command.c_str()) == 0; }));
    if (!ok) {
      std::fprintf(stderr, "map_brighton: failed: %s\n", command.c_str());
      return 1;
    }
    ratio.push_back(map.back() / decode.back());
  }
  fs::remove_all(out);
  bench::print_figure("map_brighton.decode_s", bench::median(decode), "s");
  bench::print_figure("map_brighton.map_s", bench::median(map), "s");
  bench::print_figure("map_brighton.ratio_decode", bench::median(ratio), "1");
}
