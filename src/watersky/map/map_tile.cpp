// SPDX-License-Identifier: MIT
#include "watersky/map/map_tile.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

namespace watersky {

namespace {

static_assert(std::endian::native == std::endian::little, "encode() copies numbers as they lie");

constexpr std::size_t kBlockCount =
    static_cast<std::size_t>(MapTile::kBlocks) * static_cast<std::size_t>(MapTile::kBlocks);
static_assert(kBlockCount == 64, "encode() tells which blocks there are in 64 bits");

/// Lists of times have room for this many before they are looked through, and grow by as many.
constexpr std::size_t kFewTimes = 16;
/// Then times nearer to each other than this become one.
constexpr Duration kTimeGrain = std::chrono::milliseconds(100);

template <class T>
void put(std::vector<std::uint8_t>& out, const T* values, std::size_t count) {
  const std::size_t at = out.size();
  out.resize(at + count * sizeof(T));
  std::memcpy(out.data() + at, values, count * sizeof(T));
}

class Reader {
 public:
  Reader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}
  template <class T>
  [[nodiscard]] bool take(T* values, std::size_t count) {
    if (count * sizeof(T) > size_ - at_) return false;
    std::memcpy(values, bytes_ + at_, count * sizeof(T));
    at_ += count * sizeof(T);
    return true;
  }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] bool at_end() const { return at_ == size_; }

 private:
  const std::uint8_t* bytes_;
  std::size_t size_, at_ = 0;
};

}  // namespace

void MapTile::Block::drop_unused_times() {
  // In the middle of a footprint the last frame saw all cells.
  unsigned other = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) other |= (looks[i] == 0) | (seen[i] ^ seen[0]);
  if (other == 0) {
    times.front() = times[seen[0]];
    times.resize(1);
    seen.fill(0);
    return;
  }
  std::array<bool, kMostTimes> used{};
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (looks[i] != 0) used[seen[i]] = true;
  std::array<std::uint8_t, kMostTimes> moved{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!used[i]) continue;
    moved[i] = static_cast<std::uint8_t>(count);
    times[count++] = times[i];
  }
  if (count == times.size()) return;
  times.resize(count);
  for (std::size_t i = 0; i < seen.size(); ++i)
    seen[i] = looks[i] != 0 ? moved[seen[i]] : std::uint8_t{0};
}

void MapTile::Block::join_near_times() {
  std::array<std::uint8_t, kMostTimes> moved{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (count == 0 || times[i] - times[count - 1] >= kTimeGrain) times[count++] = times[i];
    moved[i] = static_cast<std::uint8_t>(count - 1);
  }
  if (count == times.size()) return;
  times.resize(count);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (looks[i] != 0) seen[i] = moved[seen[i]];
}

std::uint8_t MapTile::Block::place_of(Time time) {
  if (times.capacity() == 0) times.reserve(kFewTimes);
  if (!times.empty() && times.back() == time) return static_cast<std::uint8_t>(times.size() - 1);
  auto place = std::lower_bound(times.begin(), times.end(), time);
  if (place != times.end() && *place == time)
    return static_cast<std::uint8_t>(place - times.begin());
  // Times that no cell's last look has any more go before the list grows: most are gone by then,
  // and the list would otherwise take half as much memory as the cells.
  if (times.size() == kMostTimes ||
      (times.size() >= kFewTimes && times.size() == times.capacity())) {
    drop_unused_times();
    if (times.size() > kFewTimes / 2) join_near_times();
    if (times.size() + kFewTimes / 2 > times.capacity())
      times.reserve(std::min(kMostTimes, times.capacity() + kFewTimes));
    if (times.size() == kMostTimes) {
      std::size_t nearest = 1;
      for (std::size_t i = 2; i < times.size(); ++i)
        if (times[i] - times[i - 1] < times[nearest] - times[nearest - 1]) nearest = i;
      times.erase(times.begin() + static_cast<std::ptrdiff_t>(nearest));
      for (std::uint8_t& s : seen)
        if (s >= nearest) --s;
    }
    place = std::lower_bound(times.begin(), times.end(), time);
  }
  const auto at = static_cast<std::uint8_t>(place - times.begin());
  if (place != times.end())
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (looks[i] != 0 && seen[i] >= at) ++seen[i];
  times.insert(place, time);
  return at;
}

