// SPDX-License-Identifier: MIT
#pragma once
/// flight.yaml and the flight that it describes: of a flight folder, and in our MCAP recordings.
#include "watersky/io/flight_folder.hpp"

namespace watersky::detail {

/// The flight without its frames, poses and gimbal's attitudes: camera's source, mount, sea level,
/// readout and delay, by the description and the options. `camera` is of the description's file,
/// or of the options'.
[[nodiscard]] Result<Flight> described_flight(const FlightDescription& description,
                                              std::string name, const Datum& datum,
                                              const CameraModel& camera,
                                              const ReadOptions& options);

/// parse_flight_yaml undoes it. Unsupported when the sea level follows neither the ellipsoid nor
/// the geoid.
[[nodiscard]] Result<std::string> flight_yaml(const Flight& flight);

}  // namespace watersky::detail
