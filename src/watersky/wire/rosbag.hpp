// SPDX-License-Identifier: MIT
#pragma once
/// ROS 1 bags, version 2.0: read by their index where there is a good one, else by going through
/// them once, as a recorder that crashed leaves none; and written. What is damaged is left out and
/// told; the rest is read.
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "watersky/base/time.hpp"
#include "watersky/wire/byte_source.hpp"
#include "watersky/wire/compression.hpp"

namespace watersky::rosbag {

/// Who published what on a topic.
struct Connection {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;        ///< "sensor_msgs/Image"
  std::string md5sum;      ///< of the type's definition
  std::string definition;  ///< with those of the types in it
  std::string caller;      ///< the node's name; may be empty
  bool latching = false;
};

/// One message in ROS 1's serialisation; `data` is gone with the call that got it.
struct Message {
  std::uint32_t connection = 0;
  Time time;  ///< when it was received
  std::span<const std::uint8_t> data;
};

/// Where a message lies: its chunk's record (or its own where it is in none), and in the chunk.
struct Location {
  static constexpr std::uint64_t kNoChunk = ~std::uint64_t{0};
  std::uint64_t record = 0;
  std::uint64_t in_chunk = kNoChunk;
};

struct Chunk {
  std::uint64_t offset = 0;  ///< of its record in the file
  Time first, last;
  std::map<std::uint32_t, std::uint32_t> messages;  ///< by connection
};

struct ReaderOptions {
  /// Records and chunks that claim more are damage. What is allocated grows with what is there.
  std::uint64_t max_record_bytes = std::uint64_t{1} << 30;
};

class Reader {
 public:
  /// InvalidInput, naming the byte, when it is no bag of version 2.0; Unsupported when encrypted.
  [[nodiscard]] static Result<Reader> open(std::shared_ptr<const ByteSource> source,
                                           const ReaderOptions& options = {});

  /// Whether the index was used.
  [[nodiscard]] bool indexed() const { return indexed_; }
  [[nodiscard]] const std::map<std::uint32_t, Connection>& connections() const {
    return connections_;
  }
  /// In the order of the file.
  [[nodiscard]] const std::vector<Chunk>& chunks() const { return chunks_; }
  /// How many messages of each connection.
  [[nodiscard]] const std::map<std::uint32_t, std::uint64_t>& counts() const { return counts_; }
  /// What was met while opening.
  [[nodiscard]] const std::vector<Damage>& damage() const { return damage_; }

  /// Calls `use` for the messages of the chosen connections (all: nullopt) in the order of the
  /// file. Returns what could not be read. Io as the source says.
  [[nodiscard]] Result<std::vector<Damage>> for_each(
      const std::function<void(const Message&, const Location&)>& use,
      const std::optional<std::set<std::uint32_t>>& connections = std::nullopt) const;

  /// A message's data alone. May be called from several threads.
  [[nodiscard]] Result<std::vector<std::uint8_t>> read(const Location& location) const;

 private:
  struct Cache;
  struct Record;
  using Use = std::function<void(const Message&, const Location&)>;

  Reader(std::shared_ptr<const ByteSource> source, const ReaderOptions& options);
  /// false: there is none, or damage_ says what is wrong with it.
  [[nodiscard]] Result<bool> read_index(std::uint64_t index_offset);
  [[nodiscard]] Status scan();
  [[nodiscard]] Status walk(std::uint64_t from, const std::function<bool(const Record&)>& use,
                            std::vector<Damage>& damage) const;
  [[nodiscard]] Result<std::vector<std::uint8_t>> record_at(std::uint64_t offset) const;
  [[nodiscard]] Result<std::vector<std::uint8_t>> unpacked(const Record& chunk) const;
  void add_connection(const Record& record);

  std::shared_ptr<const ByteSource> source_;
  ReaderOptions options_;
  bool indexed_ = false;
  std::map<std::uint32_t, Connection> connections_;
  std::vector<Chunk> chunks_;
  std::map<std::uint32_t, std::uint64_t> counts_;
  std::vector<Damage> damage_;
  std::shared_ptr<Cache> cache_;
};

struct WriterOptions {
  Compression compression = Compression::None;  ///< None, Lz4 or Bz2
  std::size_t chunk_bytes = std::size_t{768} << 10;
};

/// Writes a bag: as a recorder would, so that what a crash leaves is an un-indexed bag.
class Writer {
 public:
  /// Sends the beginning of the file. Usage for a compression that bags have not.
  [[nodiscard]] static Result<Writer> open(ByteSink sink, WriterOptions options = {});

  /// Gives the id; the one in the argument does not count.
  [[nodiscard]] Result<std::uint32_t> add_connection(Connection connection);
  /// NotFound for a connection that was not added. Times before 1970 become 1970, ROS has none.
  [[nodiscard]] Status write(const Message& message);
  [[nodiscard]] Status flush();
  /// Sends the index. What it returns is to be written over the file's first bytes: it says where
  /// the index is.
  [[nodiscard]] Result<std::vector<std::uint8_t>> close();

 private:
  Writer(ByteSink sink, WriterOptions options)
      : sink_(std::move(sink)), options_(std::move(options)) {}
  [[nodiscard]] Status send(std::span<const std::uint8_t> bytes);

  struct Entry {
    Time time;
    std::uint32_t offset;
  };

  ByteSink sink_;
  WriterOptions options_;
  std::optional<Error> failed_;
  std::uint64_t sent_ = 0;
  std::vector<std::uint8_t> chunk_;
  std::map<std::uint32_t, std::vector<Entry>> entries_;
  std::vector<Connection> connections_;  ///< by id
  std::vector<Chunk> chunks_;
};

}  // namespace watersky::rosbag
