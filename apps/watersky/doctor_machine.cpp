// SPDX-License-Identifier: MIT
/// The doctor on processor, memory, clock and disk.
#include <fcntl.h>
#include <sched.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <sstream>

#include "doctor.hpp"
#include "watersky/map/ice_map.hpp"

namespace watersky::cli {

namespace {

/// Below these a flight of 12-megapixel photographs does not fit: two decoded frames a thread,
/// the map and its products.
constexpr double kLeastMemory_gb = 0.5, kLeastDisk_gb = 1.0;
/// A live map's journal is made safe once a second, beside everything else.
constexpr double kSlowestSync_s = 0.2;
constexpr double kSlowestDisk_mb_s = 5.0;

std::string text(const char* format, auto... values) {
  char line[300];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

/// The value of "key : value" or "key: value kB" in a file of /proc; empty when it is not there.
std::string proc_value(const char* file, std::string_view key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::size_t first = line.find_first_not_of(" \t", colon + 1);
    return first == std::string::npos ? std::string() : line.substr(first);
  }
  return {};
}

std::string first_line(const char* file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line, '\0');  // a device tree's strings end with zero
  while (!line.empty() && line.back() == '\n') line.pop_back();
  return line;
}

int cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

Finding processor() {
  utsname system{};
  uname(&system);
  std::string name = proc_value("/proc/cpuinfo", "model name");
  const std::string board = first_line("/proc/device-tree/model");
  if (!board.empty()) name += (name.empty() ? "" : ", ") + board;
  if (name.empty()) name = "unnamed processor";
  const int usable = cores();
  const long all = sysconf(_SC_NPROCESSORS_ONLN);
  Finding f{.name = "cpu",
            .value = name + ", " + system.machine + ", " +
                     (usable == all ? text("%d cores", usable)
                                    : text("%d of %ld cores may be used", usable, all))};
  f.details = {{"name", name},
               {"machine", system.machine},
               {"cores", usable},
               {"cores_online", all},
               {"kernel", system.release}};
  const std::string governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (!governor.empty()) f.details["governor"] = governor;
  if (governor == "powersave") {
    f.health = Health::Warning;
    f.value += ", clocked down (powersave)";
    f.remedy = "cpupower frequency-set -g performance (package linux-cpupower)";
  }
  return f;
}

/// What segmentation's loops (vision/detail/dispatch.hpp), the map's kernels and OpenCV choose
/// here.
Finding instruction_sets() {
  std::string ours;
#if defined(__x86_64__)
  // The levels of the x86-64 ABI by the features that tell them apart (clang does not know the
  // levels' names here).
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi2");
  const bool v4 = v3 && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
                  __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  ours = v4 ? "AVX-512 (x86-64-v4)" : v3 ? "AVX2 (x86-64-v3)" : "SSE2 (x86-64)";
#elif defined(__aarch64__)
  ours = "NEON (AArch64)";
#else
  ours = "the compiler's baseline";
#endif
  const std::string opencv = cv::getCPUFeaturesLine();
  const std::string map(update_instructions());
  Finding f{.name = "simd",
            .value = "segmentation " + ours + ", map " + map + "; OpenCV: " + opencv};
  f.details = {{"segmentation", ours},
               {"map", map},
               {"opencv", opencv},
               {"opencv_version", cv::getVersionString()}};
  return f;
}

Finding memory() {
  const auto gb = [](const char* key) {
    return std::strtod(proc_value("/proc/meminfo", key).c_str(), nullptr) / (1 << 20);
  };
  const double total = gb("MemTotal"), available = gb("MemAvailable");
  Finding f{.name = "memory", .value = text("%.1f GB, %.1f GB of it free", total, available)};
  f.details = {{"total_gb", total}, {"available_gb", available}};
  if (available < kLeastMemory_gb) {
    f.health = Health::Warning;
    f.remedy = "end other programs, or map with --threads 1 and larger cells";
  }
  return f;
}

Finding clock() {
  timex t{};
  const int state = adjtimex(&t);
  Finding f{.name = "clock"};
  if (state < 0) {
    f.health = Health::Warning;
    f.value = std::string("the system does not tell whether it is set: ") + std::strerror(errno);
    return f;
  }
  const bool set = state != TIME_ERROR && (t.status & STA_UNSYNC) == 0;
  // The kernel's bound grows by 500 ppm while nobody disciplines the clock, up to 16 s.
  const double bound_s = 1e-6 * static_cast<double>(t.maxerror);
  f.details = {{"synchronised", set}, {"bound_s", bound_s}};
  if (set) {
    f.value = text("synchronised, within %.3g s", bound_s);
  } else {
    f.health = Health::Warning;
    f.value =
        "not synchronised: frames that are stamped on this machine are off by as much as "
        "its clock";
    f.remedy = "install systemd-timesyncd, or chrony with the GPS receiver";
  }
  return f;
}

/// A file that nobody sees, in `folder`; gone when closed.
class ScratchFile {
 public:
  explicit ScratchFile(const std::filesystem::path& folder) {
    fd_ = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    if (fd_ >= 0) return;
    std::string name = (folder / ".watersky-doctor-XXXXXX").string();  // not every disk can do that
    fd_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (fd_ >= 0) ::unlink(name.c_str());
  }
  ~ScratchFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  [[nodiscard]] bool open() const { return fd_ >= 0; }
  [[nodiscard]] bool write(const std::vector<char>& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t n = ::write(fd_, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  }
  [[nodiscard]] bool sync() const { return ::fdatasync(fd_) == 0; }

 private:
  int fd_ = -1;
};

struct DiskSpeed {
  double mb_s = 0.0;
  double sync_s = 0.0;  ///< of 4 kB, median
};

/// nullopt with errno set when the disk refuses.
std::optional<DiskSpeed> disk_speed(const std::filesystem::path& folder) {
  constexpr std::size_t kMegabytes = 32, kSyncs = 15;
  const ScratchFile file(folder);
  if (!file.open()) return std::nullopt;
  const auto seconds_since = [](auto start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  // Not zeros, which some disks do not write.
  std::vector<char> bytes(1000 * 1000);
  std::uint32_t state = 1;
  for (char& byte : bytes)
    byte = static_cast<char>((state = state * 1664525U + 1013904223U) >> 24U);
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < kMegabytes; ++i)
    if (!file.write(bytes)) return std::nullopt;
  if (!file.sync()) return std::nullopt;
  DiskSpeed speed{.mb_s = kMegabytes / seconds_since(start)};
  bytes.resize(4096);
  std::vector<double> syncs;
  for (std::size_t i = 0; i < kSyncs; ++i) {
    const auto before = std::chrono::steady_clock::now();
    if (!file.write(bytes) || !file.sync()) return std::nullopt;
    syncs.push_back(seconds_since(before));
  }
  std::sort(syncs.begin(), syncs.end());
  speed.sync_s = syncs[kSyncs / 2];
  return speed;
}

}  // namespace

std::vector<Finding> examine_machine() {
  return {processor(), instruction_sets(), memory(), clock()};
}

std::vector<Finding> examine_disk(const std::filesystem::path& folder) {
  Finding f{.name = "disk", .details = {{"folder", folder.string()}}};
  const auto refuse = [&](int reason) {
    f.health = Health::Warning;
    f.value = folder.string() + ": cannot be written to: " + std::strerror(reason);
    f.remedy = "write maps to another folder (-o), or give this one room and permission";
    return std::vector<Finding>{f};
  };
  struct statvfs room {};
  if (::statvfs(folder.c_str(), &room) != 0) return refuse(errno);
  const double free_gb =
      static_cast<double>(room.f_bavail) * static_cast<double>(room.f_frsize) / 1e9;
  f.details["free_gb"] = free_gb;
  const auto speed = disk_speed(folder);
  if (!speed) return refuse(errno);
  f.details["write_mb_s"] = speed->mb_s;
  f.details["sync_s"] = speed->sync_s;
  f.value = text("%.1f GB free, writes %.0f MB/s, 4 kB are safe after %.1f ms", free_gb,
                 speed->mb_s, 1e3 * speed->sync_s);
  if (free_gb < kLeastDisk_gb) {
    f.health = Health::Warning;
    f.remedy = "free some room before a flight";
  } else if (speed->mb_s < kSlowestDisk_mb_s || speed->sync_s > kSlowestSync_s) {
    f.health = Health::Warning;
    f.remedy = "too slow to keep a live map safe each second: use another card or disk";
  }
  return {f};
}

}  // namespace watersky::cli
