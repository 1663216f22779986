// SPDX-License-Identifier: MIT
#include "watersky/store/detail/compression.hpp"

#include <zstd.h>

#include <memory>
#include <new>

namespace watersky::detail {

namespace {

/// The fastest that still codes by entropy: unsaturated evidence is mostly noise, in which higher
/// levels would look for repeats that are not there.
constexpr int kLevel = 1;

ZSTD_CCtx* compressor() {
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                                  &ZSTD_freeCCtx);
  return context.get();
}
ZSTD_DCtx* decompressor() {
  thread_local const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                                  &ZSTD_freeDCtx);
  return context.get();
}

}  // namespace

Bytes compress(std::span<const std::uint8_t> bytes) {
  Bytes out(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compressCCtx(compressor(), out.data(), out.size(), bytes.data(), bytes.size(), kLevel);
  // With a buffer of ZSTD_compressBound bytes it fails for want of memory alone.
  if (ZSTD_isError(size)) throw std::bad_alloc();
  out.resize(size);
  return out;
}

Result<Bytes> decompress(std::span<const std::uint8_t> bytes, std::size_t size) {
  Bytes out(size);
  const std::size_t got =
      ZSTD_decompressDCtx(decompressor(), out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(got) || got != size)
    return Error{ErrorCode::InvalidInput, "compressed bytes do not unfold to their size"};
  return out;
}

}  // namespace watersky::detail
