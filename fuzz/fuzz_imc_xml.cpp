// SPDX-License-Identifier: MIT
/// A log's own IMC.xml.
#include <cstdint>
#include <cstdlib>

#include "watersky/wire/imc_schema.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const auto schema = imc::Schema::from_xml({reinterpret_cast<const char*>(data), size});
  if (!schema) return 0;
  for (const imc::MessageInfo& message : schema->messages())
    if (schema->find(message.id) != &message || schema->find(message.name) != &message)
      std::abort();
  return 0;
}
