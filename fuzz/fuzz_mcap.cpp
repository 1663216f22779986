// SPDX-License-Identifier: MIT
/// MCAP files: read by their summary and without it, every message, attachment and metadata record;
/// what is read can be written and comes back.
#include <cstdint>
#include <cstdlib>

#include "watersky/wire/mcap_reader.hpp"
#include "watersky/wire/mcap_writer.hpp"

namespace {

using namespace watersky;

constexpr mcap::ReaderOptions kLimits{.max_record_bytes = 1 << 20};

std::size_t read_all(const std::shared_ptr<const ByteSource>& source, bool use_summary,
                     mcap::Writer* copy) {
  mcap::ReaderOptions options = kLimits;
  options.use_summary = use_summary;
  const auto reader = mcap::Reader::open(source, options);
  if (!reader) {
    if (reader.error().message.find("byte ") == std::string::npos) std::abort();
    return 0;
  }
  for (const auto& index : reader->attachments()) (void)reader->read(index).ok();
  for (const auto& index : reader->metadata()) (void)reader->read(index).ok();
  std::map<std::uint16_t, std::uint16_t> channels;
  if (copy)
    for (const auto& [id, channel] : reader->channels()) {
      mcap::Channel own = channel;
      own.schema = 0;
      channels[id] = *copy->add_channel(own);
    }
  std::size_t n = 0;
  const auto damage = reader->for_each([&](const mcap::Message& m, const mcap::Location& where) {
    if (++n > 2000) return;
    const auto again = reader->read(where);
    if (!again || !std::equal(again->begin(), again->end(), m.data.begin(), m.data.end()))
      std::abort();
    if (copy) {
      mcap::Message out = m;
      out.channel = channels.at(m.channel);
      if (!copy->write(out)) std::abort();
    }
  });
  if (!damage) std::abort();  // memory does not fail to be read
  return std::min<std::size_t>(n, 2000);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto source = std::make_shared<MemorySource>(std::vector<std::uint8_t>(data, data + size));
  read_all(source, true, nullptr);
  std::vector<std::uint8_t> file;
  auto copy = *mcap::Writer::open(
      [&](std::span<const std::uint8_t> bytes) {
        file.insert(file.end(), bytes.begin(), bytes.end());
        return Status();
      },
      {.profile = "", .library = "", .compression = Compression::None, .chunk_bytes = 1 << 16});
  const std::size_t n = read_all(source, false, &copy);
  if (!copy.close()) std::abort();
  if (file.size() < (1 << 20) &&
      read_all(std::make_shared<MemorySource>(std::move(file)), true, nullptr) != n)
    std::abort();
  return 0;
}
