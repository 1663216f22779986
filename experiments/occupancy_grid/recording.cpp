// SPDX-License-Identifier: MIT
#include <future>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "study.hpp"

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
      }
    }
    // The laboratory's 640x360 divide by 8: whole blocks, as the simulator reduces them.
    if (request.reduction == 1) return kept->image.clone();
    cv::Mat reduced;
    cv::resize(kept->image, reduced, kept->image.size() / request.reduction, 0, 0, cv::INTER_AREA);
    return reduced;
  };
}

}  // namespace

sim::Scenario laboratory(int seed) {
  // The preset is the simulator's own: it is there.
  sim::Scenario scenario = sim::scenario_preset("laboratory").value();
  scenario.seed = scenario.sea.sea_seed = seed;
  return scenario;
}

Result<Recording> record(const sim::Scenario& scenario) {
  WATERSKY_TRY(sim::Simulation simulation, sim::simulate(scenario));
  for (ImageFrame& frame : simulation.flight.frames) frame.load = keeping(std::move(frame.load));
  return Recording{std::move(simulation.flight), std::move(simulation.truth)};
}

std::vector<const ImageFrame*> mapped_frames(const Recording& recording, int step) {
  std::vector<const ImageFrame*> out;
  for (std::size_t i = 0; i < recording.flight.frames.size(); i += static_cast<std::size_t>(step))
    out.push_back(&recording.flight.frames[i]);
  return out;
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

Eigen::Vector2d scene_from_room(const Datum& datum, double x_m, double y_m) {
  // World is (x, -y), turned by its azimuth from the scene's north and east.
  const double c = std::cos(datum.x_azimuth().radians()), s = std::sin(datum.x_azimuth().radians());
  return {c * x_m + s * y_m, s * x_m - c * y_m};
}

Eigen::Vector2d room_from_scene(const Datum& datum, const Eigen::Vector2d& p) {
  const double c = std::cos(datum.x_azimuth().radians()), s = std::sin(datum.x_azimuth().radians());
  return {c * p.x() + s * p.y(), s * p.x() - c * p.y()};
}

}  // namespace watersky::study
