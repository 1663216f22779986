// SPDX-License-Identifier: MIT
#pragma once
/// Frames as image files hold them.
#include "watersky/flight/flight.hpp"

namespace watersky::detail {

/// Whether a frame's bytes can be written as they are.
[[nodiscard]] bool has_own_bytes(const ImageFrame& frame);
/// Those bytes.
[[nodiscard]] Result<EncodedImage> own_bytes(const ImageFrame& frame);

/// As PNG, or as JPEG of `quality`. Unsupported, naming the frame, when it cannot be.
[[nodiscard]] Result<EncodedImage> encode_image(const cv::Mat& image, bool jpeg, int quality,
                                                const std::string& name);

}  // namespace watersky::detail
