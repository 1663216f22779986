// SPDX-License-Identifier: MIT
#pragma once
/// MCAP: what a file consists of. mcap_reader.hpp and mcap_writer.hpp read and write it.
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "watersky/base/time.hpp"

namespace watersky::mcap {

struct Header {
  std::string profile;  ///< "", "ros1" or "ros2"
  std::string library;  ///< who wrote it
};

struct Schema {
  std::uint16_t id = 0;  ///< never 0
  std::string name;      ///< "sensor_msgs/Image", "foxglove.LocationFix"
  std::string encoding;  ///< "ros1msg", "ros2msg", "protobuf", "jsonschema" …
  std::vector<std::uint8_t> data;
  friend bool operator==(const Schema&, const Schema&) = default;
};

struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;  ///< 0: none
  std::string topic;
  std::string message_encoding;  ///< "ros1", "cdr", "protobuf", "json" …
  std::map<std::string, std::string> metadata;
  friend bool operator==(const Channel&, const Channel&) = default;
};

/// One message; `data` points into the reader's buffer and is gone with the call that got it. Times
/// beyond those that Time can carry (the year 2262) become the last that it can.
struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  Time log_time;      ///< when it was recorded
  Time publish_time;  ///< when it was sent
  std::span<const std::uint8_t> data;
};

/// Where a message lies: its chunk's record (or its own where it is in none), and in the chunk.
struct Location {
  static constexpr std::uint64_t kNoChunk = ~std::uint64_t{0};
  std::uint64_t record = 0;           ///< offset in the file
  std::uint64_t in_chunk = kNoChunk;  ///< offset in the chunk's uncompressed records
};

struct Attachment {
  std::string name;
  std::string media_type;
  Time log_time;
  Time create_time;
  std::vector<std::uint8_t> data;
};

struct Metadata {
  std::string name;
  std::map<std::string, std::string> values;
  friend bool operator==(const Metadata&, const Metadata&) = default;
};

struct ChunkIndex {
  Time first, last;                                              ///< log times in it
  std::uint64_t offset = 0;                                      ///< of the chunk's record
  std::uint64_t record_bytes = 0;                                ///< of it, head included
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;  ///< by channel
  std::uint64_t message_index_bytes = 0;
  std::string compression;
  std::uint64_t compressed_bytes = 0;
  std::uint64_t uncompressed_bytes = 0;
};

struct AttachmentIndex {
  std::uint64_t offset = 0;
  std::uint64_t record_bytes = 0;
  Time log_time, create_time;
  std::uint64_t data_bytes = 0;
  std::string name, media_type;
};

struct MetadataIndex {
  std::uint64_t offset = 0;
  std::uint64_t record_bytes = 0;
  std::string name;
};

struct Statistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  Time first, last;  ///< of log times; both zero without messages
  std::map<std::uint16_t, std::uint64_t> channel_messages;
};

}  // namespace watersky::mcap
