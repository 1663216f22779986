// SPDX-License-Identifier: MIT
#include "watersky/store/detail/records.hpp"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <string>

namespace watersky::detail {

namespace {

/// Not ASCII, a line's end of each kind and an end of file: a transfer as text shows at once.
constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'W', 'S', 'M', '\r', '\n', 0x1a, '\n'};
constexpr std::uint32_t kRecordMagic = 0x63655257;  // "WRec"

std::string at(const StorageFile& file, std::uint64_t offset) {
  return file.path().string() + ": byte " + std::to_string(offset);
}

struct Head {
  std::uint32_t magic, size, salt;
  std::uint8_t kind;
  bool zeros;
  std::uint64_t sum;
};

Head parse_head(std::span<const std::uint8_t> b) {
  return {.magic = number_at<std::uint32_t>(b, 0),
          .size = number_at<std::uint32_t>(b, 8),
          .salt = number_at<std::uint32_t>(b, 12),
          .kind = b[4],
          .zeros = b[5] == 0 && b[6] == 0 && b[7] == 0,
          .sum = number_at<std::uint64_t>(b, 16)};
}

bool plausible(const Head& head, std::uint32_t salt) {
  return head.magic == kRecordMagic && head.salt == salt && head.zeros && head.kind >= 1 &&
         head.kind <= 6 && head.size <= kMostPayloadBytes;
}

std::uint64_t record_sum(std::span<const std::uint8_t> head,
                         std::span<const std::uint8_t> payload) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  XXH3_64bits_update(state.get(), head.data(), 16);
  XXH3_64bits_update(state.get(), payload.data(), payload.size());
  return XXH3_64bits_digest(state.get());
}

}  // namespace

std::uint64_t Record::end() const { return offset + record_bytes(payload.size()); }

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::uint32_t new_salt() { return std::random_device{}(); }

Bytes encode_preamble(const Preamble& preamble) {
  Bytes out(kMagic.begin(), kMagic.end());
  put(out, kFormatVersion);
  put(out, static_cast<std::uint16_t>(preamble.kind));
  put(out, preamble.salt);
  put(out, checksum(out));
  return out;
}

Result<Preamble> read_preamble(const StorageFile& file, FileKind expected) {
  const std::string name = file.path().string();
  std::array<std::uint8_t, kPreambleBytes> bytes{};
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), bytes.size()));
  WATERSKY_CHECK(file.read(0, std::span(bytes).first(size)));
  const std::size_t shown = std::min(size, kMagic.size());
  if (size == 0 || !std::equal(kMagic.begin(), kMagic.begin() + shown, bytes.begin()))
    return Error{ErrorCode::InvalidInput,
                 name + ": is no map of watersky; give a .wsmap file or a folder that holds one"};
  if (size < bytes.size())
    return Error{ErrorCode::InvalidInput,
                 name + ": is cut within its first " + std::to_string(kPreambleBytes) +
                     " bytes; nothing of it can be read, take another copy"};
  if (number_at<std::uint64_t>(bytes, 16) != checksum(std::span(bytes).first(16)))
    return Error{ErrorCode::InvalidInput,
                 name +
                     ": its first bytes are damaged (checksum at byte 16); take another copy, or "
                     "recover the tiles that are whole"};
  const auto version = number_at<std::uint16_t>(bytes, 8);
  if (version > kFormatVersion)
    return Error{ErrorCode::Unsupported, name + ": has version " + std::to_string(version) +
                                             " of the map format, this "
                                             "watersky reads up to " +
                                             std::to_string(kFormatVersion) +
                                             "; use a newer watersky"};
  const auto kind = number_at<std::uint16_t>(bytes, 10);
  if (version == 0 || kind != static_cast<std::uint16_t>(expected))
    return Error{ErrorCode::InvalidInput,
                 name + ": is " +
                     (kind == static_cast<std::uint16_t>(FileKind::Journal)
                          ? "a journal, not a map file; give the folder that it lies in"
                          : "not the kind of file that its name says")};
  return Preamble{expected, number_at<std::uint32_t>(bytes, 12)};
}

void append_record(Bytes& out, RecordKind kind, std::uint32_t salt,
                   std::span<const std::uint8_t> payload) {
  const std::size_t start = out.size();
  put(out, kRecordMagic);
  put(out, static_cast<std::uint32_t>(kind));
  put(out, static_cast<std::uint32_t>(payload.size()));
  put(out, salt);
  put(out, record_sum(std::span(out).subspan(start, 16), payload));
  out.insert(out.end(), payload.begin(), payload.end());
  out.resize(start + record_bytes(payload.size()));
}

Result<Record> read_record(const StorageFile& file, std::uint64_t offset, std::uint32_t salt) {
  const auto fault = [&](const char* what) {
    return Error{ErrorCode::InvalidInput, at(file, offset) + ": " + what};
  };
  if (offset > file.size() || file.size() - offset < kRecordHeadBytes)
    return fault("the file is cut here");
  std::array<std::uint8_t, kRecordHeadBytes> bytes{};
  WATERSKY_CHECK(file.read(offset, bytes));
  const Head head = parse_head(bytes);
  if (!plausible(head, salt)) return fault("no record of this file begins here");
  if (file.size() - offset < record_bytes(head.size)) return fault("the file is cut in a record");
  Record record{static_cast<RecordKind>(head.kind), offset, salt, Bytes(head.size)};
  WATERSKY_CHECK(file.read(offset + kRecordHeadBytes, record.payload));
  if (record_sum(bytes, record.payload) != head.sum)
    return fault("a record is damaged (its checksum does not match)");
  return record;
}

std::optional<Record> find_record(const StorageFile& file, std::uint64_t from,
                                  std::optional<std::uint32_t> salt) {
  constexpr std::uint64_t kWindow = std::uint64_t{1} << 20;
  std::uint64_t budget = 8 * file.size() + kWindow;
  Bytes window;
  for (std::uint64_t start = (from + 7) / 8 * 8; start + kRecordHeadBytes <= file.size();) {
    window.resize(static_cast<std::size_t>(std::min(kWindow, file.size() - start)));
    if (!file.read(start, window)) return std::nullopt;
    for (std::size_t i = 0; i + kRecordHeadBytes <= window.size(); i += 8) {
      const Head head = parse_head(std::span(window).subspan(i, kRecordHeadBytes));
      if (!plausible(head, salt.value_or(head.salt))) continue;
      if (auto record = read_record(file, start + i, head.salt)) return *std::move(record);
      if (head.size >= budget) return std::nullopt;
      budget -= head.size;
    }
    if (window.size() < kWindow) break;
    start += kWindow - kRecordHeadBytes;  // a multiple of 8
  }
  return std::nullopt;
}

}  // namespace watersky::detail
