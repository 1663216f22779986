// SPDX-License-Identifier: MIT
#pragma once
/// The last few chunks, unpacked: frames are asked for in their order by several threads.
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "watersky/base/bytes.hpp"
#include "watersky/base/result.hpp"

namespace watersky::detail {

class ChunkCache {
 public:
  /// The chunk at `offset`, made by `make` where it is not kept. Threads that want the same chunk
  /// at once may make it twice.
  template <class Make>
  Result<std::shared_ptr<const Bytes>> get(std::uint64_t offset, Make&& make) {
    {
      const std::lock_guard lock(mutex_);
      for (auto it = kept_.begin(); it != kept_.end(); ++it)
        if (it->first == offset) {
          kept_.splice(kept_.begin(), kept_, it);
          return kept_.front().second;
        }
    }
    Result<Bytes> made = make();
    if (!made) return made.error();
    const auto chunk = std::make_shared<const Bytes>(std::move(*made));
    const std::lock_guard lock(mutex_);
    kept_.emplace_front(offset, chunk);
    if (kept_.size() > kMost) kept_.pop_back();
    return chunk;
  }

 private:
  static constexpr std::size_t kMost = 4;
  std::mutex mutex_;
  std::list<std::pair<std::uint64_t, std::shared_ptr<const Bytes>>> kept_;  ///< latest first
};

}  // namespace watersky::detail
