// SPDX-License-Identifier: MIT
#pragma once
/// What an ArduPilot's own log (DataFlash, .bin) says about its motion.
#include "watersky/io/autopilot_log.hpp"

namespace watersky {

/// Reads a .bin. Times are TimeUS, taken to UTC by the GPS weeks of GPS records with a fix.
/// Attitude is from ATT, or where that is missing from the filter in use (XKQ, NKQ) or AHR2.
/// Position is the first of POS, the filter in use (XKF1, NKF1 with ORGN), AHR2 and GPS that
/// covers nine tenths of what the one that covers most does; a note names it and the others. The
/// gimbal is from MNT, ranges from RFND of a sensor that looks down. CAM records give times alone:
/// what they say of position and attitude is the state when they were written, up to 20 ms late.
/// InvalidInput when no FMT describes the records; NotFound when attitude or position is missing.
[[nodiscard]] Result<AutopilotLog> parse_dataflash(std::span<const std::uint8_t> bytes,
                                                   const std::string& name);

}  // namespace watersky
