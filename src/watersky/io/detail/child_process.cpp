// SPDX-License-Identifier: MIT
#include "watersky/io/detail/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

extern char** environ;

namespace watersky::detail {

namespace {

/// A program that is silent this long hangs; ffprobe on a slow disk is not silent.
constexpr int kPatience_ms = 120'000;
constexpr std::size_t kMaxLine = 4096;

struct Pipe {
  Descriptor read, write;
};

Result<Pipe> make_pipe() {
  int fds[2];
  if (::pipe2(fds, O_CLOEXEC) != 0)
    return Error{ErrorCode::Io,
                 std::string("a pipe cannot be made (") + std::strerror(errno) + ")"};
  return Pipe{Descriptor(fds[0]), Descriptor(fds[1])};
}

}  // namespace

void Descriptor::close() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

ChildProcess::ChildProcess(pid_t pid, Descriptor out, Descriptor err, std::string program)
    : pid_(pid), out_(std::move(out)), err_(std::move(err)), program_(std::move(program)) {}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      out_(std::move(other.out_)),
      err_(std::move(other.err_)),
      program_(std::move(other.program_)),
      line_(std::move(other.line_)) {}

ChildProcess::~ChildProcess() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& arguments,
                                         const std::string& package) {
  WATERSKY_REQUIRE(!arguments.empty());
  WATERSKY_TRY(Pipe out, make_pipe());
  WATERSKY_TRY(Pipe err, make_pipe());
  for (const Descriptor* end : {&out.read, &err.read}) ::fcntl(end->fd(), F_SETFL, O_NONBLOCK);

  std::vector<char*> argv;
  for (const std::string& a : arguments)
    argv.push_back(const_cast<char*>(a.c_str()));  // NOLINT: exec's old signature
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.write.fd(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write.fd(), STDERR_FILENO);
  // Should we die by force, the child must die of its broken pipe, even where we ignore ours.
  sigset_t pipe_signal, none;
  sigemptyset(&pipe_signal);
  sigaddset(&pipe_signal, SIGPIPE);
  sigemptyset(&none);
  posix_spawnattr_setsigdefault(&attributes, &pipe_signal);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  pid_t pid = -1;
  const int failed = posix_spawnp(&pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (failed == ENOENT)
    return Error{ErrorCode::NotFound,
                 arguments[0] + " is not installed; install the package " + package};
  if (failed != 0)
    return Error{ErrorCode::Io,
                 arguments[0] + " cannot be started (" + std::strerror(failed) + ")"};
  return ChildProcess(pid, std::move(out.read), std::move(err.read), arguments[0]);
}

void ChildProcess::take_errors(const LineHandler& on_line) {
  std::array<char, 4096> buffer;
  while (err_.open()) {
    const ssize_t n = ::read(err_.fd(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return;
    for (const char c : std::string_view(buffer.data(), n > 0 ? static_cast<std::size_t>(n) : 0)) {
      if (c == '\n' || c == '\r') {
        if (!line_.empty()) on_line(line_);
        line_.clear();
      } else if (line_.size() < kMaxLine) {
        line_ += c;
      }
    }
    if (n <= 0) {
      if (!line_.empty()) on_line(line_);
      line_.clear();
      err_.close();
    }
  }
}

Result<std::size_t> ChildProcess::read(std::span<std::uint8_t> into, const LineHandler& on_line) {
  std::size_t filled = 0;
  while (filled < into.size() && (out_.open() || err_.open())) {
    // poll() passes over descriptors below zero: those that have ended.
    std::array<pollfd, 2> ends{{{out_.fd(), POLLIN, 0}, {err_.fd(), POLLIN, 0}}};
    const int ready = ::poll(ends.data(), ends.size(), kPatience_ms);
    if (ready < 0 && errno == EINTR) continue;
    if (ready < 0)
      return Error{ErrorCode::Io, program_ + " cannot be read from (" + std::strerror(errno) + ")"};
    if (ready == 0)
      return Error{ErrorCode::Io, program_ + " has said nothing for two minutes and was stopped"};
    if (ends[1].revents != 0) take_errors(on_line);
    if (ends[0].revents == 0) continue;
    const ssize_t n = ::read(out_.fd(), into.data() + filled, into.size() - filled);
    if (n > 0)
      filled += static_cast<std::size_t>(n);
    else if (n == 0 || (errno != EINTR && errno != EAGAIN))
      out_.close();
  }
  take_errors(on_line);
  return filled;
}

}  // namespace watersky::detail
