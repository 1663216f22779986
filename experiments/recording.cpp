// SPDX-License-Identifier: MIT
#include "recording.hpp"

#include <future>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "watersky/camera/reduced_image.hpp"

namespace watersky::study {

namespace {

/// An image that is made once.
struct Kept {
  std::mutex mutex;
  ImageLoader make;
  cv::Mat image;
};

ImageLoader keeping(ImageLoader make) {
  auto kept = std::make_shared<Kept>();
  kept->make = std::move(make);
  return [kept](const ImageRequest& request) -> Result<cv::Mat> {
    {
      const std::lock_guard lock(kept->mutex);
      if (kept->image.empty()) {
        WATERSKY_TRY(kept->image, kept->make({}));
        kept->make = {};
      }
    }
    cv::Mat image = kept->image;
    if (!request.color && image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
    return reduced_by(image, request.reduction);
  };
}

}  // namespace

Result<sim::Simulation> record(const sim::Scenario& scenario) {
  WATERSKY_TRY(sim::Simulation simulation, sim::simulate(scenario));
  for (ImageFrame& frame : simulation.flight.frames) frame.load = keeping(std::move(frame.load));
  return simulation;
}

Status render(const std::vector<const ImageFrame*>& frames) {
  const auto part = [&frames](std::size_t first) -> Status {
    for (std::size_t i = first; i < frames.size(); i += 2)
      if (auto image = frames[i]->load({}); !image) return image.error();
    return {};
  };
  auto other = std::async(std::launch::async, part, std::size_t{1});
  const Status mine = part(0), theirs = other.get();
  return mine.ok() ? theirs : mine;
}

Status render(const Flight& flight) { return render(every(flight, 1)); }

std::vector<const ImageFrame*> every(const Flight& flight, int step) {
  std::vector<const ImageFrame*> out;
  for (std::size_t i = 0; i < flight.frames.size(); i += static_cast<std::size_t>(step))
    out.push_back(&flight.frames[i]);
  return out;
}

}  // namespace watersky::study
