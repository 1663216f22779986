// SPDX-License-Identifier: MIT
#include "watersky/io/files.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

namespace watersky {

namespace fs = std::filesystem;

namespace {

template <class Container>
Result<Container> read_all(const fs::path& file, std::size_t max_bytes) {
  std::error_code ec;
  if (!fs::exists(file, ec))
    return Error{ErrorCode::NotFound, file.string() + ": there is no such file"};
  if (fs::is_directory(file, ec))
    return Error{ErrorCode::InvalidInput, file.string() + ": is a folder, not a file"};
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in)
    return Error{ErrorCode::Io,
                 file.string() + ": cannot be opened (" + std::strerror(errno) + ")"};
  const std::streamoff size = in.tellg();
  if (size < 0) return Error{ErrorCode::Io, file.string() + ": cannot be read"};
  if (static_cast<std::size_t>(size) > max_bytes)
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": is larger than " + std::to_string(max_bytes) + " bytes"};
  Container out(static_cast<std::size_t>(size), typename Container::value_type{});
  in.seekg(0);
  in.read(reinterpret_cast<char*>(out.data()), size);
  if (in.gcount() != size)
    return Error{ErrorCode::Io, file.string() + ": cannot be read to its end"};
  return out;
}

}  // namespace

Result<std::string> read_text(const fs::path& file, std::size_t max_bytes) {
  return read_all<std::string>(file, max_bytes);
}

Result<std::vector<std::uint8_t>> read_bytes(const fs::path& file, std::size_t max_bytes) {
  return read_all<std::vector<std::uint8_t>>(file, max_bytes);
}

