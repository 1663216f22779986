// SPDX-License-Identifier: MIT
#pragma once
/// Another program at work for us: its output through pipes, gone when this object goes.
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "watersky/base/result.hpp"

namespace watersky::detail {

/// A file descriptor that is closed once.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) {
      close();
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] bool open() const { return fd_ >= 0; }
  void close();

 private:
  int fd_;
};

using LineHandler = std::function<void(std::string_view line)>;

/// Standard input is empty; no shell is involved, so arguments mean what they say. Moving apart,
/// it is one process's: not safe for several threads at once.
class ChildProcess {
 public:
  /// `arguments[0]` is looked up in PATH. NotFound, naming `package`, when it is not installed.
  [[nodiscard]] static Result<ChildProcess> start(const std::vector<std::string>& arguments,
                                                  const std::string& package);
  /// Kills it if it still runs, and reaps it.
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  /// Fills `into` from standard output; fewer bytes only where that has ended. Lines of standard
  /// error that were written before the last of those bytes have been handed to `on_line` when
  /// this returns. Io when the program has said nothing for two minutes.
  [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> into, const LineHandler& on_line);

 private:
  ChildProcess(pid_t pid, Descriptor out, Descriptor err, std::string program);
  void take_errors(const LineHandler& on_line);

  pid_t pid_ = -1;
  Descriptor out_, err_;
  std::string program_;
  std::string line_;  ///< of standard error, not ended yet
};

}  // namespace watersky::detail
