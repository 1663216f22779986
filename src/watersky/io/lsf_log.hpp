// SPDX-License-Identifier: MIT
#pragma once
/// What DUNE's log (LSF) says about a vehicle's motion.
#include "watersky/io/autopilot_log.hpp"
#include "watersky/wire/imc_schema.hpp"

namespace watersky {

/// Reads an unpacked LSF. The vehicle is the system with most EstimatedStates; both styles are
/// understood: a reference that stays with x, y, z that move, and one that moves with the vehicle.
/// What DUNE says before it knows where it is (about 0, 0) is left out. Heights are above the
/// ellipsoid, as EstimatedState has them, and are taken to EGM96 here. Times are those of the
/// packets; where GpsFix messages show that DUNE's clock was more than half a second off, they
/// are corrected and a note says so. Ranges are Distances of a device that looks down. IMC has no
/// message for a gimbal or a camera's shutter. NotFound when no system sent EstimatedState.
[[nodiscard]] Result<AutopilotLog> parse_lsf(std::span<const std::uint8_t> bytes,
                                             const imc::Schema& schema, const std::string& name);

}  // namespace watersky
