// SPDX-License-Identifier: MIT
/// IMC packets: any bytes as they are, and as the payload of a packet whose size and CRC are right,
/// which a fuzzer seldom finds. What decodes encodes again to the same bytes.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "watersky/base/bytes.hpp"
#include "watersky/wire/imc.hpp"

using namespace watersky;

namespace {

void decode(const imc::Packet& packet) {
  const auto& schema = imc::Schema::builtin();
  const auto view = imc::View::make(packet, schema);
  const auto message = imc::Message::decode(packet, schema);
  if (view.ok() != message.ok()) std::abort();
  if (!message) return;
  for (const imc::FieldInfo& field : packet.info->fields)
    if (field.type <= imc::FieldType::F64) (void)view->number(field.name);
  const auto again = imc::encode(*message, packet.header, packet.order);
  if (!again || !std::ranges::equal(*again, packet.bytes)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto& schema = imc::Schema::builtin();
  const std::span bytes(data, size);
  const auto step = imc::parse_packet(bytes, schema);
  if (step.outcome == imc::ParseOutcome::Packet) decode(step.packet);

  // The first byte: order of bytes and which message.
  constexpr std::size_t kMaxPayload = imc::kMaxPacketBytes - imc::kHeaderBytes - imc::kFooterBytes;
  if (size < 2 || size > kMaxPayload) return 0;
  const auto messages = schema.messages();
  const auto& info = messages[(data[0] | (data[1] & 0x7F) << 8) % messages.size()];
  const bool big = (data[1] & 0x80) != 0;
  Bytes packet;
  const auto put16 = [&](std::size_t value) {
    const auto x = static_cast<std::uint16_t>(value);
    put(packet, big ? static_cast<std::uint16_t>(x << 8 | x >> 8) : x);
  };
  put16(imc::kSync);
  put16(info.id);
  put16(size - 2);
  packet.resize(imc::kHeaderBytes);
  packet.insert(packet.end(), data + 2, data + size);
  put16(imc::crc(packet));
  const auto whole = imc::parse_packet(packet, schema);
  if (whole.outcome != imc::ParseOutcome::Packet) std::abort();
  decode(whole.packet);
  return 0;
}
