// SPDX-License-Identifier: MIT
/// P(ice) of one frame by every method against the least that anybody would do, OpenCV's 5x5
/// Gaussian blur and Otsu threshold, one core, in the same run. Figures:
/// segment.SIZE.{baseline_ms, METHOD.ms, METHOD.ratio_otsu}, and METHOD_16bit for thermal counts,
/// METHOD_auto where the polarity of the ice is found from the frame as well.
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "bench.hpp"
#include "watersky/base/memory.hpp"
#include "watersky/vision/segmentation.hpp"

using namespace watersky;

namespace {

/// Floes of all sizes on water, shaded, with a thermal camera's noise.
cv::Mat pack_ice(int width, int height) {
  cv::RNG rng(5);
  cv::Mat image(height, width, CV_32F), noise(image.size(), CV_32F);
  image.setTo(150);
  for (int i = 0; i < 160; ++i) {
    const double size = 4.0 + 60.0 * std::pow(rng.uniform(0.0, 1.0), 3);
    cv::ellipse(
        image,
        cv::RotatedRect(cv::Point2f(rng.uniform(0.0F, static_cast<float>(width)),
                                    rng.uniform(0.0F, static_cast<float>(height))),
                        cv::Size2f(static_cast<float>(2 * size), static_cast<float>(1.4 * size)),
                        rng.uniform(0.0F, 180.0F)),
        80.0 + rng.uniform(-8.0, 8.0), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  rng.fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
  image += noise;
  return image;
}

void run(int width, int height) {
  const cv::Mat image = pack_ice(width, height);
  cv::Mat eight, sixteen;
  image.convertTo(eight, CV_8U);
  image.convertTo(sixteen, CV_16U, 10.0, 21000.0);

  struct Contender {
    std::string name;
    std::function<void()> body;
    std::vector<double> seconds{};
  };
  std::vector<Contender> contenders;
  cv::Mat blurred, mask;
  contenders.push_back({"baseline", [&] {
                          cv::GaussianBlur(eight, blurred, {5, 5}, 0);
                          cv::threshold(blurred, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
                        }});
  std::vector<std::unique_ptr<Segmenter>> segmenters;
  cv::Mat p_ice;
  const auto add = [&](SegmentationMethod method, const char* variant, const cv::Mat& frame,
                       IcePolarity ice) {
    segmenters.push_back(make_segmenter(method, {}, ice).value());
    contenders.push_back({std::string(name_of(method)) + variant,
                          [&p_ice, &frame, segmenter = segmenters.back().get()] {
                            p_ice = segmenter->segment(frame, {}).value();
                          }});
  };
  for (const SegmentationMethod method : segmentation_methods()) {
    add(method, "", eight, IcePolarity::Darker);
    add(method, "_16bit", sixteen, IcePolarity::Darker);
    add(method, "_auto", eight, IcePolarity::Auto);
  }
  for (int i = 0; i < 31; ++i)
    for (Contender& c : contenders) c.seconds.push_back(bench::seconds_of(c.body));

  const std::string size = "segment." + std::to_string(width) + "x" + std::to_string(height) + ".";
  const double baseline = bench::median(contenders[0].seconds);
  bench::print_figure((size + "baseline_ms").c_str(), 1e3 * baseline, "ms");
  for (std::size_t i = 1; i < contenders.size(); ++i) {
    const double seconds = bench::median(contenders[i].seconds);
    bench::print_figure((size + contenders[i].name + ".ms").c_str(), 1e3 * seconds, "ms");
    bench::print_figure((size + contenders[i].name + ".ratio_otsu").c_str(), seconds / baseline,
                        "1");
  }
}

}  // namespace

int main() {
  keep_freed_memory();  // as the program does
  cv::setNumThreads(1);
  run(640, 512);
}
