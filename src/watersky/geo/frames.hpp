// SPDX-License-Identifier: MIT
#pragma once
/// The frames, as tags that the compiler matches. All are right-handed. docs/notation.md draws
/// them.
#include <concepts>

namespace watersky {

struct Camera {};  ///< x right, y down, z forward along the optical axis
struct Gimbal {};  ///< the gimbal's inner platform: forward, right, down at zero angles
struct Body {};    ///< the aircraft: forward, right, down
struct World {};   ///< north, east, down at the mission datum on WGS-84
struct Ecef {};    ///< earth-centred, earth-fixed
struct Sea {};     ///< north, east, down at the sea surface under one camera; the sea is z = 0
struct Map {};     ///< the sea plane of a map projection: x east, y south, z down

template <class T>
concept Frame =
    std::same_as<T, Camera> || std::same_as<T, Gimbal> || std::same_as<T, Body> ||
    std::same_as<T, World> || std::same_as<T, Ecef> || std::same_as<T, Sea> || std::same_as<T, Map>;

}  // namespace watersky
