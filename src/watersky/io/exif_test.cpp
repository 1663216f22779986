// SPDX-License-Identifier: MIT
#include "watersky/io/exif.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "support/make_photo.hpp"
#include "watersky/io/csv.hpp"
#include "watersky/io/files.hpp"

namespace watersky {
namespace {

using watersky::test::Bytes;
using watersky::test::make_photo;
using watersky::test::Photo;

Photo full_photo() {
  Photo p;
  p.taken = "2024:02:29 23:59:59";
  p.subsec = "4805";
  p.offset = "-03:30";
  p.focal_mm = 3.61;
  p.focal_35mm_mm = 20;
  p.latitude_deg = -78.123456789;
  p.longitude_deg = 11.987654321;
  p.altitude_m = -12.345;
  p.gps_date = "2024:03:01";
  p.gps_second = 12599.25;
  p.dji = {{"GimbalYawDegree", "+45.00"},
           {"GimbalPitchDegree", "-89.90"},
           {"GimbalRollDegree", "+0.00"},
           {"FlightYawDegree", "+46.00"},
           {"FlightPitchDegree", "+1.80"},
           {"FlightRollDegree", "-3.00"},
           {"RelativeAltitude", "+39.80"},
           {"AbsoluteAltitude", "+198.31"},
           {"RtkFlag", "50"},
           {"RtkStdLon", "0.01"},
           {"RtkStdLat", "0.02"},
           {"RtkStdHgt", "0.03"},
           {"CalibratedFocalLength", "3666.666504"}};
  return p;
}

TEST(PhotoMetadata, ReadsEveryFieldInEitherByteOrderAndSpelling) {
  for (bool big_endian : {false, true})
    for (bool elements : {false, true}) {
      Photo p = full_photo();
      p.big_endian = big_endian;
      p.dji_as_elements = elements;
      const auto m = parse_photo_metadata(make_photo(p));
      ASSERT_TRUE(m) << m.error().message;
      EXPECT_EQ(m->width_px, 64);
      EXPECT_EQ(m->height_px, 48);
      EXPECT_EQ(m->camera_name(), "DJI FC300S");
      EXPECT_NEAR(m->focal_length_mm.value(), 3.61, 1e-12);
      EXPECT_EQ(m->focal_length_35mm_mm, 20.0);
      // A microsecond of arc, 0.03 mm.
      EXPECT_NEAR(m->latitude.value().degrees(), -78.123456789, 3e-10);
      EXPECT_NEAR(m->longitude.value().degrees(), 11.987654321, 3e-10);
      EXPECT_NEAR(m->gps_altitude_m.value(), -12.345, 1e-9);
      EXPECT_EQ(to_iso8601(m->taken_local.value()), "2024-02-29T23:59:59.480Z");
      EXPECT_EQ(m->utc_offset, -std::chrono::minutes(210));
      EXPECT_EQ(m->utc(), *m->taken_local + std::chrono::minutes(210));
      EXPECT_EQ(to_iso8601(m->gps_time.value()), "2024-03-01T03:29:59.250Z");
      EXPECT_NEAR(m->gimbal.value().pitch.degrees(), -89.9, 1e-12);
      EXPECT_NEAR(m->gimbal->yaw.degrees(), 45, 1e-12);
      EXPECT_NEAR(m->flight.value().roll.degrees(), -3, 1e-12);
      EXPECT_EQ(m->relative_altitude_m, 39.8);
      EXPECT_EQ(m->absolute_altitude_m, 198.31);
      EXPECT_TRUE(m->altitude_is_ellipsoidal);
      EXPECT_EQ(m->rtk_sigma_east_m, 0.01);
      EXPECT_EQ(m->rtk_sigma_north_m, 0.02);
      EXPECT_EQ(m->rtk_sigma_height_m, 0.03);
      EXPECT_EQ(m->calibrated_focal_px, 3666.666504);
    }
}

TEST(PhotoMetadata, WhatIsNotThereIsNotMadeUp) {
  Photo p;
  p.make = p.model = "";
  const auto m = parse_photo_metadata(make_photo(p)).value();
  EXPECT_FALSE(m.latitude || m.longitude || m.taken_local || m.utc() || m.gimbal || m.flight);
  EXPECT_FALSE(m.focal_length_mm || m.relative_altitude_m || m.altitude_is_ellipsoidal);
  EXPECT_EQ(m.camera_name(), "");
}

TEST(PhotoMetadata, ALocalTimeAloneIsNoUtc) {
  Photo p;
  p.taken = "2016:06:23 16:31:59";
  const auto m = parse_photo_metadata(make_photo(p)).value();
  EXPECT_TRUE(m.taken_local);
  EXPECT_FALSE(m.utc());
}

TEST(PhotoMetadata, AReceiverWithoutAFixIsNoPosition) {
  Photo p;
  p.latitude_deg = p.longitude_deg = 0.0;
  EXPECT_FALSE(parse_photo_metadata(make_photo(p))->latitude);
}

TEST(PhotoMetadata, ReadsDjisCalibration) {
  Photo p;
  p.dji = {{"DewarpData",
            "2018-09-10;3678.87,3671.84,10.1,27.29,-0.268652,0.114663,0.000015685,-0.0000460703,-0."
            "0350261"},
           {"DewarpFlag", "0"}};
  const auto m = parse_photo_metadata(make_photo(p)).value();
  ASSERT_EQ(m.dewarp.size(), 9u);
  EXPECT_EQ(m.dewarp[0], 3678.87);
  EXPECT_EQ(m.dewarp[8], -0.0350261);
  EXPECT_FALSE(m.dewarped);
}

TEST(PhotoMetadata, AHeaderThatEndsAsksForMoreAndNeverLies) {
  const Bytes whole = make_photo(full_photo());
  std::size_t first_good = 0;
  for (std::size_t n = 0; n <= whole.size(); ++n) {
    const auto m = parse_photo_metadata(std::span(whole).first(n));
    if (m) {
      if (first_good == 0) first_good = n;
      EXPECT_EQ(m->width_px, 64);
    } else {
      EXPECT_EQ(first_good, 0u);
      EXPECT_EQ(m.error().code, ErrorCode::OutOfRange);
    }
  }
  EXPECT_GT(first_good, 500u);
  EXPECT_LT(first_good, whole.size());
}

TEST(PhotoMetadata, DamagedBytesNeverCrash) {
  std::mt19937 rng(6);
  const Bytes whole = make_photo(full_photo());
  for (int i = 0; i < 3000; ++i) {
    Bytes bytes(whole.begin(), whole.begin() + 2000);
    for (int k = 0; k < 5; ++k) bytes[rng() % bytes.size()] = static_cast<std::uint8_t>(rng());
    if (const auto m = parse_photo_metadata(bytes)) {
      EXPECT_LE(std::abs(m->latitude.value_or(Angle{}).degrees()), 91.0);
      EXPECT_GT(m->width_px, 0);
    }
  }
}

TEST(ExifTime, RefusesWhatIsNoDate) {
  for (const char* bad : {"", "0000:00:00 00:00:00", "    :  :     :  :  ", "2023:02:29 10:00:00",
                          "2023:13:01 10:00:00", "2023:01:01 24:00:00", "2023:01:01"})
    EXPECT_FALSE(parse_exif_time(bad)) << bad;
  EXPECT_EQ(to_iso8601(parse_exif_time("2016:06:23 16:31:59", "4").value()),
            "2016-06-23T16:31:59.400Z");
  EXPECT_EQ(parse_utc_offset("+02:00"), std::chrono::hours(2));
  EXPECT_EQ(parse_utc_offset("-0930"), -std::chrono::minutes(570));
  EXPECT_EQ(parse_utc_offset("Z"), Duration{0});
  for (const char* bad : {"", "02:00", "+2", "+99:00"}) EXPECT_FALSE(parse_utc_offset(bad)) << bad;
}

// poses.csv was written by exiftool, an independent reader.
TEST(PhotoMetadata, AgreesWithExiftoolOnBrightonBeach) {
  const auto data = watersky::test::real_data("brighton_beach");
  if (!data) GTEST_SKIP() << "the real data is not here";
  const auto t = CsvTable::parse(read_text(*data / "poses.csv").value(), "poses.csv").value();
  ASSERT_EQ(t.rows(), 18u);
  for (std::size_t row = 0; row < t.rows(); ++row) {
    const auto value = [&](const char* name) {
      return t.number(row, t.column(name).value()).value();
    };
    const auto m = read_photo_metadata(*data / t.cell(row, 0));
    ASSERT_TRUE(m) << m.error().message;
    EXPECT_NEAR(m->latitude.value().degrees(), value("GPSLatitude"), 1e-12);
    EXPECT_NEAR(m->longitude.value().degrees(), value("GPSLongitude"), 1e-12);
    EXPECT_NEAR(m->gps_altitude_m.value(), value("GPSAltitude"), 1e-9);
    EXPECT_EQ(m->absolute_altitude_m, value("AbsoluteAltitude"));
    EXPECT_EQ(m->relative_altitude_m, value("RelativeAltitude"));
    EXPECT_NEAR(m->gimbal.value().yaw.degrees(), value("GimbalYawDegree"), 1e-12);
    EXPECT_NEAR(m->gimbal->pitch.degrees(), value("GimbalPitchDegree"), 1e-12);
    EXPECT_NEAR(m->gimbal->roll.degrees(), value("GimbalRollDegree"), 1e-12);
    EXPECT_NEAR(m->flight.value().yaw.degrees(), value("FlightYawDegree"), 1e-12);
    EXPECT_NEAR(m->flight->pitch.degrees(), value("FlightPitchDegree"), 1e-12);
    EXPECT_NEAR(m->flight->roll.degrees(), value("FlightRollDegree"), 1e-12);
    EXPECT_NEAR(m->focal_length_mm.value(), value("FocalLength"), 1e-12);
    EXPECT_EQ(m->width_px, value("ImageWidth"));
    EXPECT_EQ(m->height_px, value("ImageHeight"));
    EXPECT_EQ(m->taken_local, parse_exif_time(t.cell(row, t.column("DateTimeOriginal").value())));
  }
}

}  // namespace
}  // namespace watersky
