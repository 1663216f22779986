// SPDX-License-Identifier: MIT
#pragma once
/// What the tests of all modules say about results and points.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "watersky/base/result.hpp"
#include "watersky/geo/rigid3.hpp"

namespace watersky {

template <Frame F>
void PrintTo(const Point<F>& p, std::ostream* out) {
  *out << "(" << p.v.transpose() << ")";
}

namespace test {

/// Each axis of a Point lies within `tolerance_m` of `expected`, a Point of the same frame: the
/// subtraction does not compile for another one. Not a number is near nothing.
MATCHER_P2(IsNear, expected, tolerance_m,
           std::string(negation ? "is not" : "is") + " within " +
               ::testing::PrintToString(tolerance_m) + " m of " +
               ::testing::PrintToString(expected) + " on each axis") {
  const Eigen::Vector3d off = (arg - expected).v;
  *result_listener << "which is off by (" << off.transpose() << ")";
  return off.allFinite() && off.cwiseAbs().maxCoeff() <= tolerance_m;
}

/// `result` failed with `code`, in one line that holds every one of `parts`.
template <class T>
::testing::AssertionResult fails_with(const Result<T>& result, ErrorCode code,
                                      std::initializer_list<std::string_view> parts) {
  if (result.ok()) return ::testing::AssertionFailure() << "it succeeded";
  const Error& error = result.error();
  const auto failure = [&] {
    return ::testing::AssertionFailure()
           << to_string(error.code) << ": \"" << error.message << "\" ";
  };
  if (error.code != code) return failure() << "has another code than " << to_string(code);
  if (error.message.empty() || error.message.find('\n') != std::string::npos)
    return failure() << "is not one line";
  for (const std::string_view part : parts)
    if (error.message.find(part) == std::string::npos)
      return failure() << "does not mention \"" << part << "\"";
  return ::testing::AssertionSuccess();
}

/// `result` succeeded; says why when it did not.
template <class T>
::testing::AssertionResult succeeds(const Result<T>& result) {
  if (result.ok()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << result.error().message;
}

}  // namespace test
}  // namespace watersky
