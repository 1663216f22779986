// SPDX-License-Identifier: MIT
#pragma once
/// OpenCV's OpenCL path (its "transparent API"), off until a program asks for it.
///
/// Only what stands on OpenCV's filters can use it: the methods edges and watershed. The learned
/// methods and the map's update are passes of our own, which a device would have to be fed anew
/// for every frame (bench/opencl measures it). A device's results may differ from the
/// processor's in the last bits; a broken driver's differ in all of them, so ask first whether it
/// can be trusted (`watersky doctor`).
#include <opencv2/core/mat.hpp>

#include "watersky/base/result.hpp"

namespace watersky {

/// For the whole process, before it starts threads: on takes the device that OpenCV chooses, else
/// the first there is (OpenCV alone would pass over one on the processor). In the calling thread
/// OpenCV's functions on cv::UMat use it as well. Unsupported, and off, where there is none.
Status use_opencl(bool on);
[[nodiscard]] bool uses_opencl();

/// Blurs `level` (CV_32F) in place by a Gaussian, and takes its Sobel derivatives along x and y
/// (3x3, times `scale`), borders reflected; on the OpenCL device after use_opencl(true), and on
/// the processor when the device fails. May be called from several threads.
void smooth_and_derive(cv::Mat& level, double sigma_px, double scale, cv::Mat& dx, cv::Mat& dy);

}  // namespace watersky
