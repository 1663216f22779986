// SPDX-License-Identifier: MIT
#include "watersky/camera/sea_plane.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "support/matchers.hpp"
#include "watersky/geo/rotation.hpp"

namespace watersky {
namespace {

using test::fails_with;
using test::IsNear;
using test::succeeds;

static_assert(
    std::is_invocable_v<decltype(&SeaView::make), CameraModel, Rigid3<Sea, Camera>, ViewLimits>);
static_assert(
    !std::is_invocable_v<decltype(&SeaView::make), CameraModel, Rigid3<Camera, Sea>, ViewLimits>);
static_assert(
    !std::is_invocable_v<decltype(&SeaView::make), CameraModel, Rigid3<World, Camera>, ViewLimits>);
static_assert(!std::is_invocable_v<decltype(&SeaView::pixel), SeaView, Point<World>>);

Eigen::Matrix3d matrix(double fx, double fy, double cx, double cy) {
  Eigen::Matrix3d a;
  a << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return a;
}

// 640 x 360 about its own middle: neither square nor of equal fields of view.
CameraModel pinhole(std::vector<double> distortion = {}) {
  return CameraModel::make(LensModel::Pinhole, 640, 360, matrix(500, 500, 319.5, 179.5),
                           std::move(distortion))
      .value();
}
CameraModel fisheye(double focal_px, std::vector<double> distortion = {}) {
  return CameraModel::make(LensModel::Fisheye, 640, 480, matrix(focal_px, focal_px, 322, 236),
                           std::move(distortion))
      .value();
}

Rigid3<Sea, Camera> pose(double yaw_deg, double pitch_deg, double roll_deg,
                         const Eigen::Vector3d& at) {
  return {camera_rotation(
              {Angle::degrees(yaw_deg), Angle::degrees(pitch_deg), Angle::degrees(roll_deg)}),
          Point<Sea>{at}};
}

class RandomPoses : public ::testing::Test {
 protected:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  Rigid3<Sea, Camera> random_pose(double highest_pitch_deg) {
    // Drawn one by one: arguments are evaluated in another order on another processor.
    const double yaw_deg = uniform(-180, 180), pitch_deg = uniform(-90, highest_pitch_deg),
                 roll_deg = uniform(-40, 40);
    const double north_m = uniform(-50, 50), east_m = uniform(-50, 50), down_m = -uniform(10, 500);
    return pose(yaw_deg, pitch_deg, roll_deg, {north_m, east_m, down_m});
  }
  std::mt19937 rng_{12};
};

TEST(MetresFromCells, PutsCentresAtHalfACellColumnAlongX) {
  const Eigen::Matrix3d m = metres_from_cells(2.0, 3.0);
  EXPECT_EQ(m * Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1.0, 1.5, 0.0));
  EXPECT_EQ(m * Eigen::Vector3d(4, 1, 1), Eigen::Vector3d(9.0, 4.5, 0.0));
}

/// P of (2.34) for a grid on the Sea whose columns run along `azimuth_deg` + 90°: north-up at 0.
Eigen::Matrix3d sea_from_grid(double azimuth_deg, double north_m, double east_m, double dx_m,
                              double dy_m) {
  // Map's x is east, y is south: seen in north, east, down these are (0,1,0) and (-1,0,0).
  Eigen::Matrix3d sea_from_map;
  sea_from_map << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Eigen::Matrix3d p = heading(Angle::degrees(azimuth_deg)).toRotationMatrix() * sea_from_map *
                      metres_from_cells(dx_m, dy_m);
  p.col(2) += Eigen::Vector3d(north_m, east_m, 0);
  return p;
}

// Straight down from 100 m, image top north: by hand.
TEST(ImageFromGrid, EastIsRightAndSouthIsDownSeenFromAbove) {
  const Rigid3<Sea, Camera> sea_from_camera = pose(0, -90, 0, {0, 0, -100});
  const Eigen::Matrix3d h = image_from_grid(matrix(500, 400, 320, 240), sea_from_camera.inverse(),
                                            sea_from_grid(0, 20, -30, 2, 3));
  // Cell (3, 1): 3.5 columns of 2 m east of -30, 1.5 rows of 3 m south of 20.
  const Eigen::Vector3d s = h * Eigen::Vector3d(3, 1, 1);
  EXPECT_NEAR(s.z(), 100.0, 1e-9);
  EXPECT_NEAR(s.x() / s.z(), 320 + 500 * (-23.0) / 100, 1e-9);
  EXPECT_NEAR(s.y() / s.z(), 240 - 400 * 15.5 / 100, 1e-9);
}

// Through each pixel that the homography names, a ray is cast by hand onto z = 0 and must hit
// the centre of the cell. Rows, columns, cell edges, focal lengths all differ: a transpose or a
// mirror cannot pass.
TEST_F(RandomPoses, ImageFromGridAgreesWithRaysCastOntoThePlane) {
  int in_front = 0, behind = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Matrix3d a =
        matrix(uniform(300, 900), uniform(300, 900), uniform(200, 400), uniform(100, 300));
    const Rigid3<Sea, Camera> sea_from_camera = random_pose(30);
    const double azimuth = uniform(-180, 180), north = uniform(-200, 200),
                 east = uniform(-200, 200);
    const double dx = uniform(0.5, 20), dy = uniform(0.5, 20);
    const Eigen::Matrix3d h =
        image_from_grid(a, sea_from_camera.inverse(), sea_from_grid(azimuth, north, east, dx, dy));
    const Eigen::Vector3d camera = sea_from_camera.origin().v;
    const Eigen::Vector3d axis = sea_from_camera.rotation() * Eigen::Vector3d::UnitZ();
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 7; ++column) {
        const Eigen::Vector3d s = h * Eigen::Vector3d(column, row, 1);
        const double right = (column + 0.5) * dx, back = (row + 0.5) * dy;
        const double sin_a = std::sin(azimuth * std::numbers::pi / 180),
                     cos_a = std::cos(azimuth * std::numbers::pi / 180);
        const Eigen::Vector3d centre(north - cos_a * back - sin_a * right,
                                     east - sin_a * back + cos_a * right, 0);
        // The third coordinate is the depth along the optical axis, so its sign masks ghosts.
        EXPECT_NEAR(s.z(), axis.dot(centre - camera), 1e-9);
        if (s.z() <= 1e-6) {
          ++behind;
          continue;
        }
        ++in_front;
        const Eigen::Vector3d ray_camera((s.x() / s.z() - a(0, 2)) / a(0, 0),
                                         (s.y() / s.z() - a(1, 2)) / a(1, 1), 1);
        const Eigen::Vector3d ray = sea_from_camera.rotation() * ray_camera;
        const Eigen::Vector3d hit = camera - ray * (camera.z() / ray.z());
        EXPECT_LT((hit - centre).norm(), 1e-6 * (1 + (centre - camera).norm()));
      }
  }
  EXPECT_GT(in_front, 1000);
  EXPECT_GT(behind, 1000);
}

