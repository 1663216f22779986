// SPDX-License-Identifier: MIT
#include "watersky/align/alignment.hpp"

#include <gtest/gtest.h>
