// SPDX-License-Identifier: MIT
#include "watersky/products/detail/versions.hpp"

#include <gdal.h>
#include <ogr_srs_api.h>

#include <opencv2/core/utility.hpp>

namespace watersky::detail {

Versions versions() {
  int major = 0;
  int minor = 0;
  int patch = 0;
  OSRGetPROJVersion(&major, &minor, &patch);
  return {WATERSKY_VERSION, cv::getVersionString(), GDALVersionInfo("RELEASE_NAME"),
          std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch)};
}

}  // namespace watersky::detail
