// SPDX-License-Identifier: MIT
/// The part of the OpenCL check that may hang or die: see opencl_check.hpp.
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>

#include "opencl_check.hpp"

namespace watersky::cli {

namespace {

void print(const nlohmann::json& line) {
  std::printf("%s\n", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

void step(const std::string& what) { print({{"step", what}}); }

/// Water and floes with noise, in levels of 8 bit; the size is no multiple of any work group's.
cv::Mat picture() {
  cv::RNG rng(11);
  cv::Mat image(509, 637, CV_8U, cv::Scalar(70)), noise(image.size(), CV_8U);
  for (int i = 0; i < 60; ++i)
    cv::circle(image, {rng.uniform(0, image.cols), rng.uniform(0, image.rows)}, rng.uniform(5, 60),
               cv::Scalar(rng.uniform(150, 200)), cv::FILLED);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 12);
  image += noise;
  return image;
}

/// OpenCV falls back on the processor in silence where a device refuses. A kernel of our own
/// cannot: the log-odds of (2.31) from a picture, as a device would compute them.
double own_kernel(const cv::Mat& image) {
  static const char* const kSource =
      "__kernel void evidence(__global const uchar* p, int step, int offset, int rows, int cols,"
      "  __global uchar* out, int out_step, int out_offset, float ice, float water) {"
      "  int x = get_global_id(0), y = get_global_id(1);"
      "  if (x >= cols || y >= rows) return;"
      "  *(__global float*)(out + out_offset + y * out_step + 4 * x) ="
      "    p[offset + y * step + x] > 127 ? ice : water;"
      "}";
  constexpr float kIce = 0.8473F, kWater = -0.4055F;
  cv::UMat in, out(image.size(), CV_32F, cv::Scalar(7));
  image.copyTo(in);
  cv::ocl::Kernel kernel("evidence", cv::ocl::ProgramSource(kSource));
  if (kernel.empty()) return std::nan("");
  kernel.args(cv::ocl::KernelArg::ReadOnly(in), cv::ocl::KernelArg::WriteOnlyNoSize(out), kIce,
              kWater);
  std::size_t size[2] = {static_cast<std::size_t>(image.cols),
                         static_cast<std::size_t>(image.rows)};
  if (!kernel.run(2, size, nullptr, true)) return std::nan("");
  cv::Mat expected(image.size(), CV_32F, cv::Scalar(kWater));
  expected.setTo(kIce, image > 127);
  return cv::norm(out.getMat(cv::ACCESS_READ), expected, cv::NORM_INF);
}

/// `operation`(cv::InputArray, cv::OutputArray) on the processor and on the device.
template <class Operation>
double difference(const cv::Mat& image, const Operation& operation) {
  cv::Mat expected;
  operation(image, expected);
  cv::UMat in, out;
  image.copyTo(in);
  operation(in, out);
  return cv::norm(out.getMat(cv::ACCESS_READ), expected, cv::NORM_INF);
}

nlohmann::json compare(const std::string& device) {
  const cv::Mat image = picture();
  cv::Mat level;
  image.convertTo(level, CV_32F, 1.0 / 255.0);
  const cv::Matx33d oblique(0.9, 0.12, -20.0, -0.1, 1.1, 15.0, 1e-4, 3e-4, 1.0);
  nlohmann::json comparisons = nlohmann::json::array();
  const auto add = [&](const char* operation, double bound, const auto& body) {
    step("trying " + std::string(operation) + " on " + device);
    double d = std::nan("");
    try {
      d = body();
    } catch (const cv::Exception&) {
      // The device refused: not comparable, which is not agreement.
    }
    nlohmann::json found{{"operation", operation}, {"bound", bound}, {"max_difference", nullptr}};
    if (std::isfinite(d)) found["max_difference"] = d;
    comparisons.push_back(std::move(found));
  };
  add("a kernel", 0.0, [&] { return own_kernel(image); });
  add("threshold", 0.0, [&] {
    return difference(image, [](cv::InputArray in, cv::OutputArray out) {
      cv::threshold(in, out, 127, 255, cv::THRESH_BINARY);
    });
  });
  // Sums of 17 products, twice, each rounded to 6e-8 of values up to 1.
  add("blur", 1e-5, [&] {
    // Of a size of our own: with one of its choice OpenCV stays on the processor.
    return difference(level, [](cv::InputArray in, cv::OutputArray out) {
      cv::GaussianBlur(in, out, {17, 17}, 2.0);
    });
  });
  // Both interpolate between 32 places a pixel: where one rounds to the next place, the value
  // differs by a 32nd of the step to the next pixel, along each axis.
  add("warp", 2.0 / 32.0, [&] {
    return difference(level, [&](cv::InputArray in, cv::OutputArray out) {
      cv::warpPerspective(in, out, oblique, {640, 512}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    });
  });
  return comparisons;
}

}  // namespace

void try_opencl_devices() {
  step("looking for platforms");
  std::vector<cv::ocl::PlatformInfo> platforms;
  if (cv::ocl::haveOpenCL()) cv::ocl::getPlatfomsInfo(platforms);
  for (const cv::ocl::PlatformInfo& platform : platforms) {
    for (int i = 0; i < platform.deviceNumber(); ++i) {
      step("opening a device of " + platform.name());
      cv::ocl::Device device;
      platform.getDevice(device, i);
      nlohmann::json found{{"platform", platform.name()},
                           {"name", device.name()},
                           {"version", device.version()},
                           {"driver", device.driverVersion()},
                           {"comparisons", nlohmann::json::array()}};
      try {
        // OpenCV takes only the context's own object for the device, not another one for it.
        const cv::ocl::Context context = cv::ocl::Context::fromDevice(device);
        cv::ocl::OpenCLExecutionContext::create(context, context.device(0)).bind();
        cv::ocl::setUseOpenCL(true);
        found["comparisons"] = compare(device.name());
      } catch (const cv::Exception& e) {
        found["refusal"] = e.err;
      }
      print({{"device", found}});
    }
  }
  print({{"done", true}});
}

}  // namespace watersky::cli
