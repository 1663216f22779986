// SPDX-License-Identifier: MIT
#include "watersky/wire/gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

namespace watersky {

bool is_gzip(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 2 && bytes[0] == 0x1F && bytes[1] == 0x8B;
}

Result<Gunzipped> gunzip(std::span<const std::uint8_t> bytes, std::size_t max_bytes) {
  if (!is_gzip(bytes))
    return Error{ErrorCode::InvalidInput, "byte 0: is no gzip, which begins with 1f 8b"};
  constexpr std::size_t kStep = std::size_t{1} << 18;
  constexpr int kGzipOnly = 16;
  Gunzipped out;
  z_stream stream{};
  if (inflateInit2(&stream, kGzipOnly + MAX_WBITS) != Z_OK)
    return Error{ErrorCode::Io, "no memory to unpack gzip"};
  const std::unique_ptr<z_stream, decltype(&inflateEnd)> end(&stream, inflateEnd);

  std::size_t at = 0;
  std::vector<std::uint8_t> piece(kStep);
  for (;;) {
    const std::size_t given =
        std::min<std::size_t>(bytes.size() - at, std::numeric_limits<uInt>::max());
    // zlib does not write through next_in.
    stream.next_in = const_cast<Bytef*>(bytes.data() + at);
    stream.avail_in = static_cast<uInt>(given);
    stream.next_out = piece.data();
    stream.avail_out = static_cast<uInt>(piece.size());
    const int status = inflate(&stream, Z_NO_FLUSH);
    at += given - stream.avail_in;
    const std::size_t made = piece.size() - stream.avail_out;
    if (made > max_bytes - out.bytes.size())
      return Error{ErrorCode::OutOfRange, "byte " + std::to_string(at) + ": unpacks to more than " +
                                              std::to_string(max_bytes) +
                                              " bytes; unpack it to a file and split that"};
    out.bytes.insert(out.bytes.end(), piece.begin(),
                     piece.begin() + static_cast<std::ptrdiff_t>(made));
    out.stopped_at = at;
    if (status == Z_STREAM_END) {
      if (at == bytes.size()) return out;
      if (!is_gzip(bytes.subspan(at)) || inflateReset(&stream) != Z_OK) break;
    } else if (status != Z_OK || (at == bytes.size() && made == 0)) {
      break;
    }
  }
  out.whole = false;
  return out;
}

}  // namespace watersky
