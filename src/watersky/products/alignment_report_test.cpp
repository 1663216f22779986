// SPDX-License-Identifier: MIT
#include "watersky/products/alignment_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/survey_products.hpp"
#include "support/temporary_folder.hpp"
#include "watersky/io/read_flight.hpp"
#include "watersky/products/alignment_products.hpp"
#include "watersky/products/detail/alignment_pictures.hpp"
#include "watersky/products/detail/chart.hpp"
#include "watersky/products/detail/html.hpp"
#include "watersky/products/report.hpp"
#include "watersky/products/run_json.hpp"
#include "watersky/sim/simulate.hpp"

namespace watersky {
namespace {

constexpr double kDelay_s = 0.2;
constexpr double kNorth_m = 3.0, kAboutDown_rad = 0.02;

/// A small flight whose images arrive late, and an alignment of it that is made up: the true times
/// and, in the last frames, a correction that is known.
AlignmentRun made_up_run(AlignMethod method = AlignMethod::Full) {
  sim::Scenario scenario = sim::scenario_preset("not_easy").value();
  scenario.aircraft.legs = 1;
  scenario.aircraft.leg_length_m = 120;
  scenario.lens.width_px = 160;
  scenario.lens.height_px = 128;
  scenario.lens.focal_px = 150;
  scenario.sensor.supersampling = 1;
  scenario.camera.capture_recorded = false;
  scenario.camera.arrival_delay_s = kDelay_s;
  const sim::Simulation simulation = sim::simulate(scenario).value();
  Flight flight = simulation.flight;
  flight.name = "Kongsfjorden <survey & test>";
  flight.delay_s.reset();
  Alignment a;
  a.method = method;
  for (std::size_t i = 0; i < flight.frames.size(); ++i) {
    AlignedFrame f;
    f.index = i;
    f.captured = simulation.truth.frames[i].captured_at;
    f.pose = flight.trajectory.at(f.captured, seconds(1)).value();
    f.delay_s = to_seconds(*flight.frames[i].received_at - f.captured);
    if (i > 0) {
      const auto& is = f.pose.world_from_body;
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(kAboutDown_rad, Eigen::Vector3d::UnitZ()));
      f.pose.world_from_body = Rigid3<World, Body>(
          turn * is.rotation(), Point<World>{is.origin().v + Eigen::Vector3d(kNorth_m, 0, 0)});
    }
    a.frames.push_back(f);
  }
  a.left_out = {{"late<r>.png", "it came after the last <pose>"}};
  a.estimates = {{"mount_about_optical_axis_deg", "deg", 1.53, 0.0, 0.12, 3.0, true},
                 {"focal_scale", "1", 1.0, 1.0, 0.003, 0.003, false}};
  a.delay_estimated = method != AlignMethod::AsGiven;
  if (a.delay_estimated)
    a.delay = {{*flight.frames.front().received_at, 0.19, 0.003},
               {*flight.frames.back().received_at, 0.21, 0.004}};
  else
    a.method_reason = "only 3 <places> were seen";
  a.mount = flight.mount;
  a.as_given = {100, 3.0, 5.0, 10.0};
  a.constant_delay = {100, 1.0, 2.0, 3.0};
  a.after = {100, 0.1, 0.2, 0.3};
  a.notes = {"<script>alert('x')</script>"};
  Flight corrected = aligned(flight, a).value();
  corrected.notes = a.notes;
  return {flight, corrected, a, {}, 1, 2.5};
}

const AlignmentRun& run() {
  static const AlignmentRun made = made_up_run();
  return made;
}

TEST(AlignmentReport, NeedsNothingElseAndForeignTextIsText) {
  for (const AlignMethod method : {AlignMethod::Full, AlignMethod::AsGiven}) {
    const std::string html = alignment_report_html(made_up_run(method)).value();
    for (const char* outside : {"<script", "<link", "src=\"http", "href=\"http", "url(http",
                                "@import", "<pose", "<place", "<survey", "late<r"})
      EXPECT_EQ(html.find(outside), std::string::npos) << outside;
    EXPECT_NE(html.find("Kongsfjorden &lt;survey &amp; test&gt;"), std::string::npos);
    EXPECT_NE(html.find("late&lt;r&gt;.png"), std::string::npos);
    for (const char* broken : {">nan", "\"nan", " nan", ",nan", "Lnan", "Mnan", ">inf", "\"inf"})
      EXPECT_EQ(html.find(broken), std::string::npos) << broken;
  }
}

TEST(AlignmentReport, TagsAreBalanced) {
  const std::string html = alignment_report_html(run()).value();
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const bool closes = html[at + 1] == '/';
    const std::size_t first = at + (closes ? 2 : 1);
    const std::string name = html.substr(first, html.find_first_of(" >/", first) - first);
    if (name == "!DOCTYPE" || name == "meta" || name == "img" || html[end - 1] == '/') continue;
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

TEST(AlignmentReport, ShowsWhatWasFoundAndWhatWasNot) {
  const std::string html = alignment_report_html(run()).value();
  for (const char* figure :
       {"200.0 ± 3.5", "0.100 m", "3.00 m", "mount about optical axis", "1.53°",
        "not observed, stays as given", "class=\"band\"", "<circle", "Errors of the navigation",
        "data:image/jpeg;base64,", "The frames' mean"})
    EXPECT_NE(html.find(figure), std::string::npos) << figure;
}

TEST(AlignmentReport, WhereNothingWasAlignedItSaysSoAndWhy) {
  const AlignmentRun as_given = made_up_run(AlignMethod::AsGiven);
  const std::string html = alignment_report_html(as_given).value();
  EXPECT_NE(html.find("only 3 &lt;places&gt; were seen"), std::string::npos);
  EXPECT_EQ(html.find("Before and after"), std::string::npos);
  const auto json = alignment_json(as_given);
  EXPECT_EQ(json["method"], "as given");
  EXPECT_EQ(json["reason"], "only 3 <places> were seen");
  EXPECT_FALSE(json["delay"]["estimated"]);
  EXPECT_TRUE(json["delay"]["mean_s"].is_null());
}

TEST(AlignmentJson, HoldsWhatTheContractNames) {
  const auto json = alignment_json(run(), {{"frame_00001.png", "cut short"}});
  EXPECT_EQ(json["method"], "full");
  EXPECT_TRUE(json["reason"].is_null());
  EXPECT_NEAR(json["delay"]["mean_s"], 0.2, 1e-12);
  EXPECT_NEAR(json["delay"]["sigma_s"], std::sqrt((9e-6 + 16e-6) / 2), 1e-12);
  EXPECT_EQ(json["delay"]["course"].size(), 2u);
  ASSERT_EQ(json["estimates"].size(), 2u);
  EXPECT_TRUE(json["estimates"][0]["observed"]);
  EXPECT_FALSE(json["estimates"][1]["observed"]);
  EXPECT_NEAR(json["mount"]["found"]["pitch_deg"], -90, 1e-6);
  EXPECT_EQ(json["disagreement"]["after"]["ties"], 100);
  EXPECT_TRUE(json["shared_offset_covariance_m2"].is_null());
  EXPECT_TRUE(json["anchors"].empty());
  EXPECT_TRUE(json["range_finder"].is_null());
  const std::size_t frames = run().given.frames.size();
  EXPECT_EQ(json["per_frame"].size(), frames);
  EXPECT_EQ(json["frames"]["used"], frames - 1);
  EXPECT_EQ(json["frames"]["left_out"].size(), 2u);
}

TEST(AlignmentJson, TellsWhatBecameOfKnownPoints) {
  AlignmentRun known = run();
  known.alignment.anchors = {
      {"cairn <1>", 5, 4, {1.0, -2.0}, {0.1, 0.0}, 2.3, 0.15, "in f.png it lies 9 m off"},
      {"buoy", 1, 0, {}, {}, 0, 0, "it contradicts"}};
  known.alignment.ranges = {100, 90, -8.0, 0.05};
  const auto json = alignment_json(known, {});
  ASSERT_EQ(json["anchors"].size(), 2u);
  EXPECT_EQ(json["anchors"][0]["used"], 4);
  EXPECT_EQ(json["anchors"][0]["as_given"]["east_m"], -2.0);
  EXPECT_EQ(json["anchors"][0]["after_rms_m"], 0.15);
  EXPECT_TRUE(json["anchors"][1]["after_rms_m"].is_null());
  EXPECT_EQ(json["anchors"][1]["left_out"], "it contradicts");
  EXPECT_EQ(json["range_finder"]["height_as_given_m"], -8.0);
  const std::string html = alignment_report_html(known).value();
  EXPECT_THAT(html, ::testing::HasSubstr("cairn &lt;1&gt;"));
  EXPECT_THAT(html, ::testing::HasSubstr("90 of 100"));
  EXPECT_TRUE(anchored(known.alignment));
  EXPECT_FALSE(anchored(run().alignment));
}

TEST(PoseCorrections, AreCorrectedLessRecordedAlongNorthEastDown) {
  const auto corrections = pose_corrections(run());
  ASSERT_EQ(corrections.size(), run().given.frames.size());
  EXPECT_LT(corrections[0].position_m.norm(), 1e-9);
  EXPECT_LT(corrections[0].turn_rad.norm(), 1e-9);
  for (std::size_t k = 1; k < corrections.size(); ++k) {
    // The scene is near its datum: north there is World's first axis within metres of Earth.
    EXPECT_LT((corrections[k].position_m - Eigen::Vector3d(kNorth_m, 0, 0)).norm(), 1e-3);
    EXPECT_LT((corrections[k].turn_rad - Eigen::Vector3d(0, 0, kAboutDown_rad)).norm(), 1e-5);
  }
}

TEST(BeforeAfter, TruePosesMakeTheFramesAgreeAndLateOnesDoNot) {
  AlignmentRun truth = made_up_run();
  for (AlignedFrame& f : truth.alignment.frames)
    f.pose = truth.given.trajectory.at(f.captured, seconds(1)).value();
  truth.corrected = aligned(truth.given, truth.alignment).value();
  // Another delay in each frame, or all would only be shifted alike.
  for (std::size_t i = 0; i < truth.given.frames.size(); i += 2)
    *truth.given.frames[i].received_at += std::chrono::milliseconds(300);
  const auto pictures = detail::before_after(truth);
  ASSERT_TRUE(pictures);
  EXPECT_GE(pictures->frames, 2u);
  EXPECT_EQ(pictures->before.mean.size(), pictures->after.spread.size());
  EXPECT_LT(pictures->after.spread_levels, 0.8 * pictures->before.spread_levels);
}

TEST(RunAlignment, AnAssumedTimeIsNoTime) {
  // Two frames tell nothing; of their times only the arrival is known.
  AlignmentRun two = made_up_run();
  two.given.frames.resize(2);
  const auto made = run_alignment(two.given, {});
  ASSERT_TRUE(made) << made.error().message;
  if (made->alignment.method != AlignMethod::AsGiven) GTEST_SKIP() << "two frames were enough";
  EXPECT_TRUE(made->corrected.frames.empty());
  EXPECT_EQ(made->corrected.left_out.size(), 2u);
  const test::TemporaryFolder folder;
  const auto written = write_alignment(*made, folder.path() / "out");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::NotFound);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));

  two.given.delay_s = kDelay_s;
  const auto with_delay = run_alignment(two.given, {});
  ASSERT_TRUE(with_delay);
  EXPECT_EQ(with_delay->corrected.frames.size(), 2u);
}

