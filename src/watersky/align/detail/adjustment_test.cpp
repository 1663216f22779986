// SPDX-License-Identifier: MIT
#include "watersky/align/detail/adjustment.hpp"

#include <gtest/gtest.h>
