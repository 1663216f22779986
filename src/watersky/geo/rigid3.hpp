// SPDX-License-Identifier: MIT
#pragma once
/// Points, directions and rigid motions whose frames the compiler checks.
/// The thesis's T_b^a (2.3) takes coordinates in b to coordinates in a. We write a_from_b, so
/// neighbours must match: a_from_b * b_from_c == a_from_c.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <concepts>

#include "watersky/geo/frames.hpp"

namespace watersky {

/// A free vector in F: it turns with a frame but does not move with it. SI units.
template <Frame F>
struct Vector {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();

  friend Vector operator+(const Vector& a, const Vector& b) { return {a.v + b.v}; }
  friend Vector operator-(const Vector& a, const Vector& b) { return {a.v - b.v}; }
  friend Vector operator*(double s, const Vector& a) { return {s * a.v}; }
};

/// A position in F, metres.
template <Frame F>
struct Point {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();

  friend Vector<F> operator-(const Point& a, const Point& b) { return {a.v - b.v}; }
  friend Point operator+(const Point& a, const Vector<F>& b) { return {a.v + b.v}; }
};

/// A rigid motion from coordinates in From to coordinates in To (2.3). The rotation is kept as a
/// unit quaternion (2.7).
template <Frame To, Frame From>
class Rigid3 {
 public:
  /// Identity exists only from a frame to itself.
  Rigid3()
    requires std::same_as<To, From>
  = default;
  /// `rotation` takes directions in From to directions in To (normalised here); its columns as
  /// a matrix are From's axes seen in To. `origin_of_from` is where From's origin lies in To.
  Rigid3(const Eigen::Quaterniond& rotation, const Point<To>& origin_of_from)
      : rotation_(rotation.normalized()), origin_(origin_of_from) {}

  [[nodiscard]] const Eigen::Quaterniond& rotation() const { return rotation_; }
  /// From's origin in To.
  [[nodiscard]] const Point<To>& origin() const { return origin_; }

  [[nodiscard]] Point<To> operator*(const Point<From>& p) const {
    return {rotation_ * p.v + origin_.v};
  }
  [[nodiscard]] Vector<To> operator*(const Vector<From>& d) const { return {rotation_ * d.v}; }
  template <Frame Inner>
  [[nodiscard]] Rigid3<To, Inner> operator*(const Rigid3<From, Inner>& from_inner) const {
    return {rotation_ * from_inner.rotation(), *this * from_inner.origin()};
  }
  [[nodiscard]] Rigid3<From, To> inverse() const {
    const Eigen::Quaterniond r = rotation_.conjugate();
    return {r, Point<From>{-(r * origin_.v)}};
  }
  /// The homogeneous 4x4 matrix of (2.3).
  [[nodiscard]] Eigen::Matrix4d matrix() const {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = rotation_.toRotationMatrix();
    m.topRightCorner<3, 1>() = origin_.v;
    return m;
  }

 private:
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Point<To> origin_;
};

/// Whether `A * B` compiles.
template <class A, class B>
concept CanChain = requires(const A& a, const B& b) { a* b; };

}  // namespace watersky