TEST_F(RandomPoses, InvertHomographyUndoes) {
  for (int i = 0; i < 500; ++i) {
    // Also with a grid that begins 100 km away, as a map's tiles do.
    const double far = i % 2 == 0 ? 200 : 1e5;
    const Eigen::Matrix3d h = image_from_grid(
        matrix(1358, 1360, 819.5, 615.5), random_pose(-20).inverse(),
        sea_from_grid(uniform(-180, 180), uniform(-far, far), uniform(-far, far), 0.1, 0.2));
    const auto back = invert_homography(h);
    ASSERT_TRUE(succeeds(back));
    const Eigen::Vector3d cell(uniform(0, 1000), uniform(0, 1000), 1);
    const Eigen::Vector3d again = *back * (h * cell);
    EXPECT_NEAR(again.x() / again.z(), cell.x(), 1e-8 * far);
    EXPECT_NEAR(again.y() / again.z(), cell.y(), 1e-8 * far);
  }
}

TEST_F(RandomPoses, InvertHomographyRefusesACameraInThePlane) {
  for (int i = 0; i < 500; ++i) {
    Rigid3<Sea, Camera> in_plane(random_pose(30).rotation(),
                                 {{uniform(-50, 50), uniform(-50, 50), 0}});
    const double far = i % 2 == 0 ? 200 : 1e5;
    const Eigen::Matrix3d p =
        sea_from_grid(uniform(-180, 180), uniform(-far, far), uniform(-far, far), 0.1, 0.2);
    EXPECT_TRUE(fails_with(
        invert_homography(image_from_grid(matrix(500, 500, 320, 240), in_plane.inverse(), p)),
        ErrorCode::Degenerate, {"in the plane"}));
  }
  EXPECT_FALSE(invert_homography(Eigen::Matrix3d::Zero()).ok());
  EXPECT_FALSE(invert_homography(Eigen::Matrix3d::Constant(std::nan(""))).ok());
}

