// SPDX-License-Identifier: MIT
#include "watersky/vision/opencl.hpp"

#include <atomic>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace watersky {
namespace {

using cv::ocl::OpenCLExecutionContext;

std::atomic<bool> g_on{false};

/// OpenCV has a current device for each thread; frames are segmented in several. This is the one
/// that they are given. Empty where there is none.
const OpenCLExecutionContext& device() {
  static const OpenCLExecutionContext chosen = []() -> OpenCLExecutionContext {
    try {
      // Without this question OpenCV takes OpenCL for missing.
      if (!cv::ocl::haveOpenCL()) return {};
      const OpenCLExecutionContext& preferred = OpenCLExecutionContext::getCurrent();
      if (!preferred.empty()) return preferred;
      std::vector<cv::ocl::PlatformInfo> platforms;
      cv::ocl::getPlatfomsInfo(platforms);
      for (const cv::ocl::PlatformInfo& platform : platforms) {
        if (platform.deviceNumber() == 0) continue;
        cv::ocl::Device first;
        platform.getDevice(first, 0);
        const cv::ocl::Context context = cv::ocl::Context::fromDevice(first);
        // OpenCV takes only the context's own object for the device, not another one for it.
        return OpenCLExecutionContext::create(context, context.device(0));
      }
    } catch (const cv::Exception&) {
      // A driver that refuses is as none.
    }
    return {};
  }();
  return chosen;
}

template <class Image>
void filter(const Image& level, double sigma_px, double scale, Image& smooth, Image& dx,
            Image& dy) {
  // The size that OpenCV would choose; left to choose it, it does not use the device.
  const int size = cvRound(8.0 * sigma_px + 1.0) | 1;
  cv::GaussianBlur(level, smooth, {size, size}, sigma_px, sigma_px, cv::BORDER_REFLECT);
  cv::Sobel(smooth, dx, CV_32F, 1, 0, 3, scale, 0, cv::BORDER_REFLECT);
  cv::Sobel(smooth, dy, CV_32F, 0, 1, 3, scale, 0, cv::BORDER_REFLECT);
}

bool filter_on_device(cv::Mat& level, double sigma_px, double scale, cv::Mat& dx, cv::Mat& dy) {
  try {
    thread_local OpenCLExecutionContext mine = device().cloneWithNewQueue();
    const cv::ocl::OpenCLExecutionContextScope scope(mine);
    cv::UMat there, smooth, along_x, along_y;
    level.copyTo(there);
    filter(there, sigma_px, scale, smooth, along_x, along_y);
    along_x.copyTo(dx);
    along_y.copyTo(dy);
    smooth.copyTo(level);  // last: until here `level` is as it was
    return true;
  } catch (const cv::Exception&) {
    return false;
  }
}

}  // namespace

Status use_opencl(bool on) {
  g_on = false;
  if (!on) {
    cv::ocl::setUseOpenCL(false);
    return {};
  }
  if (device().empty())
    return Error{
        ErrorCode::Unsupported,
        "there is no OpenCL device; install its driver (pocl-opencl-icd for the processor)"};
  device().bind();
  cv::ocl::setUseOpenCL(true);
  g_on = true;
  return {};
}

bool uses_opencl() { return g_on; }

void smooth_and_derive(cv::Mat& level, double sigma_px, double scale, cv::Mat& dx, cv::Mat& dy) {
  if (g_on && filter_on_device(level, sigma_px, scale, dx, dy)) return;
  filter(level, sigma_px, scale, level, dx, dy);
}

}  // namespace watersky
