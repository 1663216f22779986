// SPDX-License-Identifier: MIT
#include "watersky/products/report.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/survey_products.hpp"
#include "watersky/products/detail/graticule.hpp"
#include "watersky/products/detail/html.hpp"

namespace watersky {
namespace {

const Products& products() {
  static const Products p = test::survey_products(test::drawn_floes(300, 450, 90, 5), 0.5);
  return p;
}

TEST(Report, NeedsNothingElse) {
  const std::string html = report_html(products()).value();
  for (const char* outside :
       {"<script", "<link", "src=\"http", "href=\"http", "url(http", "@import"})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  EXPECT_NE(html.find("data:image/png;base64,"), std::string::npos);
  EXPECT_NE(html.find("data:image/jpeg;base64,"), std::string::npos);
}

TEST(Report, ForeignTextIsText) {
  Products p = products();
  p.notes = {"<script>alert('x')</script>"};
  p.sea_level = "\"><img onerror=x>";
  const std::string html = report_html(p).value();
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<img"), std::string::npos);
  EXPECT_EQ(html.find("<b>bad"), std::string::npos);
  EXPECT_EQ(html.find("<survey"), std::string::npos);
  EXPECT_NE(html.find("Kongsfjorden &lt;survey &amp; test&gt;"), std::string::npos);
}

TEST(Report, NamesEveryFrameLeftOutAndWhy) {
  const std::string html = report_html(products()).value();
  for (const LeftOut& frame : products().left_out) {
    EXPECT_NE(html.find(detail::escaped(frame.file)), std::string::npos) << frame.file;
    EXPECT_NE(html.find(detail::escaped(frame.reason)), std::string::npos) << frame.reason;
  }
}

TEST(Report, TagsAreBalanced) {
  const std::string html = report_html(products()).value();
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const bool closes = html[at + 1] == '/';
    const std::size_t first = at + (closes ? 2 : 1);
    const std::string name = html.substr(first, html.find_first_of(" >/", first) - first);
    if (name == "!DOCTYPE" || name == "meta" || name == "input" || html[end - 1] == '/') continue;
    if (!closes) {
      open.push_back(name);
      continue;
    }
    ASSERT_FALSE(open.empty()) << name;
    EXPECT_EQ(open.back(), name);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
}

TEST(Report, AMapWithoutIceMosaicOrFramesStillHasAReport) {
  Products p(products().projection);
  p.flight_name = "bare";
  p.geotransform = products().geotransform;
  p.rasters.probability = cv::Mat(1, 1, CV_32F, cv::Scalar(0.2));
  p.rasters.looks = cv::Mat(1, 1, CV_16U, cv::Scalar(1));
  p.rasters.last_seen_s = cv::Mat(1, 1, CV_64F, cv::Scalar(5));
  analyse(p);
  const Result<std::string> html = report_html(p);
  ASSERT_TRUE(html.ok()) << html.error().message;
  for (const char* broken :
       {">nan", "\"nan", " nan", ",nan", ">inf", "\"inf", ",inf", "Lnan", "Mnan"})
    EXPECT_EQ(html->find(broken), std::string::npos) << broken;
}

TEST(Graticule, LinesAreRoundAndLabelsStandWhereTheyCross) {
  const Products& p = products();
  const double cell = p.cell_m();
  const auto to_sheet = [&](const Eigen::Vector2d& en) {
    return Eigen::Vector2d((en.x() - p.geotransform[0]) / cell,
                           (p.geotransform[3] - en.y()) / cell);
  };
  const detail::Graticule g = detail::make_graticule(p, 450, 300, to_sheet);
  std::size_t left = 0;
  for (const detail::GraticuleLabel& label : g.labels) {
    const bool is_left = label.side == detail::GraticuleSide::Left;
    left += is_left ? 1 : 0;
    const Eigen::Vector2d sheet =
        is_left ? Eigen::Vector2d(0, label.position) : Eigen::Vector2d(label.position, 300);
    const Geodetic place =
        p.projection
            .inverse({p.geotransform[0] + sheet.x() * cell, p.geotransform[3] - sheet.y() * cell})
            .value();
    int decimals = 0;
    const std::size_t point = label.text.find('.');
    if (point != std::string::npos) decimals = static_cast<int>(label.text.find("′") - point) - 1;
    EXPECT_EQ(label.text, is_left ? detail::latitude(place.latitude, decimals)
                                  : detail::longitude(place.longitude, decimals));
  }
  EXPECT_GE(left, 2u);
  EXPECT_GE(g.labels.size() - left, 2u);
}

TEST(Graticule, IsEmptyOverAPole) {
  Products p = products();
  p.projection = Projection::from_text("EPSG:3413").value();
  p.geotransform = {-100, 0.5, 0, 75, 0, -0.5};
  const auto same = [](const Eigen::Vector2d& en) { return en; };
  EXPECT_TRUE(detail::make_graticule(p, 450, 300, same).lines.empty());
}

TEST(Graticule, CrossesTheDateLine) {
  Products p = products();
  p.projection = Projection::from_text("EPSG:32601").value();
  const Eigen::Vector2d en = p.projection.forward(Angle::degrees(70), Angle::degrees(180)).value();
  p.geotransform = {en.x() - 100, 0.5, 0, en.y() + 75, 0, -0.5};
  const auto to_sheet = [&](const Eigen::Vector2d& x) {
    return Eigen::Vector2d((x.x() - p.geotransform[0]) / 0.5, (p.geotransform[3] - x.y()) / 0.5);
  };
  const detail::Graticule g = detail::make_graticule(p, 450, 300, to_sheet);
  bool east = false;
  bool west = false;
  for (const detail::GraticuleLabel& label : g.labels) {
    east |= label.text.back() == 'E';
    west |= label.text.back() == 'W';
  }
  EXPECT_TRUE(east && west);
  EXPECT_LT(g.lines.size(), 14u);
}

TEST(Html, PositionsAreDegreesAndDecimalMinutes) {
  EXPECT_EQ(detail::latitude(Angle::degrees(78.9), 3), "78°54.000′ N");
  EXPECT_EQ(detail::longitude(Angle::degrees(-9.5), 2), "009°30.00′ W");
  EXPECT_EQ(detail::latitude(Angle::degrees(-59.99999999), 3), "60°00.000′ S");
}

TEST(Html, NumbersAreRoundedForReading) {
  EXPECT_EQ(detail::metres(0.0471), "4.71 cm");
  EXPECT_EQ(detail::metres(12.345), "12.3 m");
  EXPECT_EQ(detail::square_metres(12345), "12\u2009345 m²");
  EXPECT_EQ(detail::square_metres(1234567), "1.23 km²");
  EXPECT_EQ(detail::rounded(std::nan("")), "–");
  EXPECT_EQ(detail::percent(0.3721), "37.2 %");
  EXPECT_EQ(detail::moment(1533430844.8), "2018-08-05 01:00:44 UTC");
  EXPECT_EQ(detail::moment(12.34), "12.3 s");
}

}  // namespace
}  // namespace watersky