Status write_file(const fs::path& path, std::string_view bytes) {
  WATERSKY_TRY(PartialFile file, PartialFile::beside(path));
  WATERSKY_CHECK(file.append({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
  return file.publish();
}

PartialFile::PartialFile(fs::path target, fs::path path, std::FILE* file)
    : target_(std::move(target)), path_(std::move(path)), file_(file) {}

PartialFile::PartialFile(PartialFile&& other) noexcept
    : target_(std::move(other.target_)),
      path_(std::exchange(other.path_, {})),
      file_(std::exchange(other.file_, nullptr)) {}

PartialFile::~PartialFile() {
  if (file_) std::fclose(file_);
  std::error_code ignored;
  if (!path_.empty()) fs::remove(path_, ignored);
}

Error PartialFile::refused(int error) const {
  return {ErrorCode::Io, target_.string() + ": cannot be written: " + std::strerror(error) +
                             "; free space there, or choose another output"};
}

Result<PartialFile> PartialFile::beside(const fs::path& target) {
  fs::path part = target;
  part += ".part" + std::to_string(::getpid());
  PartialFile file(target, part, std::fopen(part.c_str(), "w+b"));
  if (!file.file_) return file.refused(errno);
  return file;
}

Status PartialFile::append(std::span<const std::uint8_t> bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) return refused(errno);
  return {};
}

Status PartialFile::overwrite_beginning(std::span<const std::uint8_t> bytes) {
  if (std::fseek(file_, 0, SEEK_SET) != 0) return refused(errno);
  WATERSKY_CHECK(append(bytes));
  if (std::fseek(file_, 0, SEEK_END) != 0) return refused(errno);
  return {};
}

Status PartialFile::publish() {
  // A full disk may show only when the last buffer is flushed by closing.
  if (std::fclose(std::exchange(file_, nullptr)) != 0) return refused(errno);
  std::error_code renamed;
  fs::rename(path_, target_, renamed);
  if (renamed) return refused(renamed.value());
  path_.clear();
  return {};
}

fs::path resolved(const fs::path& path) {
  const fs::path absolute = fs::absolute(path).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string lower_extension(const fs::path& file) { return lower(file.extension().string()); }

Result<std::vector<fs::path>> files_with_extension(
    const fs::path& folder, std::initializer_list<std::string_view> extensions) {
  std::error_code ec;
  fs::directory_iterator it(folder, ec);
  if (ec)
    return Error{ErrorCode::Io, folder.string() + ": cannot be listed (" + ec.message() + ")"};
  std::vector<fs::path> out;
  for (const auto end = fs::directory_iterator(); it != end; it.increment(ec)) {
    if (ec)
      return Error{ErrorCode::Io, folder.string() + ": cannot be listed (" + ec.message() + ")"};
    const fs::path& file = it->path();
    if (file.filename().string().starts_with('.')) continue;
    std::error_code ignored;
    if (!it->is_regular_file(ignored)) continue;
    const std::string extension = lower_extension(file);
    if (std::find(extensions.begin(), extensions.end(), extension) != extensions.end())
      out.push_back(file);
  }
  std::sort(out.begin(), out.end());
  return out;
}

PartialFolder::PartialFolder(fs::path asked, fs::path target)
    : asked_(std::move(asked)), target_(std::move(target)) {
  path_ = target_.parent_path() /
          ("." + target_.filename().string() + ".part" + std::to_string(::getpid()));
}

PartialFolder::PartialFolder(PartialFolder&& other) noexcept
    : asked_(std::move(other.asked_)),
      target_(std::move(other.target_)),
      path_(std::exchange(other.path_, {})),
      first_made_(std::exchange(other.first_made_, {})) {}

PartialFolder::~PartialFolder() { take_back(); }

void PartialFolder::take_back() {
  std::error_code error;
  if (!path_.empty()) fs::remove_all(path_, error);
  // Folders made above the target go again, but only while they are empty: somebody else may have
  // put something there meanwhile.
  if (first_made_.empty()) return;
  for (fs::path p = target_.parent_path(); fs::remove(p, error) && p != first_made_;)
    p = p.parent_path();
}

namespace {

Error refused(const fs::path& folder, const std::error_code& error) {
  return {ErrorCode::Io, folder.string() + ": cannot be written: " + error.message() +
                             "; choose another folder, or free space there"};
}

/// Removes what earlier runs for the same target left behind when they were killed.
void remove_leftovers(const fs::path& target) {
  const std::string prefix = "." + target.filename().string() + ".part";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(target.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(prefix, 0) != 0) continue;
    const std::string pid = name.substr(prefix.size());
    if (pid.empty() || pid.size() > 9 || pid.find_first_not_of("0123456789") != std::string::npos)
      continue;
    if (::kill(static_cast<pid_t>(std::stol(pid)), 0) == 0 || errno != ESRCH) continue;
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

Result<PartialFolder> PartialFolder::beside(const fs::path& asked) {
  const fs::path target = resolved(asked);
  PartialFolder folder(asked, target);
  std::error_code error;
  remove_leftovers(target);
  for (fs::path p = target.parent_path(); !p.empty() && !fs::exists(p, error); p = p.parent_path())
    folder.first_made_ = p;
  fs::create_directories(target.parent_path(), error);
  if (error) return refused(asked, error);
  fs::remove_all(folder.path_, error);
  fs::create_directory(folder.path_, error);
  if (error) return refused(asked, error);
  return folder;
}

Status PartialFolder::publish() {
  std::error_code error, ignored;
  fs::path aside;
  if (fs::exists(fs::symlink_status(target_, error))) {
    aside = target_.parent_path() /
            ("." + target_.filename().string() + ".old" + std::to_string(::getpid()));
    fs::rename(target_, aside, error);
    if (error) return refused(asked_, error);
  }
  fs::rename(path_, target_, error);
  if (error) {
    if (!aside.empty()) fs::rename(aside, target_, ignored);
    return refused(asked_, error);
  }
  path_.clear();
  first_made_.clear();
  if (!aside.empty()) fs::remove_all(aside, ignored);
  return {};
}

}  // namespace watersky
