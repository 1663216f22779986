// SPDX-License-Identifier: MIT
#include "watersky/wire/compression.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>

#include "watersky/base/bytes.hpp"

namespace watersky {

namespace {

/// Fast, as a recorder on board must be; images do not shrink anyway.
constexpr int kZstdLevel = 1;
constexpr int kBz2Level = 9;  // what rosbag writes
constexpr std::size_t kFirstGrowth = std::size_t{1} << 16;

Error bad(std::string message) { return {ErrorCode::InvalidInput, std::move(message)}; }

/// The output of a decompressor: grown as it fills, to `size` bytes at most.
class Output {
 public:
  Output(std::uint64_t size, std::size_t compressed) : size_(size) {
    bytes_.resize(static_cast<std::size_t>(
        std::min<std::uint64_t>(size, std::max<std::size_t>(kFirstGrowth, 4 * compressed))));
  }
  /// Where the next bytes go; empty when all are there.
  std::span<std::uint8_t> room() {
    if (used_ == bytes_.size() && bytes_.size() < size_)
      bytes_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(size_, 2 * bytes_.size())));
    return std::span(bytes_).subspan(used_);
  }
  void filled(std::size_t n) { used_ += n; }
  [[nodiscard]] bool whole() const { return used_ == size_; }
  Result<Bytes> take() {
    if (!whole())
      return bad("unfolds to " + std::to_string(used_) + " bytes instead of " +
                 std::to_string(size_));
    return std::move(bytes_);
  }

 private:
  std::uint64_t size_;
  Bytes bytes_;
  std::size_t used_ = 0;
};

Error too_long(std::uint64_t size) {
  return bad("unfolds to more than the " + std::to_string(size) + " bytes that it claims");
}

Result<Bytes> from_zstd(std::span<const std::uint8_t> bytes, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  Output out(size, bytes.size());
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  std::uint8_t beyond = 0;  // where a byte goes that should not come
  std::size_t left = 1;
  while (in.pos < in.size || left != 0) {
    const auto room = out.room();
    ZSTD_outBuffer to =
        room.empty() ? ZSTD_outBuffer{&beyond, 1, 0} : ZSTD_outBuffer{room.data(), room.size(), 0};
    const std::size_t before = in.pos;
    left = ZSTD_decompressStream(context.get(), &to, &in);
    if (ZSTD_isError(left)) return bad(std::string("is no zstd (") + ZSTD_getErrorName(left) + ")");
    if (room.empty() && to.pos > 0) return too_long(size);
    if (!room.empty()) out.filled(to.pos);
    if (to.pos == 0 && in.pos == before) return bad("is a zstd frame cut short");
  }
  return out.take();
}

Result<Bytes> from_lz4(std::span<const std::uint8_t> bytes, std::uint64_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)))
    return Error{ErrorCode::Io, "lz4 cannot be started"};
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  Output out(size, bytes.size());
  std::uint8_t beyond = 0;
  std::size_t left = 1;
  while (!bytes.empty() || left != 0) {
    const auto room = out.room();
    std::size_t written = room.empty() ? 1 : room.size(), read = bytes.size();
    left = LZ4F_decompress(context.get(), room.empty() ? &beyond : room.data(), &written,
                           bytes.data(), &read, nullptr);
    if (LZ4F_isError(left))
      return bad(std::string("is no LZ4 frame (") + LZ4F_getErrorName(left) + ")");
    if (room.empty() && written > 0) return too_long(size);
    if (!room.empty()) out.filled(written);
    bytes = bytes.subspan(read);
    if (written == 0 && read == 0) return bad("is an LZ4 frame cut short");
  }
  return out.take();
}