TEST(WriteAlignment, IsAFlightAgainAndReplacesOnlyItself) {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  ASSERT_TRUE(write_alignment(run(), out));
  const auto read = read_flight(out);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->frames.size(), run().corrected.frames.size());
  for (std::size_t k = 0; k < read->frames.size(); ++k) {
    EXPECT_EQ(read->frames[k].captured_at, run().corrected.frames[k].captured_at);
    EXPECT_TRUE(read->trajectory.at(*read->frames[k].captured_at, Duration(0)));
  }
  EXPECT_EQ(write_alignment(run(), out).error().code, ErrorCode::Exists);
  EXPECT_TRUE(write_alignment(run(), out, {.overwrite = true}));
  EXPECT_EQ(check_alignment_output(out, out, {.overwrite = true}).error().code, ErrorCode::Exists)
      << "the flight itself";
  std::filesystem::remove(out / "align.json");
  EXPECT_EQ(write_alignment(run(), out, {.overwrite = true}).error().code, ErrorCode::Exists)
      << "a recording";
}

TEST(MapReport, TellsOfTheAlignment) {
  Products p = test::survey_products(test::drawn_floes(60, 90, 9, 5), 0.5);
  EXPECT_EQ(report_html(p)->find("Alignment</h2>"), std::string::npos);
  EXPECT_TRUE(run_json(p)["alignment"].is_null());
  p.alignment = std::make_shared<const AlignmentRun>(run());
  EXPECT_NE(report_html(p)->find("Alignment</h2>"), std::string::npos);
  EXPECT_EQ(run_json(p)["alignment"]["method"], "full");
  EXPECT_EQ(run_json(p)["timings_s"]["alignment"], 2.5);
}

TEST(ToItsSigma, KeepsTwoDigitsOfTheSigma) {
  EXPECT_EQ(to_its_sigma(1.92837, 0.0534), "1.928");
  EXPECT_EQ(to_its_sigma(255.16, 6.3), "255.2");
  EXPECT_EQ(to_its_sigma(255.16, 63), "255");
  EXPECT_EQ(to_its_sigma(-0.0001, 0.1), "0.00");
  EXPECT_EQ(to_its_sigma(1.5, 0), "1.5000");
}

TEST(TimeChart, DrawsNothingOfNothingAndBreaksWhereNothingWasMeasured) {
  EXPECT_EQ(detail::time_chart({"nothing", "m", {}}), "");
  detail::ChartSeries series{"x", "tone-a"};
  for (const double t : {0.0, 1.0, 2.0, 50.0, 51.0}) series.line.emplace_back(t, 3.0);
  const std::string svg = detail::time_chart({"two pieces", "m", {series}});
  const std::size_t curve = svg.find("class=\"curve\" d=\"M");
  ASSERT_NE(curve, std::string::npos);
  const std::string path = svg.substr(curve + 17, svg.find('"', curve + 17) - curve - 17);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 2) << path;
}

}  // namespace
}  // namespace watersky