double signed_area(const std::vector<Eigen::Vector2d>& p) {
  double twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const auto &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

bool inside(const std::vector<Eigen::Vector2d>& p, const Eigen::Vector2d& q) {
  bool in = false;
  for (std::size_t i = 0, j = p.size() - 1; i < p.size(); j = i++)
    if ((p[i].y() > q.y()) != (p[j].y() > q.y()) &&
        q.x() < (p[j].x() - p[i].x()) * (q.y() - p[i].y()) / (p[j].y() - p[i].y()) + p[i].x())
      in = !in;
  return in;
}

double distance_to(const std::vector<Eigen::Vector2d>& p, const Eigen::Vector2d& q) {
  double least = 1e300;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector2d a = p[i], d = p[(i + 1) % p.size()] - a;
    const double f = std::clamp((q - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (a + f * d - q).norm());
  }
  return least;
}

/// No two edges that are not neighbours meet, and no vertex repeats the one before it.
::testing::AssertionResult is_simple(const std::vector<Eigen::Vector2d>& p) {
  const auto side = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                       const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  };
  const std::size_t n = p.size();
  if (n < 3) return ::testing::AssertionFailure() << n << " vertices";
  for (std::size_t i = 0; i < n; ++i) {
    if (p[i] == p[(i + 1) % n])
      return ::testing::AssertionFailure() << "vertex " << i << " repeats";
    for (std::size_t k = i + 2; k < n; ++k) {
      if (i == 0 && k == n - 1) continue;
      const auto &a = p[i], &b = p[i + 1], &c = p[k], &d = p[(k + 1) % n];
      if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0)
        return ::testing::AssertionFailure()
               << "edges " << i << " and " << k << " of " << n << " cross";
    }
  }
  return ::testing::AssertionSuccess();
}

/// The area that the image sees within the limit, by casting a jittered grid of sea points into
/// it; the grid spans half as much again as the polygon, so that a polygon too small is found out.
double area_by_sampling(const SeaView& view, std::mt19937& rng) {
  Eigen::AlignedBox2d box;
  for (const auto& p : view.footprint_north_east_m()) box.extend(p);
  const Eigen::Vector2d margin = 0.25 * box.sizes();
  box = Eigen::AlignedBox2d(box.min() - margin, box.max() + margin);
  constexpr int kN = 200;
  std::uniform_real_distribution<double> unit(0, 1);
  const Eigen::Vector2d below = view.sea_from_camera().origin().v.head<2>();
  int seen = 0;
  for (int i = 0; i < kN; ++i)
    for (int k = 0; k < kN; ++k) {
      const Eigen::Vector2d at = box.min() + box.sizes().cwiseProduct(Eigen::Vector2d(
                                                 (i + unit(rng)) / kN, (k + unit(rng)) / kN));
      if ((at - below).norm() > view.max_distance_m()) continue;
      const auto pixel = view.pixel(Point<Sea>{{at.x(), at.y(), 0}});
      seen += pixel && view.camera().contains(*pixel);
    }
  return box.volume() * seen / (kN * kN);
}

void expect_outlines_what_it_sees(const SeaView& view, std::mt19937& rng, const std::string& what) {
  const auto& outline = view.footprint_north_east_m();
  EXPECT_TRUE(is_simple(outline)) << what;
  const double area = signed_area(outline), sampled = area_by_sampling(view, rng);
  EXPECT_GT(area, 0) << what << ": clockwise seen from above";
  EXPECT_NEAR(area, sampled, 0.01 * sampled) << what;

  // Whatever a pixel sees lies in the outline, but for the sagitta of its short straight edges.
  std::uniform_real_distribution<double> u(-0.5, view.camera().width_px() - 0.5),
      v(-0.5, view.camera().height_px() - 0.5);
  for (int i = 0; i < 200; ++i)
    if (const auto p = view.sea_point({u(rng), v(rng)})) {
      const Eigen::Vector2d at = p->v.head<2>();
      EXPECT_TRUE(inside(outline, at) || distance_to(outline, at) < 0.01 * std::sqrt(area)) << what;
    }
}