Result<Bytes> from_bz2(std::span<const std::uint8_t> bytes, std::uint64_t size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK)
    return Error{ErrorCode::Io, "bzip2 cannot be started"};
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> closing(&stream,
                                                                           &BZ2_bzDecompressEnd);
  if (bytes.size() > std::numeric_limits<unsigned>::max()) return bad("is larger than 4 GiB");
  stream.next_in = reinterpret_cast<char*>(const_cast<std::uint8_t*>(bytes.data()));
  stream.avail_in = static_cast<unsigned>(bytes.size());
  Output out(size, bytes.size());
  char beyond = 0;
  for (int state = BZ_OK; state != BZ_STREAM_END;) {
    const auto room = out.room();
    const unsigned before_in = stream.avail_in;
    const unsigned offered = room.empty() ? 1
                                          : static_cast<unsigned>(std::min<std::size_t>(
                                                room.size(), std::numeric_limits<unsigned>::max()));
    stream.next_out = room.empty() ? &beyond : reinterpret_cast<char*>(room.data());
    stream.avail_out = offered;
    state = BZ2_bzDecompress(&stream);
    if (state != BZ_OK && state != BZ_STREAM_END)
      return bad("is no bzip2 stream (error " + std::to_string(state) + ")");
    const unsigned written = offered - stream.avail_out;
    if (room.empty() && written > 0) return too_long(size);
    if (!room.empty()) out.filled(written);
    if (state == BZ_OK && written == 0 && stream.avail_in == before_in)
      return bad("is a bzip2 stream cut short");
  }
  return out.take();
}

}  // namespace

std::string_view to_string(Compression compression) {
  switch (compression) {
    case Compression::None: return "none";
    case Compression::Lz4: return "lz4";
    case Compression::Zstd: return "zstd";
    case Compression::Bz2: return "bz2";
  }
  return "none";
}

Result<Bytes> compress(Compression compression, std::span<const std::uint8_t> bytes) {
  Bytes out;
  switch (compression) {
    case Compression::None: return Bytes(bytes.begin(), bytes.end());
    case Compression::Zstd: {
      out.resize(ZSTD_compressBound(bytes.size()));
      const std::size_t n =
          ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
      if (ZSTD_isError(n)) return Error{ErrorCode::Io, "zstd fails for want of memory"};
      out.resize(n);
      return out;
    }
    case Compression::Lz4: {
      out.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
      const std::size_t n =
          LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
      if (LZ4F_isError(n)) return Error{ErrorCode::Io, "lz4 fails for want of memory"};
      out.resize(n);
      return out;
    }
    case Compression::Bz2: {
      if (bytes.size() > std::numeric_limits<unsigned>::max() / 2)
        return Error{ErrorCode::Unsupported, "bzip2 takes 2 GiB at once at most"};
      out.resize(bytes.size() + bytes.size() / 100 + 600);  // bzlib's own bound
      auto n = static_cast<unsigned>(out.size());
      // bzlib takes no null pointer, and wants to write to what it only reads.
      const std::uint8_t nothing = 0;
      auto* from = const_cast<std::uint8_t*>(bytes.empty() ? &nothing : bytes.data());
      if (BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(out.data()), &n,
                                   reinterpret_cast<char*>(from),
                                   static_cast<unsigned>(bytes.size()), kBz2Level, 0, 0) != BZ_OK)
        return Error{ErrorCode::Io, "bzip2 fails for want of memory"};
      out.resize(n);
      return out;
    }
  }
  return out;
}

Result<Bytes> decompress(Compression compression, std::span<const std::uint8_t> bytes,
                         std::uint64_t size) {
  switch (compression) {
    case Compression::Lz4: return from_lz4(bytes, size);
    case Compression::Zstd: return from_zstd(bytes, size);
    case Compression::Bz2: return from_bz2(bytes, size);
    case Compression::None: break;
  }
  if (bytes.size() != size)
    return bad("holds " + std::to_string(bytes.size()) + " bytes instead of " +
               std::to_string(size));
  return Bytes(bytes.begin(), bytes.end());
}

std::uint32_t crc32_of(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  if (bytes.empty()) return crc;  // zlib would begin anew for a null pointer
  return static_cast<std::uint32_t>(crc32_z(crc, bytes.data(), bytes.size()));
}

}  // namespace watersky
