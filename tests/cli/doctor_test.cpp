// SPDX-License-Identifier: MIT
/// The doctor, on this machine and on machines that lack something or lie.
#include <gmock/gmock.h>

#include "cli_support.hpp"

namespace watersky::test {
namespace {

using ::testing::HasSubstr;

/// The findings of that name, of a call that must have worked.
std::vector<nlohmann::json> findings(const nlohmann::json& report, const std::string& name) {
  std::vector<nlohmann::json> found;
  for (const auto& finding : report["findings"])
    if (finding["name"] == name) found.push_back(finding);
  return found;
}

/// Only the OpenCL driver of tests/cli/faulty_opencl_driver.cpp, with its kind of fault.
std::string with_faulty_driver(const TemporaryFolder& folder, const std::string& fault) {
  write_text(folder.path() / "faulty.icd", WATERSKY_FAULTY_OPENCL_DRIVER "\n");
  return "OCL_ICD_VENDORS='" + folder.path().string() + "' WATERSKY_TEST_DRIVER=" + fault + " ";
}

bool has_opencl() {
  for (const auto& f : findings(watersky("doctor --json").json(), "opencl"))
    if (f["details"].value("agrees", false)) return true;
  return false;
}

TEST(Doctor, FindsThatThisMachineCanMap) {
  const Outcome o = watersky("doctor --json");
  ASSERT_EQ(o.status, 0) << o.out << o.err;
  const auto report = o.json();
  EXPECT_TRUE(report["works"].get<bool>());
  for (const char* name : {"cpu", "simd", "memory", "clock", "disk", "gdal.drivers", "proj",
                           "proj.geoid", "video", "video.opencv", "opencl"})
    EXPECT_FALSE(findings(report, name).empty()) << name;
  EXPECT_GT(findings(report, "cpu")[0]["details"]["cores"], 0);
  EXPECT_GT(findings(report, "disk")[0]["details"]["write_mb_s"], 0.0);
  for (const auto& finding : report["findings"])
    EXPECT_TRUE(finding["health"] != "fault") << finding;
}

TEST(Doctor, SaysTheRemedyBesideEachFaultAndWarning) {
  const Outcome o = watersky("doctor", "GDAL_SKIP=COG PROJ_DATA=/nowhere PROJ_LIB=/nowhere PATH= ");
  EXPECT_EQ(o.status, 1) << o.out;
  std::istringstream lines(o.out);
  int faults = 0, warnings = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool fault = line.rfind("fault", 0) == 0, warning = line.rfind("warning", 0) == 0;
    faults += fault, warnings += warning;
    if (fault || warning) {
      EXPECT_THAT(line, HasSubstr(" -> "));
    }
  }
  EXPECT_EQ(faults, 2) << o.out;    // no COG, no projections
  EXPECT_GE(warnings, 2) << o.out;  // no geoid, no ffmpeg
  EXPECT_THAT(o.out, HasSubstr("ffmpeg"));
  EXPECT_THAT(o.out, HasSubstr("cannot work here"));
}

TEST(Doctor, AFolderThatCannotBeWrittenToIsAWarning) {
  const Outcome o = watersky("doctor --json --folder /proc");
  EXPECT_EQ(o.status, 0) << o.out;
  EXPECT_EQ(findings(o.json(), "disk")[0]["health"], "warning");
  EXPECT_NE(findings(o.json(), "disk")[0]["remedy"], "");
}

TEST(Doctor, LeavesNothingInTheFolder) {
  const TemporaryFolder folder;
  ASSERT_EQ(watersky("doctor --quiet --folder '" + folder.path().string() + "'").status, 0);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Doctor, SurvivesAnOpenClDriverThatCrashes) {
  const TemporaryFolder folder;
  const Outcome o = watersky("doctor --json", with_faulty_driver(folder, "crash"));
  ASSERT_EQ(o.status, 0) << o.err;
  const auto opencl = findings(o.json(), "opencl");
  ASSERT_EQ(opencl.size(), 1u) << o.out;
  if (opencl[0]["health"] == "ok") GTEST_SKIP() << "no OpenCL loader (ocl-icd-libopencl1)";
  EXPECT_THAT(opencl[0]["value"].get<std::string>(),
              HasSubstr("died of SIGSEGV while looking for platforms"));
}

TEST(Doctor, SurvivesAnOpenClDriverThatHangs) {
  const TemporaryFolder folder;
  const Outcome o =
      watersky("doctor --json --opencl-timeout-s 1", with_faulty_driver(folder, "hang"));
  ASSERT_EQ(o.status, 0) << o.err;
  const auto opencl = findings(o.json(), "opencl");
  ASSERT_EQ(opencl.size(), 1u) << o.out;
  if (opencl[0]["health"] == "ok") GTEST_SKIP() << "no OpenCL loader (ocl-icd-libopencl1)";
  EXPECT_THAT(opencl[0]["value"].get<std::string>(), HasSubstr("hangs"));
}

// A driver that leaves most of each kernel's work undone and calls it a success, as section 4.4
// of the thesis met one that computed wrong.
TEST(Doctor, NamesAnOpenClDriverThatComputesWrong) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device; pocl-opencl-icd is one";
  const std::string wrong =
      "OPENCV_OPENCL_RUNTIME='" WATERSKY_FAULTY_OPENCL_DRIVER "' WATERSKY_TEST_DRIVER=wrong ";
  const Outcome o = watersky("doctor --json", wrong);
  ASSERT_EQ(o.status, 0) << o.err;
  const auto opencl = findings(o.json(), "opencl");
  ASSERT_FALSE(opencl.empty()) << o.out;
  EXPECT_EQ(opencl[0]["health"], "warning") << opencl[0];
  EXPECT_THAT(opencl[0]["value"].get<std::string>(), HasSubstr("computes wrong"));
  EXPECT_FALSE(opencl[0]["details"]["agrees"].get<bool>());

  const TemporaryFolder folder;
  const Outcome segment =
      watersky("segment '" + small_flight().string() + "/images' -o '" +
                   (folder.path() / "out").string() + "' --method edges --opencl",
               wrong);
  expect_one_line_error(segment, 1);
  EXPECT_THAT(segment.err, HasSubstr("does not compute what the processor does"));
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST(OpenCl, IsRefusedWhereItHasNothingToDo) {
  const TemporaryFolder folder;
  const Outcome o = watersky("map '" + small_flight().string() + "' -o '" +
                             (folder.path() / "out").string() + "' --opencl");
  expect_one_line_error(o, 2);
  EXPECT_THAT(o.err, HasSubstr("edges or watershed"));
}

TEST(OpenCl, SegmentsAsTheProcessorDoes) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device; pocl-opencl-icd is one";
  const TemporaryFolder folder;
  const std::string call =
      "segment '" + images_of(small_flight()).front().string() + "' --method watershed -o '";
  const Outcome here = watersky(call + (folder.path() / "here").string() + "' --json"),
                there = watersky(call + (folder.path() / "there").string() + "' --json --opencl");
  ASSERT_EQ(here.status, 0) << here.err;
  ASSERT_EQ(there.status, 0) << there.err;
  EXPECT_NEAR(here.json()["images"][0]["concentration"].get<double>(),
              there.json()["images"][0]["concentration"].get<double>(), 1e-3);
}

}  // namespace
}  // namespace watersky::test
