// SPDX-License-Identifier: MIT
#pragma once
/// A value or the Error that stood in its way.
///
///   Result<CameraModel> camera = read_calibration("camera.yaml");
///   if (!camera) return camera.error();
///   camera->project(…);
///
/// Inside a function that returns a Result, WATERSKY_TRY(name, expression) does the first two
/// lines.
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "watersky/base/contract.hpp"
#include "watersky/base/error.hpp"

namespace watersky {

template <class T>
class [[nodiscard]] Result {
 public:
  using value_type = T;

  Result(T value)
      : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Error error)
      : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  /// Asking a failed result for its value is a contract violation: check first.
  [[nodiscard]] T& value() & {
    WATERSKY_REQUIRE(ok());
    return std::get<0>(state_);
  }
  [[nodiscard]] const T& value() const& {
    WATERSKY_REQUIRE(ok());
    return std::get<0>(state_);
  }
  [[nodiscard]] T&& value() && {
    WATERSKY_REQUIRE(ok());
    return std::get<0>(std::move(state_));
  }
  [[nodiscard]] T value_or(T other) const& { return ok() ? std::get<0>(state_) : std::move(other); }
  [[nodiscard]] const Error& error() const {
    WATERSKY_REQUIRE(!ok());
    return std::get<1>(state_);
  }

  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }

 private:
  std::variant<T, Error> state_;
};

/// Success without a value: `Status done = write(…)`. Default-constructed it is success.
template <>
class [[nodiscard]] Result<void> {
 public:
  using value_type = void;
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return !error_; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const {
    WATERSKY_REQUIRE(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

using Status = Result<void>;

#define WATERSKY_CONCAT_INNER(a, b) a##b
#define WATERSKY_CONCAT(a, b) WATERSKY_CONCAT_INNER(a, b)

/// `WATERSKY_TRY(auto x, f());` gives x the value of f(), or returns f()'s error.
#define WATERSKY_TRY(declaration, expression)                   \
  auto WATERSKY_CONCAT(watersky_try_, __LINE__) = (expression); \
  if (!WATERSKY_CONCAT(watersky_try_, __LINE__))                \
    return WATERSKY_CONCAT(watersky_try_, __LINE__).error();    \
  declaration = std::move(WATERSKY_CONCAT(watersky_try_, __LINE__)).value()

/// The same for a Status.
#define WATERSKY_CHECK(expression)                                                             \
  do {                                                                                         \
    if (auto watersky_status = (expression); !watersky_status) return watersky_status.error(); \
  } while (false)

}  // namespace watersky
