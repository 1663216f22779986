// SPDX-License-Identifier: MIT
#include "watersky/io/detail/files.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace watersky::detail {

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
    return Error{ErrorCode::Io, file.string() + ": cannot be opened (" + std::strerror(errno) + ")"};
  const std::streamoff size = in.tellg();
  if (size < 0) return Error{ErrorCode::Io, file.string() + ": cannot be read"};
  if (static_cast<std::size_t>(size) > max_bytes)
    return Error{ErrorCode::InvalidInput,
                 file.string() + ": is larger than " + std::to_string(max_bytes) + " bytes"};
  Container out(static_cast<std::size_t>(size), typename Container::value_type{});
  in.seekg(0);
  in.read(reinterpret_cast<char*>(out.data()), size);
  if (in.gcount() != size) return Error{ErrorCode::Io, file.string() + ": cannot be read to its end"};
  return out;
}

}  // namespace

Result<std::string> read_text(const fs::path& file, std::size_t max_bytes) {
  return read_all<std::string>(file, max_bytes);
}

Result<std::vector<std::uint8_t>> read_bytes(const fs::path& file, std::size_t max_bytes) {
  return read_all<std::vector<std::uint8_t>>(file, max_bytes);
}

Status write_file(const fs::path& file, std::string_view bytes) {
  fs::path temporary = file;
  temporary += ".part" + std::to_string(::getpid());
  const auto fail = [&](const std::string& why) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    return Error{ErrorCode::Io, file.string() + ": cannot be written (" + why + ")"};
  };
  {
    std::ofstream out(temporary, std::ios::binary);
    if (!out) return fail(std::strerror(errno));
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) return fail("is the disk full?");
  }
  std::error_code ec;
  fs::rename(temporary, file, ec);
  if (ec) return fail(ec.message());
  return {};
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
  if (ec) return Error{ErrorCode::Io, folder.string() + ": cannot be listed (" + ec.message() + ")"};
  std::vector<fs::path> out;
  for (const auto end = fs::directory_iterator(); it != end; it.increment(ec)) {
    if (ec) return Error{ErrorCode::Io, folder.string() + ": cannot be listed (" + ec.message() + ")"};
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

}  // namespace watersky::detail
