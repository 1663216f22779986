// SPDX-License-Identifier: MIT
#include "watersky/io/detail/message_file.hpp"

#include <algorithm>

#include "watersky/io/files.hpp"
#include "watersky/store/storage.hpp"
#include "watersky/wire/rosbag.hpp"

namespace watersky::detail {

namespace {

namespace fs = std::filesystem;

/// A file of any size, read where it is asked for.
class FileSource final : public ByteSource {
 public:
  explicit FileSource(std::unique_ptr<StorageFile> file) : file_(std::move(file)) {}
  [[nodiscard]] std::uint64_t size() const override { return file_->size(); }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
    return file_->read(offset, into);
  }

 private:
  std::unique_ptr<StorageFile> file_;
};

/// "sensor_msgs/msg/Image" → "sensor_msgs/Image".
std::string plain_type(std::string type) {
  const auto at = type.find("/msg/");
  if (at != std::string::npos) type.erase(at, 4);
  return type;
}

void append(std::vector<std::string>& notes, const std::vector<Damage>& damage) {
  // A file cut to pieces need not be told of piece by piece.
  constexpr std::size_t kMost = 10;
  for (const Damage& d : damage) {
    if (notes.size() == kMost) {
      notes.push_back("and " + std::to_string(damage.size() - kMost) + " more such places");
      return;
    }
    notes.push_back(to_string(d));
  }
}

class McapFile final : public MessageFile {
 public:
  McapFile(fs::path file, mcap::Reader reader) : reader_(std::move(reader)) {
    path_ = std::move(file);
    append(notes_, reader_.damage());
    for (const auto& [id, c] : reader_.channels()) {
      const auto schema = reader_.schemas().find(c.schema);
      MessageChannel channel{
          id, c.topic, schema == reader_.schemas().end() ? "" : plain_type(schema->second.name),
          MessageEncoding::Other, c.message_encoding};
      if (c.message_encoding == "ros1") channel.encoding = MessageEncoding::Ros1;
      if (c.message_encoding == "cdr") channel.encoding = MessageEncoding::Cdr;
      if (c.message_encoding == "protobuf") channel.encoding = MessageEncoding::Protobuf;
      channels_.push_back(std::move(channel));
    }
  }
  [[nodiscard]] std::string container() const override {
    return reader_.header().profile.empty() ? "MCAP" : "MCAP, profile " + reader_.header().profile;
  }
  [[nodiscard]] Result<std::vector<std::string>> for_each(
      const std::function<void(const RecordedMessage&)>& use,
      const std::set<std::uint32_t>& channels) const override {
    std::map<std::uint16_t, const MessageChannel*> by_id;
    mcap::Selection selection;
    selection.channels.emplace();
    for (const MessageChannel& c : channels_)
      if (channels.contains(c.id)) {
        by_id.emplace(static_cast<std::uint16_t>(c.id), &c);
        selection.channels->insert(static_cast<std::uint16_t>(c.id));
      }
    const auto damage = reader_.for_each(
        [&](const mcap::Message& m, const mcap::Location& where) {
          use({*by_id.at(m.channel), m.log_time, m.sequence, m.data, where});
        },
        selection);
    if (!damage) return damage.error().at(path_.string());
    std::vector<std::string> notes;
    append(notes, *damage);
    return notes;
  }
  [[nodiscard]] Result<std::vector<std::uint8_t>> read(const mcap::Location& where) const override {
    auto data = reader_.read(where);
    if (!data) return data.error().at(path_.string());
    return data;
  }
  [[nodiscard]] const mcap::Reader* mcap() const override { return &reader_; }

 private:
  mcap::Reader reader_;
};

class BagFile final : public MessageFile {
 public:
  BagFile(fs::path file, rosbag::Reader reader) : reader_(std::move(reader)) {
    path_ = std::move(file);
    append(notes_, reader_.damage());
    for (const auto& [id, c] : reader_.connections())
      channels_.push_back({id, c.topic, c.type, MessageEncoding::Ros1, "ros1"});
  }
  [[nodiscard]] std::string container() const override { return "bag"; }
  [[nodiscard]] Result<std::vector<std::string>> for_each(
      const std::function<void(const RecordedMessage&)>& use,
      const std::set<std::uint32_t>& channels) const override {
    std::map<std::uint32_t, const MessageChannel*> by_id;
    for (const MessageChannel& c : channels_) by_id.emplace(c.id, &c);
    const auto damage = reader_.for_each(
        [&](const rosbag::Message& m, const rosbag::Location& where) {
          use({*by_id.at(m.connection), m.time, 0, m.data, {where.record, where.in_chunk}});
        },
        channels);
    if (!damage) return damage.error().at(path_.string());
    std::vector<std::string> notes;
    append(notes, *damage);
    return notes;
  }
  [[nodiscard]] Result<std::vector<std::uint8_t>> read(const mcap::Location& where) const override {
    auto data = reader_.read({where.record, where.in_chunk});
    if (!data) return data.error().at(path_.string());
    return data;
  }

 private:
  rosbag::Reader reader_;
};

static_assert(mcap::Location::kNoChunk == rosbag::Location::kNoChunk);

}  // namespace

void add_new_notes(std::vector<std::string>& notes, const std::vector<std::string>& more) {
  for (const std::string& note : more)
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

bool is_message_file(const fs::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".mcap" || extension == ".bag" || extension == ".active";
}

Result<std::shared_ptr<const MessageFile>> MessageFile::open(const fs::path& file) {
  WATERSKY_TRY(auto opened, disk().open(file, FileAccess::Read));
  const auto source = std::make_shared<FileSource>(std::move(opened));
  if (lower_extension(file) == ".mcap") {
    auto reader = mcap::Reader::open(source);
    if (!reader) return reader.error().at(file.string());
    return std::shared_ptr<const MessageFile>(std::make_shared<McapFile>(file, std::move(*reader)));
  }
  auto reader = rosbag::Reader::open(source);
  if (!reader) return reader.error().at(file.string());
  return std::shared_ptr<const MessageFile>(std::make_shared<BagFile>(file, std::move(*reader)));
}

}  // namespace watersky::detail
