// SPDX-License-Identifier: MIT
#pragma once
#include "watersky/io/inspect.hpp"

namespace watersky::detail {

/// What an MCAP file or a bag holds, topic by topic.
[[nodiscard]] Result<Inspection> inspect_messages(const std::filesystem::path& path);

}  // namespace watersky::detail
