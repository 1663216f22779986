// SPDX-License-Identifier: MIT
#include "watersky/base/time.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace watersky {

namespace {

using namespace std::chrono;

struct Leap {
  sys_days from;  // UTC
  std::chrono::seconds gps_ahead;
};
// IERS Bulletin C: every leap second since GPS time began.
constexpr Leap kLeaps[] = {
    {sys_days{year{2017} / 1 / 1}, 18s}, {sys_days{year{2015} / 7 / 1}, 17s},
    {sys_days{year{2012} / 7 / 1}, 16s}, {sys_days{year{2009} / 1 / 1}, 15s},
    {sys_days{year{2006} / 1 / 1}, 14s}, {sys_days{year{1999} / 1 / 1}, 13s},
    {sys_days{year{1997} / 7 / 1}, 12s}, {sys_days{year{1996} / 1 / 1}, 11s},
    {sys_days{year{1994} / 7 / 1}, 10s}, {sys_days{year{1993} / 7 / 1}, 9s},
    {sys_days{year{1992} / 7 / 1}, 8s},  {sys_days{year{1991} / 1 / 1}, 7s},
    {sys_days{year{1990} / 1 / 1}, 6s},  {sys_days{year{1988} / 1 / 1}, 5s},
    {sys_days{year{1985} / 7 / 1}, 4s},  {sys_days{year{1983} / 7 / 1}, 3s},
    {sys_days{year{1982} / 7 / 1}, 2s},  {sys_days{year{1981} / 7 / 1}, 1s},
};
constexpr Time kGpsBegan{sys_days{year{1980} / 1 / 6}};

}  // namespace

Time utc_from_gps(int week, std::int64_t week_ms) {
  const Time gps = kGpsBegan + weeks(week) + milliseconds(week_ms);
  for (const Leap& leap : kLeaps)
    if (gps - leap.gps_ahead >= leap.from) return gps - leap.gps_ahead;
  return gps;
}

GpsTime gps_from_utc(Time t) {
  const auto leap = std::find_if(std::begin(kLeaps), std::end(kLeaps),
                                 [&](const Leap& l) { return t >= l.from; });
  const Time gps = leap == std::end(kLeaps) ? t : t + leap->gps_ahead;
  const auto since = round<milliseconds>(gps - kGpsBegan);
  const auto week = floor<weeks>(since);
  return {static_cast<int>(week.count()), (since - week).count()};
}

std::string to_iso8601(Time t) {
  using namespace std::chrono;
  const auto rounded = round<milliseconds>(t);
  const auto day = floor<days>(rounded);
  const year_month_day date{day};
  const hh_mm_ss clock{rounded - day};
  char text[40];
  std::snprintf(
      text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
      static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
      static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
      static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
  return text;
}

}  // namespace watersky
