// SPDX-License-Identifier: MIT
#pragma once
/// A flight as photographs with an autopilot's log beside them: what people have who never heard
/// of flight folders.
#include <filesystem>
#include <string>
#include <vector>

#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"
#include "watersky/io/autopilot_log_write.hpp"
#include "watersky/io/recording_write.hpp"

namespace watersky {

struct WrittenLogFlight {
  std::vector<LeftOut> left_out;
  /// What a log has no record for and has to be told when the flight is read again, as options of
  /// `watersky map`: "--mount 0,-90,0".
  std::vector<std::string> options;
};

/// Makes `folder` with flight.tlog, flight.bin or Data.lsf, camera.yaml, and each frame as a
/// photograph that is named by when it was taken (or, where only that is known, received), in
/// microseconds since 1970. Times, heights and places are to the quantisation of the format. Frames
/// without a time are left out, as are those that cannot be read. NotFound for a flight without
/// poses; Exists as write_mcap_flight() has it.
[[nodiscard]] Result<WrittenLogFlight> write_log_flight(const Flight& flight,
                                                        const std::filesystem::path& folder,
                                                        LogFormat format,
                                                        const WriteRecordingOptions& options = {},
                                                        const Progress& progress = {});

}  // namespace watersky
