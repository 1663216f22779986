// SPDX-License-Identifier: MIT
#include "watersky/wire/byte_source.hpp"

#include <cstring>

namespace watersky {

Status MemorySource::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
  if (offset > bytes_.size() || into.size() > bytes_.size() - offset)
    return Error{ErrorCode::OutOfRange, "byte " + std::to_string(offset) + ": " +
                                            std::to_string(into.size()) + " bytes are wanted and " +
                                            std::to_string(bytes_.size()) + " are all there are"};
  if (!into.empty()) std::memcpy(into.data(), bytes_.data() + offset, into.size());
  return {};
}

std::string to_string(const Damage& damage) {
  return "byte " + std::to_string(damage.offset) + ": " + damage.reason;
}

}  // namespace watersky
