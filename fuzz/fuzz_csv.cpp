// SPDX-License-Identifier: MIT
/// Poses, gimbal attitudes and RTK marks as text.
#include <cstdint>

#include "watersky/io/csv.hpp"
#include "watersky/io/flight_folder.hpp"
#include "watersky/io/name_time.hpp"
#include "watersky/io/photo_flight.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace watersky;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> notes;
  (void)CsvTable::parse(text, "fuzz.csv");
  (void)first_place_of_poses_csv(text, "poses.csv");
  if (auto poses = parse_poses_csv(text, "poses.csv", Datum(Geodetic{}), notes)) {
    // What the reader lets through the trajectory must take.
    if (!Trajectory::make(std::move(*poses))) __builtin_trap();
  }
  if (auto rotations = parse_gimbal_csv(text, "gimbal.csv");
      rotations && !RotationTrack::make(std::move(*rotations)))
    __builtin_trap();
  (void)parse_rtk_marks(text);
  (void)utc_from_name(text);
  (void)parse_time_seconds(text);
  return 0;
}
