// SPDX-License-Identifier: MIT
#pragma once
/// An MCAP file or a bag: messages on topics, whatever holds them.
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "watersky/base/time.hpp"
#include "watersky/wire/mcap_reader.hpp"

namespace watersky::detail {

enum class MessageEncoding { Ros1, Cdr, Protobuf, Other };

struct MessageChannel {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;  ///< "sensor_msgs/Image" in ROS 1 and 2, "foxglove.LocationFix"
  MessageEncoding encoding = MessageEncoding::Other;
  std::string encoding_name;
};

/// `data` is gone with the call that got it.
struct RecordedMessage {
  const MessageChannel& channel;
  Time log_time;
  std::uint32_t sequence = 0;  ///< MCAP only
  std::span<const std::uint8_t> data;
  mcap::Location where;
};

class MessageFile {
 public:
  virtual ~MessageFile() = default;
  /// By name: .bag, else MCAP. Errors name the file.
  [[nodiscard]] static Result<std::shared_ptr<const MessageFile>> open(
      const std::filesystem::path& file);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const std::vector<MessageChannel>& channels() const { return channels_; }
  /// What is damaged, one sentence each; met while opening.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  [[nodiscard]] virtual std::string container() const = 0;  ///< "MCAP, profile ros2", "bag"

  /// In the order of the file, of the channels with these ids. Returns what could not be read, one
  /// sentence each.
  [[nodiscard]] virtual Result<std::vector<std::string>> for_each(
      const std::function<void(const RecordedMessage&)>& use,
      const std::set<std::uint32_t>& channels) const = 0;
  /// A message's data; may be called from several threads.
  [[nodiscard]] virtual Result<std::vector<std::uint8_t>> read(
      const mcap::Location& where) const = 0;
  /// nullptr when it is a bag.
  [[nodiscard]] virtual const mcap::Reader* mcap() const { return nullptr; }

 protected:
  std::filesystem::path path_;
  std::vector<MessageChannel> channels_;
  std::vector<std::string> notes_;
};

/// Those of `more` that are not there yet: a pass over a file meets what opening it met.
void add_new_notes(std::vector<std::string>& notes, const std::vector<std::string>& more);

/// Whether the name ends in .mcap, .bag or .active (a bag whose recorder crashed).
[[nodiscard]] bool is_message_file(const std::filesystem::path& file);

}  // namespace watersky::detail
