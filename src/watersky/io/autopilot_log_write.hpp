// SPDX-License-Identifier: MIT
#pragma once
/// A flight as an autopilot would have logged it: for those whose tools read logs, and to try
/// readers with flights whose truth is known.
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "watersky/flight/flight.hpp"
#include "watersky/io/autopilot_log.hpp"

namespace watersky {

enum class LogFormat {
  Tlog,       ///< MAVLink telemetry: times to a millisecond, places to 1e-7°, heights to 1 mm
  DataFlash,  ///< ArduPilot's .bin: times to a microsecond, places to 1e-7°
  Lsf         ///< DUNE: neither gimbal nor image times, which IMC has no message for
};

/// Poses of the trajectory, or of the frames that bring their own; gimbal, ranges, and for each
/// frame, in order, when it was taken (or, where that is not known, received). Heights go to EGM96.
/// NotFound for a flight without poses.
[[nodiscard]] Result<AutopilotLog> autopilot_log_of(const Flight& flight);

/// What parse_tlog(), parse_dataflash() or parse_lsf() read, to the quantisation of the format.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_log(const AutopilotLog& log,
                                                           LogFormat format);

}  // namespace watersky