TEST_F(RandomPoses, TheFootprintIsWhatTheImageSees) {
  const std::vector<std::pair<std::string, CameraModel>> cameras{
      {"pinhole", pinhole()},
      {"barrel", pinhole({-0.25, 0.06, 1e-3, -1e-3, 0})},
      {"barrel that folds inside the image", pinhole({-0.9, 0, 0, 0, 0})},
      {"pincushion", pinhole({0.3, 0.1, 0, 0, 0})},
      {"fisheye", fisheye(280, {-0.02, 0.003, 0, 0})},
      {"fisheye of half a sphere", fisheye(150)},
      {"fisheye whose circle lies inside the image", fisheye(140, {-0.1, 0, 0, 0})}};
  int seen = 0, cut = 0;
  for (int i = 0; i < 420; ++i) {
    const auto& [name, camera] = cameras[static_cast<std::size_t>(i) % cameras.size()];
    const Rigid3<Sea, Camera> sea_from_camera = random_pose(5);
    const ViewLimits limits{Angle::degrees(uniform(3, 30))};
    const auto view = SeaView::make(camera, sea_from_camera, limits);
    if (!view) continue;
    ++seen;
    cut += view->cut_by_grazing_limit();
    expect_outlines_what_it_sees(*view, rng_, name + ", pose " + std::to_string(i));
  }
  EXPECT_GT(seen, 300);
  EXPECT_GT(cut, 100);
  EXPECT_GT(seen - cut, 50);
}

TEST_F(RandomPoses, SeaPointAndPixelUndoEachOther) {
  for (const CameraModel& camera :
       {pinhole(), pinhole({-0.25, 0.06, 1e-3, -1e-3, 0}), fisheye(150)})
    for (int i = 0; i < 60; ++i) {
      const auto view = SeaView::make(camera, random_pose(-30));
      ASSERT_TRUE(succeeds(view));
      for (int n = 0; n < 30; ++n) {
        const Pixel pixel{uniform(0, 639), uniform(0, 359)};
        const auto p = view->sea_point(pixel);
        if (!p) continue;
        EXPECT_EQ(p->v.z(), 0.0);
        EXPECT_LE((*p - Point<Sea>{{view->sea_from_camera().origin().v.x(),
                                    view->sea_from_camera().origin().v.y(), 0}})
                      .v.norm(),
                  view->max_distance_m() * (1 + 1e-8));
        const auto back = view->pixel(*p);
        ASSERT_TRUE(back);
        EXPECT_NEAR(back->u, pixel.u, 1e-6);
        EXPECT_NEAR(back->v, pixel.v, 1e-6);
      }
    }
}

// By hand: 640 x 360 pixels at f = 500 from 100 m are 128 m x 72 m.
TEST(SeaView, StraightDownItIsARectangle) {
  const auto view = SeaView::make(pinhole(), pose(0, -90, 0, {10, 20, -100})).value();
  EXPECT_NEAR(view.height_m(), 100.0, 1e-12);
  EXPECT_FALSE(view.cut_by_grazing_limit());
  ASSERT_EQ(view.footprint_north_east_m().size(), 4u);
  EXPECT_NEAR(signed_area(view.footprint_north_east_m()), 128.0 * 72.0, 1e-6);
  for (const auto& p : view.footprint_north_east_m()) {
    EXPECT_NEAR(std::abs(p.x() - 10), 36.0, 1e-9);
    EXPECT_NEAR(std::abs(p.y() - 20), 64.0, 1e-9);
  }
  EXPECT_THAT(view.sea_point({319.5, 179.5}).value(), IsNear(Point<Sea>{{10, 20, 0}}, 1e-9));
  EXPECT_THAT(view.sea_point({-0.5, -0.5}).value(), IsNear(Point<Sea>{{46, -44, 0}}, 1e-9));
}

