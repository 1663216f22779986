// SPDX-License-Identifier: MIT
#include <algorithm>
#include <map>

#include "watersky/io/detail/message_content.hpp"
#include "watersky/io/detail/message_inspection.hpp"
#include "watersky/io/files.hpp"
#include "watersky/wire/protobuf.hpp"
#include "watersky/wire/ros.hpp"

namespace watersky::detail {

namespace {

std::optional<std::pair<double, double>> place_of(const RecordedMessage& m) {
  if (m.channel.type == "sensor_msgs/NavSatFix") {
    const auto fix = ros::decode<ros::NavSatFix>(
        m.channel.encoding == MessageEncoding::Ros1 ? ros::Encoding::Ros1 : ros::Encoding::Cdr,
        m.data);
    if (fix && fix->status.status >= 0) return std::pair(fix->latitude, fix->longitude);
  } else if (m.channel.type == "foxglove.LocationFix") {
    const auto fix = protobuf::decode<foxglove::LocationFix>(m.data);
    if (fix) return std::pair(fix->latitude, fix->longitude);
  }
  return std::nullopt;
}

std::string seconds_text(Duration d) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", to_seconds(d));
  return text;
}

}  // namespace

Result<Inspection> inspect_messages(const std::filesystem::path& path) {
  WATERSKY_TRY(const auto file, MessageFile::open(path));
  Inspection out;
  out.kind = file->mcap() ? "mcap" : "rosbag";
  out.facts["container"] = file->container();
  out.notes = file->notes();

  struct Seen {
    std::size_t n = 0, backward = 0;
    Time first, last;
    Duration longest_gap{0};
  };
  std::map<std::uint32_t, Seen> seen;
  std::set<std::uint32_t> all;
  for (const MessageChannel& c : file->channels()) all.insert(c.id);
  WATERSKY_TRY(const auto damage,
               file->for_each(
                   [&](const RecordedMessage& m) {
                     Seen& s = seen[m.channel.id];
                     if (s.n++ == 0) {
                       s.first = m.log_time;
                     } else {
                       if (m.log_time < s.last) ++s.backward;
                       s.longest_gap = std::max(s.longest_gap, m.log_time - s.last);
                     }
                     s.last = m.log_time;
                     out.first = out.first ? std::min(*out.first, m.log_time) : m.log_time;
                     out.last = out.last ? std::max(*out.last, m.log_time) : m.log_time;
                     if (const auto place = place_of(m)) {
                       if (!out.extent) out.extent.emplace();
                       out.extent->add(place->first, place->second);
                     }
                   },
                   all));
  add_new_notes(out.notes, damage);
  for (const MessageChannel& c : file->channels()) {
    const Seen& s = seen[c.id];
    out.counts[c.topic] += s.n;
    out.facts["topic " + c.topic] = (c.type.empty() ? "no type" : c.type) + ", " + c.encoding_name;
    if (s.n > 1 && s.last > s.first) {
      const double span_s = to_seconds(s.last - s.first);
      out.rates_hz[c.topic] = static_cast<double>(s.n - 1) / span_s;
      // Ten times the usual interval is a gap worth telling of.
      const double usual_s = span_s / static_cast<double>(s.n - 1);
      if (s.n > 10 && to_seconds(s.longest_gap) > 10 * usual_s)
        out.notes.push_back(c.topic + ": the longest gap is " + seconds_text(s.longest_gap));
    }
    if (s.backward > 0)
      out.notes.push_back(c.topic + ": the recorder's clock runs backwards " +
                          std::to_string(s.backward) + " times");
  }
  if (file->mcap())
    for (const mcap::AttachmentIndex& a : file->mcap()->attachments())
      out.facts["attachment " + a.name] = std::to_string(a.data_bytes) + " bytes";
  return out;
}

}  // namespace watersky::detail
