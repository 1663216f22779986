// SPDX-License-Identifier: MIT
#pragma once
#include <cpl_error.h>

namespace watersky::detail {

/// While it lives GDAL prints nothing on this thread: what went wrong is read from its result.
class QuietGdal {
 public:
  QuietGdal() { CPLPushErrorHandler(CPLQuietErrorHandler); }
  ~QuietGdal() { CPLPopErrorHandler(); }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

}  // namespace watersky::detail