MapTile::MapTile(const MapTile& other) { *this = other; }

MapTile& MapTile::operator=(const MapTile& other) {
  if (this == &other) return *this;
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    blocks_[i] = other.blocks_[i] ? std::make_unique<Block>(*other.blocks_[i]) : nullptr;
  return *this;
}

MapTile::Block& MapTile::make_block(int block) {
  auto& b = blocks_[static_cast<std::size_t>(block)];
  if (!b) b = std::make_unique<Block>();
  return *b;
}

std::size_t MapTile::seen_cells() const {
  std::size_t count = 0;
  for (const auto& b : blocks_)
    if (b)
      count += static_cast<std::size_t>(
          std::count_if(b->looks.begin(), b->looks.end(), [](std::uint8_t l) { return l != 0; }));
  return count;
}

std::size_t MapTile::bytes() const {
  std::size_t size = sizeof(MapTile);
  for (const auto& b : blocks_)
    if (b) size += sizeof(Block) + b->times.capacity() * sizeof(Time);
  return size;
}

bool MapTile::operator==(const MapTile& other) const { return encode() == other.encode(); }

std::vector<std::uint8_t> MapTile::encode() const {
  std::uint64_t present = 0;
  std::vector<std::uint8_t> out;
  put(out, &present, 1);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!blocks_[i]) continue;
    Block block = *blocks_[i];
    block.drop_unused_times();
    if (block.times.empty()) continue;
    present |= std::uint64_t{1} << i;
    const auto count = static_cast<std::uint16_t>(block.times.size());
    put(out, &count, 1);
    for (const Time& t : block.times) {
      const std::int64_t ns = t.time_since_epoch().count();
      put(out, &ns, 1);
    }
    put(out, block.evidence.data(), block.evidence.size());
    put(out, block.looks.data(), block.looks.size());
    put(out, block.seen.data(), block.seen.size());
  }
  std::memcpy(out.data(), &present, sizeof present);
  return out;
}

Result<MapTile> MapTile::decode(const std::uint8_t* bytes, std::size_t size) {
  Reader reader(bytes, size);
  const auto fault = [&](const char* what) {
    return Error{ErrorCode::InvalidInput, "a tile of " + std::to_string(size) + " bytes " + what +
                                              " at byte " + std::to_string(reader.at())};
  };
  MapTile tile;
  std::uint64_t present = 0;
  if (!reader.take(&present, 1)) return fault("is cut short");
  for (std::size_t i = 0; i < kBlockCount; ++i) {
    if ((present >> i & 1) == 0) continue;
    std::uint16_t count = 0;
    if (!reader.take(&count, 1)) return fault("is cut short");
    if (count == 0 || count > kMostTimes) return fault("has an impossible number of times");
    Block& block = tile.make_block(static_cast<int>(i));
    for (std::uint16_t k = 0; k < count; ++k) {
      std::int64_t ns = 0;
      if (!reader.take(&ns, 1)) return fault("is cut short");
      const Time time{Duration(ns)};
      if (k > 0 && time <= block.times.back()) return fault("has times out of order");
      block.times.push_back(time);
    }
    if (!reader.take(block.evidence.data(), block.evidence.size()) ||
        !reader.take(block.looks.data(), block.looks.size()) ||
        !reader.take(block.seen.data(), block.seen.size()))
      return fault("is cut short");
    std::array<bool, kMostTimes> used{};
    for (std::size_t c = 0; c < block.looks.size(); ++c) {
      if (block.looks[c] == 0) {
        if (block.evidence[c] != 0 || block.seen[c] != 0) return fault("has values of no look");
      } else if (block.seen[c] >= count) {
        return fault("names a time that it does not list");
      } else {
        used[block.seen[c]] = true;
      }
    }
    if (std::count(used.begin(), used.end(), true) != count)
      return fault("lists a time of no cell");
  }
  if (!reader.at_end()) return fault("goes on after its end");
  return tile;
}

}  // namespace watersky
