// SPDX-License-Identifier: MIT
#pragma once
/// A flight with its metadata read in another way.
#include "watersky/align/metadata_check.hpp"

namespace watersky::detail {

/// Takes the fault of `finding` out of a flight. Attitudes are the gimbal's where it is recorded
/// against north, east, down (the body's do not count then), else the body's.
[[nodiscard]] Status apply(const MetadataFinding& finding, Flight& flight);

/// The place in the native image of a pixel of one that is stored turned.
[[nodiscard]] Pixel native_pixel(const Pixel& stored, int quarter_turns, int width_px,
                                 int height_px);

}  // namespace watersky::detail