TEST(SeaView, GsdStraightDownIsHeightOverFocalLength) {
  for (const double yaw : {0.0, 33.0, -120.0})
    EXPECT_NEAR(SeaView::make(pinhole(), pose(yaw, -90, 0, {0, 0, -250}))->gsd_m(), 0.5, 1e-7);
}

TEST_F(RandomPoses, GsdIsTheStepFromPixelToPixelAlongTheCoarserDirection) {
  for (const CameraModel& camera :
       {pinhole(), pinhole({-0.25, 0.06, 1e-3, -1e-3, 0}), fisheye(280)})
    for (int i = 0; i < 50; ++i) {
      const auto view = SeaView::make(camera, random_pose(-40));
      ASSERT_TRUE(succeeds(view));
      const double u = 0.5 * (camera.width_px() - 1), v = 0.5 * (camera.height_px() - 1);
      double coarsest = 0;
      for (int a = 0; a < 360; ++a) {
        const double du = 0.05 * std::cos(a / 57.29578), dv = 0.05 * std::sin(a / 57.29578);
        const auto p = view->sea_point({u + du, v + dv}), q = view->sea_point({u - du, v - dv});
        ASSERT_TRUE(p && q);
        coarsest = std::max(coarsest, (*p - *q).v.norm() / 0.1);
      }
      EXPECT_NEAR(view->gsd_m(), coarsest, 1e-3 * coarsest);
    }
}

// The middle looks at the sky; the nearest sea is seen by the middle of the bottom row.
TEST(SeaView, GsdIsThatOfTheNearestSeaWhenTheMiddleSeesNone) {
  const auto view = SeaView::make(pinhole(), pose(0, 0, 0, {0, 0, -100})).value();
  EXPECT_TRUE(view.cut_by_grazing_limit());
  const double down = std::atan(180.0 / 500.0);  // of the bottom edge below the horizon
  // Along the ray's vertical plane: pixels to angle is f / cos², angle to sea is h / sin².
  const double per_pixel =
      std::cos(down) * std::cos(down) / 500 * 100 / (std::sin(down) * std::sin(down));
  EXPECT_NEAR(view.gsd_m(), per_pixel, 1e-3 * per_pixel);
}

TEST(SeaView, OnlySeaAboveTheGrazingLimitIsUsed) {
  // Level camera: the lower half sees from the horizon down to 19.8°.
  const auto view = SeaView::make(pinhole(), pose(90, 0, 0, {0, 0, -100}), {12_deg}).value();
  EXPECT_TRUE(view.cut_by_grazing_limit());
  EXPECT_NEAR(view.max_distance_m(), 100 / std::tan(12 * std::numbers::pi / 180), 1e-9);
  const double row_of_limit = 179.5 + 500 * std::tan(12 * std::numbers::pi / 180);
  EXPECT_TRUE(view.sea_point({319.5, row_of_limit + 0.01}));
  EXPECT_FALSE(view.sea_point({319.5, row_of_limit - 0.01}));
  EXPECT_FALSE(view.sea_point({319.5, 100.0}));
  double farthest = 0;
  for (const auto& p : view.footprint_north_east_m()) {
    farthest = std::max(farthest, p.norm());
    EXPECT_GT(p.y(), 0);  // looks east
  }
  EXPECT_NEAR(farthest, view.max_distance_m(), 1e-6 * farthest);
}

TEST(SeaView, AVeryWideLensHoldsTheWholeCircle) {
  const auto view = SeaView::make(fisheye(120), pose(0, -90, 0, {3, 4, -50}), {20_deg}).value();
  EXPECT_TRUE(view.cut_by_grazing_limit());
  const double radius = 50 / std::tan(20 * std::numbers::pi / 180);
  EXPECT_NEAR(signed_area(view.footprint_north_east_m()), std::numbers::pi * radius * radius,
              0.001 * std::numbers::pi * radius * radius);
  // Tilted, it still does, as long as the circle stays inside the image.
  const auto tilted = SeaView::make(fisheye(120), pose(0, -75, 5, {3, 4, -50}), {20_deg}).value();
  EXPECT_NEAR(signed_area(tilted.footprint_north_east_m()), std::numbers::pi * radius * radius,
              0.001 * std::numbers::pi * radius * radius);
}

