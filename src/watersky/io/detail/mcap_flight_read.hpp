// SPDX-License-Identifier: MIT
#pragma once
/// Our own MCAP recordings, read (recording_write.hpp writes them).
#include "watersky/base/progress.hpp"
#include "watersky/io/detail/message_file.hpp"
#include "watersky/io/image_file.hpp"
#include "watersky/io/read_options.hpp"

namespace watersky::detail {

/// Names in the file; the writer's and the reader's.
inline constexpr const char* kFlightYaml = "flight.yaml";
inline constexpr const char* kCameraYaml = "camera.yaml";
inline constexpr const char* kLeftOutMetadata = "watersky.left_out";
inline constexpr const char* kImageTopic = "/camera/image";

/// Whether it holds a flight.yaml, which write_mcap_flight() puts first.
[[nodiscard]] bool is_flight_of_ours(const MessageFile& file);

[[nodiscard]] Result<Flight> read_mcap_flight(const std::shared_ptr<const MessageFile>& file,
                                              const ReadOptions& options, const Progress& progress);

/// Sets what loads a frame's pixels, and its bytes where it is compressed.
void set_image(ImageFrame& frame, const std::shared_ptr<const MessageFile>& file,
               const MessageChannel& channel, const mcap::Location& where,
               const std::optional<ImageSize>& expected);

}  // namespace watersky::detail
