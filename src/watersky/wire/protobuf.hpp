// SPDX-License-Identifier: MIT
#pragma once
/// Protobuf (proto3) of the messages of foxglove_messages.hpp and flight_messages.hpp, and the
/// descriptors that MCAP stores beside them.
///
///   const auto bytes = protobuf::encode(foxglove::LocationFix{…});
#include "watersky/base/result.hpp"
#include "watersky/wire/flight_messages.hpp"

namespace watersky::protobuf {

/// InvalidInput, naming type and byte. Unknown fields are skipped. Nothing larger than a small
/// multiple of the bytes is allocated; spans in it point into `bytes`.
template <class M>
[[nodiscard]] Result<M> decode(std::span<const std::uint8_t> bytes);

template <class M>
[[nodiscard]] std::vector<std::uint8_t> encode(const M& message);

struct Schema {
  std::string name;                       ///< "foxglove.LocationFix"
  std::vector<std::uint8_t> descriptors;  ///< a FileDescriptorSet with all that M needs
};

template <class M>
[[nodiscard]] Schema schema();

}  // namespace watersky::protobuf
