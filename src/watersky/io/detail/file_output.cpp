// SPDX-License-Identifier: MIT
#include "watersky/io/detail/file_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

namespace watersky::io::detail {

namespace fs = std::filesystem;

Status write_file(const fs::path& path, std::string_view bytes) {
  fs::path part = path;
  part += ".part-" + std::to_string(::getpid());
  const auto refused = [&](int error) {
    std::error_code ignored;
    fs::remove(part, ignored);
    return Error{ErrorCode::Io, path.string() + ": cannot be written: " + std::strerror(error) +
                                    "; free space there, or choose another output"};
  };
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (!file) return refused(errno);
  // A full disk may show only when the last buffer is flushed by closing.
  const bool wrote = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int write_error = errno;
  const bool closed = std::fclose(file) == 0;
  if (!wrote) return refused(write_error);
  if (!closed) return refused(errno);
  std::error_code renamed;
  fs::rename(part, path, renamed);
  if (renamed) return refused(renamed.value());
  return {};
}

}  // namespace watersky::io::detail
