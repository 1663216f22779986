// SPDX-License-Identifier: MIT
#include "opencl_check.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <string_view>

#include "watersky/vision/opencl.hpp"

namespace watersky::cli {

namespace {

using Clock = std::chrono::steady_clock;

/// A driver that talks without end is cut off here.
constexpr std::size_t kMostOutput = 1 << 20;
constexpr double kUsualTimeout_s = 120.0;

/// This program with other arguments: its standard output, and how it ended.
class Child {
 public:
  static Result<Child> start() {
    int out[2];
    if (::pipe2(out, O_CLOEXEC) != 0) return system_error("no pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    char program[] = "/proc/self/exe", verb[] = "doctor", option[] = "--opencl-child";
    char* const arguments[] = {program, verb, option, nullptr};
    pid_t pid = -1;
    errno = ::posix_spawn(&pid, program, &actions, nullptr, arguments, environ);
    const int spawned = errno;
    posix_spawn_file_actions_destroy(&actions);
    ::close(out[1]);
    if (spawned != 0) {
      ::close(out[0]);
      errno = spawned;
      return system_error("this program cannot start itself again");
    }
    return Child(pid, out[0]);
  }
  ~Child() {
    if (out_ >= 0) ::close(out_);
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }
  Child(Child&& other) noexcept
      : pid_(std::exchange(other.pid_, -1)), out_(std::exchange(other.out_, -1)) {}
  Child& operator=(Child&&) = delete;

  /// All that it prints until it ends; false when the deadline came first.
  bool read_until(Clock::time_point deadline, std::string& text) {
    for (char buffer[4096];;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
      pollfd waiting{out_, POLLIN, 0};
      const int ready = left > 0 ? ::poll(&waiting, 1, static_cast<int>(left)) : 0;
      if (ready < 0 && errno == EINTR) continue;
      if (ready <= 0) return false;
      const ssize_t n = ::read(out_, buffer, sizeof buffer);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return true;
      text.append(buffer, static_cast<std::size_t>(n));
      if (text.size() > kMostOutput) return false;
    }
  }
  /// Its wait status, nullopt when it has not ended by the deadline.
  std::optional<int> wait_until(Clock::time_point deadline) {
    for (int status = 0;;) {
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return status;
      }
      if (Clock::now() >= deadline) return std::nullopt;
      ::usleep(5000);
    }
  }

 private:
  Child(pid_t pid, int out) : pid_(pid), out_(out) {}
  static Error system_error(const char* what) {
    return {ErrorCode::Io, std::string(what) + ": " + std::strerror(errno)};
  }
  pid_t pid_;
  int out_;
};

OpenClDevice device_from(const nlohmann::json& j) {
  OpenClDevice device{.platform = j.value("platform", ""),
                      .name = j.value("name", ""),
                      .version = j.value("version", ""),
                      .driver = j.value("driver", ""),
                      .refusal = j.value("refusal", "")};
  for (const nlohmann::json& c : j.value("comparisons", nlohmann::json::array())) {
    const nlohmann::json difference = c.value("max_difference", nlohmann::json());
    device.comparisons.push_back({.operation = c.value("operation", ""),
                                  .max_difference = difference.is_number()
                                                        ? difference.get<double>()
                                                        : std::numeric_limits<double>::quiet_NaN(),
                                  .bound = c.value("bound", 0.0)});
  }
  return device;
}

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) {
    const char* name = ::sigabbrev_np(WTERMSIG(status));
    return std::string("died of SIG") + (name ? name : "?");
  }
  return "ended with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

bool OpenClDevice::agrees() const {
  return !comparisons.empty() && std::all_of(comparisons.begin(), comparisons.end(),
                                             [](const OpenClComparison& c) { return c.agrees(); });
}

Result<OpenClCheck> check_opencl(double timeout_s) {
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(timeout_s));
  WATERSKY_TRY(Child child, Child::start());
  std::string text;
  const bool closed = child.read_until(deadline, text);
  const std::optional<int> status = closed ? child.wait_until(deadline) : std::nullopt;

  OpenClCheck check;
  std::string step = "starting";
  bool done = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const auto line =
        nlohmann::json::parse(text.begin() + static_cast<std::ptrdiff_t>(at),
                              text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    at = end + 1;
    if (!line.is_object()) continue;  // drivers print, too
    step = line.value("step", step);
    done = done || line.contains("done");
    if (line.contains("device")) check.devices.push_back(device_from(line["device"]));
  }
  if (done) step = "leaving";
  char limit[40];
  std::snprintf(limit, sizeof limit, "%.3g s", timeout_s);
  if (!status) {
    check.fault = std::string("hangs (more than ") + limit + ") while " + step;
  } else if (const int ended = status.value_or(0); !done || ended != 0) {
    check.fault = how_it_ended(ended) + " while " + step;
  }
  return check;
}

Status use_opencl_if_sound() {
  const auto refuse = [](const std::string& why) {
    return Error{ErrorCode::Unsupported,
                 "--opencl: " + why + "; see watersky doctor, or leave --opencl out"};
  };
  WATERSKY_TRY(const OpenClCheck check, check_opencl(kUsualTimeout_s));
  if (!check.fault.empty()) return refuse("a driver " + check.fault);
  if (check.devices.empty()) return refuse("there is no OpenCL device");
  for (const OpenClDevice& device : check.devices)
    if (!device.agrees()) return refuse(device.name + " does not compute what the processor does");
  return use_opencl(true);
}

}  // namespace watersky::cli