TEST(SeaView, ACircleOfTheLensInsideTheImageBoundsTheFootprint) {
  // θ (1 - 0.1 θ²) folds at θ = 1/√0.3 = 104.6°, at 1.217 · 80 = 97 px; 60° are seen at 74.6 px.
  const CameraModel camera = fisheye(80, {-0.1, 0, 0, 0});
  const double radius = 50 / std::tan(30 * std::numbers::pi / 180);
  const auto view = SeaView::make(camera, pose(0, -90, 0, {0, 0, -50}), {30_deg}).value();
  EXPECT_NEAR(signed_area(view.footprint_north_east_m()), std::numbers::pi * radius * radius,
              0.002 * 3.1416 * radius * radius);
  // r (1 - 2 r²) folds at r = 1/√6, inside the image: the sea is seen up to h/√6 away.
  const CameraModel barrel = pinhole({-2, 0, 0, 0, 0});
  const auto disc = SeaView::make(barrel, pose(0, -90, 0, {0, 0, -60}), {10_deg}).value();
  EXPECT_FALSE(disc.cut_by_grazing_limit());
  std::mt19937 rng(1);
  expect_outlines_what_it_sees(disc, rng, "disc");
}

TEST(SeaView, RefusesACameraInOrBelowTheSeaAndSaysTheHeight) {
  const auto made = [](double down_m) {
    return SeaView::make(pinhole(), pose(0, -90, 0, {0, 0, down_m}));
  };
  EXPECT_TRUE(succeeds(made(-0.01)));
  EXPECT_TRUE(
      fails_with(made(0.0), ErrorCode::Degenerate, {"in the sea surface", "0.000 m", "sea level"}));
  EXPECT_TRUE(fails_with(made(12.25), ErrorCode::Degenerate,
                         {"below the sea surface", "-12.250 m", "sea level"}));
}

TEST(SeaView, RefusesAPoseThatIsNotANumber) {
  EXPECT_TRUE(fails_with(SeaView::make(pinhole(), pose(0, -90, 0, {0, std::nan(""), -10})),
                         ErrorCode::Degenerate, {"not a number"}));
  EXPECT_TRUE(fails_with(SeaView::make(pinhole(), pose(std::nan(""), -90, 0, {0, 0, -10})),
                         ErrorCode::Degenerate, {"not a number"}));
  const Rigid3<Sea, Camera> no_rotation(Eigen::Quaterniond(0, 0, 0, 0), {{0, 0, -10}});
  EXPECT_TRUE(
      fails_with(SeaView::make(pinhole(), no_rotation), ErrorCode::Degenerate, {"not a number"}));
}

TEST_F(RandomPoses, RefusesACameraThatLooksUp) {
  for (int i = 0; i < 100; ++i) {
    const auto view = SeaView::make(
        pinhole(), pose(uniform(-180, 180), uniform(40, 90), uniform(-20, 20), {0, 0, -100}));
    EXPECT_TRUE(fails_with(view, ErrorCode::Degenerate, {"grazing limit", "10.0°", "100.0 m"}));
  }
  // So wide that it sees the sea all around although it looks up.
  EXPECT_FALSE(SeaView::make(fisheye(60), pose(0, 90, 0, {0, 0, -100})).ok());
  EXPECT_FALSE(SeaView::make(fisheye(100), pose(0, 90, 0, {0, 0, -100})).ok());
}

TEST(SeaView, GrazingLimitsThatAreNoneMakeNoView) {
  const auto with = [](double degrees) {
    return SeaView::make(pinhole(), pose(0, -90, 0, {0, 0, -100}), {Angle::degrees(degrees)});
  };
  EXPECT_FALSE(with(std::nan("")).ok());
  EXPECT_FALSE(with(91).ok());
  EXPECT_TRUE(succeeds(with(-5)));  // as none: the horizon bounds it
  EXPECT_TRUE(succeeds(with(0)));
  EXPECT_TRUE(succeeds(SeaView::make(pinhole(), pose(0, 0, 0, {0, 0, -100}), {0_deg})));
}

}  // namespace
}  // namespace watersky
