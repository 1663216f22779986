// SPDX-License-Identifier: MIT
#include "watersky/store/storage.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace watersky {

namespace fs = std::filesystem;

namespace {

Error refused(const fs::path& file, const char* what, int error) {
  std::string message = file.string() + ": cannot be " + what + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT) message += "; free space there, or choose another folder";
  if (error == EACCES || error == EROFS || error == EPERM)
    message += "; give a folder that may be written";
  return {error == ENOENT ? ErrorCode::NotFound : ErrorCode::Io, std::move(message)};
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

class PosixFile final : public StorageFile {
 public:
  PosixFile(fs::path path, int fd, std::uint64_t size)
      : path_(std::move(path)), fd_(fd), size_(size) {}

  [[nodiscard]] const fs::path& path() const override { return path_; }
  [[nodiscard]] std::uint64_t size() const override { return size_; }

  Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
    while (!into.empty()) {
      const ssize_t got = ::pread(fd_.get(), into.data(), into.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return refused(path_, "read", errno);
      if (got == 0)
        return Error{ErrorCode::OutOfRange,
                     path_.string() + ": ends before byte " + std::to_string(offset)};
      offset += static_cast<std::uint64_t>(got);
      into = into.subspan(static_cast<std::size_t>(got));
    }
    return {};
  }

  Status append(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t put =
          ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(size_));
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) return refused(path_, "written", errno);
      size_ += static_cast<std::uint64_t>(put);
      bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
    return {};
  }

  Status truncate(std::uint64_t size) override {
    if (::ftruncate(fd_.get(), static_cast<off_t>(size)) != 0) return refused(path_, "cut", errno);
    size_ = size;
    return {};
  }

  Status sync() override {
    // The size counts as data here: fdatasync brings it along when a read needs it.
    if (::fdatasync(fd_.get()) != 0) return refused(path_, "brought to the disk", errno);
    return {};
  }

 private:
  fs::path path_;
  Descriptor fd_;
  std::uint64_t size_;
};

class PosixLock final : public StorageLock {
 public:
  explicit PosixLock(int fd) : fd_(fd) {}

 private:
  Descriptor fd_;
};

class Disk final : public Storage {
 public:
  Result<std::unique_ptr<StorageFile>> open(const fs::path& file, FileAccess access) override {
    const int flags = access == FileAccess::Read     ? O_RDONLY
                      : access == FileAccess::Append ? O_RDWR
                                                     : O_RDWR | O_CREAT | O_TRUNC;
    const int fd = ::open(file.c_str(), flags | O_CLOEXEC, 0666);
    if (fd < 0) return refused(file, access == FileAccess::Create ? "made" : "opened", errno);
    struct stat found {};
    if (::fstat(fd, &found) != 0 || !S_ISREG(found.st_mode)) {
      ::close(fd);
      return Error{ErrorCode::InvalidInput, file.string() + ": is not a file"};
    }
    return std::unique_ptr<StorageFile>(
        std::make_unique<PosixFile>(file, fd, static_cast<std::uint64_t>(found.st_size)));
  }

  Result<std::vector<std::string>> list(const fs::path& folder) override {
    std::error_code error;
    fs::directory_iterator it(folder, error);
    std::vector<std::string> names;
    for (; !error && it != fs::directory_iterator(); it.increment(error))
      names.push_back(it->path().filename().string());
    if (error) return refused(folder, "listed", error.value());
    std::sort(names.begin(), names.end());
    return names;
  }

  Status make_folder(const fs::path& folder) override {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return refused(folder, "made", error.value());
    return {};
  }

  Status rename(const fs::path& from, const fs::path& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) return refused(to, "put in its place", errno);
    return {};
  }

  Status remove(const fs::path& file) override {
    if (::unlink(file.c_str()) != 0) return refused(file, "removed", errno);
    return {};
  }

  Status sync_folder(const fs::path& folder) override {
    const fs::path named = folder.empty() ? fs::path(".") : folder;
    const Descriptor fd(::open(named.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd.get() < 0) return refused(named, "opened", errno);
    // Some file systems (FAT, network shares) have no fsync for folders and say EINVAL.
    if (::fsync(fd.get()) != 0 && errno != EINVAL)
      return refused(named, "brought to the disk", errno);
    return {};
  }

  Result<std::unique_ptr<StorageLock>> lock(const fs::path& folder) override {
    const fs::path file = folder / "lock";
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0) return refused(file, "made", errno);
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      ::close(fd);
      if (error == EWOULDBLOCK)
        return Error{ErrorCode::Exists, folder.string() +
                                            ": another process writes this map; end it, or choose "
                                            "another folder"};
      return refused(file, "locked", error);
    }
    return std::unique_ptr<StorageLock>(std::make_unique<PosixLock>(fd));
  }
};

class MemoryFileOfMap final : public StorageFile {
 public:
  MemoryFileOfMap(fs::path path, std::vector<std::uint8_t> bytes)
      : path_(std::move(path)), bytes_(std::move(bytes)) {}

  [[nodiscard]] const fs::path& path() const override { return path_; }
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
    if (offset > bytes_.size() || into.size() > bytes_.size() - offset)
      return Error{ErrorCode::OutOfRange,
                   path_.string() + ": ends before byte " + std::to_string(offset + into.size())};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
    return {};
  }
  Status append(std::span<const std::uint8_t> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return {};
  }
  Status truncate(std::uint64_t size) override {
    bytes_.resize(static_cast<std::size_t>(size));
    return {};
  }
  Status sync() override { return {}; }

 private:
  fs::path path_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

Storage& disk() {
  static Disk instance;
  return instance;
}

std::unique_ptr<StorageFile> memory_file(fs::path name, std::vector<std::uint8_t> bytes) {
  return std::make_unique<MemoryFileOfMap>(std::move(name), std::move(bytes));
}

}  // namespace watersky
