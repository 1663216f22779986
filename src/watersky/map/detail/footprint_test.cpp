// SPDX-License-Identifier: MIT
#include "watersky/map/detail/footprint.hpp"

#include <gtest/gtest.h>

#include <map>

#include "watersky/map/detail/test_scene.hpp"

namespace watersky::detail {
namespace {

/// Random views through lenses of all kinds, some with a shutter that rolls, some with the horizon
/// in sight.
class RandomViews {
 public:
  std::optional<GridView> next() {
    const int kind = count_++ % 4;
    const auto width = static_cast<int>(uniform(80, 500)),
               height = static_cast<int>(uniform(60, 400));
    Eigen::Matrix3d a;
    const double focal = uniform(0.5, 1.6) * width;
    a << focal, 0, 0.5 * width, 0, focal, 0.5 * height, 0, 0, 1;
    const bool fisheye = kind == 2;
    const std::vector<double> k =
        kind == 0 ? std::vector<double>{}
        : fisheye ? std::vector<double>{0.02, -0.005, 0.0, 0.0}
                  : std::vector<double>{uniform(-0.25, 0.1), 0.04, 0.001, -0.001, 0.0};
    const CameraModel camera =
        CameraModel::make(fisheye ? LensModel::Fisheye : LensModel::Pinhole, width, height, a, k)
            .value();
    test::FlatGrid grid;
    grid.cell_m = uniform(0.1, 2.0);
    const auto view = SeaView::make(
        camera,
        test::pose({uniform(-50, 50), uniform(-50, 50), -uniform(10, 120)},
                   {Angle::degrees(uniform(0, 360)), Angle::degrees(uniform(-90, -20)),
                    Angle::degrees(uniform(-20, 20))}),
        {Angle::degrees(10)});
    if (!view) return std::nullopt;
    RollingShutter shutter;
    if (kind == 3) shutter = {0.05, {9.0, -6.0, 1.0}, {0.2, -0.1, 0.3}};
    auto made = make_grid_view(*view, grid.sea_from_grid(), shutter);
    return made ? std::optional<GridView>(*made) : std::nullopt;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng_);
  }
  std::mt19937 rng_{5};
  int count_ = 0;
};

TEST(Footprint, PatchesAreWithinA32ndOfAPixelAndTheirBounds) {
  RandomViews views;
  std::size_t cells = 0;
  double worst = 0.0;
  for (int i = 0; i < 1500; ++i) {
    const auto view = views.next();
    if (!view || 1.0 * view->box.columns * view->box.rows > 3e5) continue;
    const CellProjection projection(*view);
    Footprint(*view, 0).for_each([&](const FootprintPart& part) {
      if (part.exact) return;
      for (int j = 0; j < part.cells; j += 3)
        for (int c = 0; c < part.cells; c += 3) {
          const auto exact = projection(part.first_column() + c, part.first_row() + j);
          ASSERT_TRUE(exact);
          const Pixel p = part.patch.at(c, j);
          const double error =
              std::max(std::abs(p.u - exact->u), std::abs(p.v - exact->v)) / part.averaging.shrink;
          worst = std::max(worst, error);
          ASSERT_GE(p.u, part.low.x());
          ASSERT_GE(p.v, part.low.y());
          ASSERT_LE(p.u, part.high.x());
          ASSERT_LE(p.v, part.high.y());
          ++cells;
        }
    });
  }
  EXPECT_LT(worst, Footprint::kMostError_px);
  EXPECT_GT(worst, Footprint::kTolerance_px / 2);
  EXPECT_GT(cells, 1'000'000u);
}

TEST(Footprint, PartsHoldEverySeenCellOnce) {
  RandomViews views;
  for (int i = 0; i < 200; ++i) {
    const auto view = views.next();
    if (!view || 1.0 * view->box.columns * view->box.rows > 1e5) continue;
    const Footprint footprint(*view, 1);
    std::map<std::pair<int, int>, int> held;
    footprint.for_each([&](const FootprintPart& part) {
      for (int r = 0; r < part.cells; ++r)
        for (int c = 0; c < part.cells; ++c) {
          ++held[{part.first_column() + c, part.first_row() + r}];
          ASSERT_TRUE(!part.inside || part.limited ||
                      footprint.seen(part.first_column() + c, part.first_row() + r));
        }
    });
    for (const auto& [cell, times] : held) ASSERT_EQ(times, 1);
    for (int r = view->box.first_row; r < view->box.end_row(); r += 2)
      for (int c = view->box.first_column; c < view->box.end_column(); c += 2)
        ASSERT_TRUE(!footprint.seen(c, r) || held.contains({c, r})) << i << " " << c << "," << r;
  }
}

}  // namespace
}  // namespace watersky::detail
