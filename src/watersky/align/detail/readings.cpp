// SPDX-License-Identifier: MIT
#include "watersky/align/detail/readings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "watersky/align/detail/flight_edit.hpp"
#include "watersky/align/detail/turned_images.hpp"
#include "watersky/geodesy/projection.hpp"

namespace watersky::detail {

namespace {

constexpr double kTurnPenalty = 1.0;
/// Beyond this share all images count as turned, which is a fault of the whole flight.
constexpr double kNearlyAll = 0.9;
constexpr double kFreeLogHeight = 3.0;
constexpr int kCoarse_deg = 15, kFine_deg = 3;
/// Two readings that differ by less of the height are one for all purposes.
constexpr double kSamePlace = 0.1;

enum class Axis { Up, Optical };

/// All cameras turned by one angle: their headings, or about the optical axis.
std::vector<SeenFrame> turned(std::vector<SeenFrame> frames, Axis axis, Angle by) {
  for (SeenFrame& frame : frames)
    for (Eigen::Quaterniond& q : frame.rotation)
      q = axis == Axis::Up
              ? Eigen::Quaterniond(Eigen::AngleAxisd(by.radians(), -frame.up)) * q
              : q * Eigen::Quaterniond(Eigen::AngleAxisd(by.radians(), Eigen::Vector3d::UnitZ()));
  return frames;
}

double plain_cost(const Disagreement& disagreement, std::span<const SeenFrame> frames) {
  double sum = 0.0;
  for (std::size_t p = 0; p < disagreement.pairs().size(); ++p)
    sum += disagreement.cost_of(disagreement.of_pair(p, frames, 0, 0));
  return sum;
}

/// The angle under which all cameras turned agree best.
Angle best_turn(const Disagreement& disagreement, const std::vector<SeenFrame>& frames, Axis axis) {
  int best_deg = 0;
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](int deg) {
    const double c = plain_cost(disagreement, turned(frames, axis, Angle::degrees(deg)));
    if (c < least) least = c, best_deg = deg;
  };
  for (int deg = 0; deg < 360; deg += kCoarse_deg) attempt(deg);
  const int coarse = best_deg;
  for (int off = kFine_deg; off < kCoarse_deg; off += kFine_deg) {
    attempt(coarse + off);
    attempt(coarse - off);
  }
  return Angle::degrees(best_deg).wrapped();
}

}  // namespace

std::vector<SeenFrame> see_frames(const Evidence& evidence, const Flight& flight) {
  std::vector<SeenFrame> out;
  for (const ImageFrame& frame : flight.frames) {
    const auto seen = see_frame(flight, frame, evidence.max_gap);
    if (!seen) return {};
    out.push_back(*seen);
  }
  const double first_s = out.empty() ? 0.0 : out.front().time_s;
  for (SeenFrame& frame : out) frame.time_s -= first_s;
  return out;
}

Reading read_as_recorded(const Evidence& evidence) {
  Reading reading;
  reading.as_recorded = true;
  reading.frames = see_frames(evidence, evidence.flight);
  reading.fit = evidence.disagreement.fit(reading.frames, {}, {});
  return reading;
}

std::optional<Reading> read_turned(const Evidence& evidence, const Reading& as_recorded) {
  const bool square = evidence.flight.camera.width_px() == evidence.flight.camera.height_px();
  const TurnedImages found =
      find_turned_images(evidence.disagreement, as_recorded.frames, square, kTurnPenalty);
  Reading reading;
  reading.finding.fault = MetadataFault::TurnedImages;
  for (std::size_t i = 0; i < found.quarters.size(); ++i)
    if (found.quarters[i] != 0) reading.finding.frames.push_back(evidence.frames[i]);
  const double share = static_cast<double>(reading.finding.frames.size()) /
                       static_cast<double>(found.quarters.size());
  if (share == 0.0 || share > kNearlyAll) return std::nullopt;
  reading.frames = as_recorded.frames;
  reading.quarters = found.quarters;
  reading.alone = found.alone;
  reading.together = found.together;
  reading.complexity = kTurnPenalty * static_cast<double>(reading.finding.frames.size());
  reading.fit = evidence.disagreement.fit(reading.frames, reading.quarters, {});
  return reading;
}

std::vector<Reading> other_readings(const Evidence& evidence, const Reading& as_recorded) {
  std::vector<Reading> out;
  const auto finish = [&](Reading reading, const NuisancePrior& prior) {
    if (reading.frames.empty()) return;
    reading.fit = evidence.disagreement.fit(reading.frames, {}, prior);
    out.push_back(std::move(reading));
  };
  const auto edited = [&](const MetadataFinding& finding, double complexity) {
    Flight flight = evidence.flight;
    if (!apply(finding, flight)) return;  // without a geoid there is no height above it
    finish({.finding = finding,
            .as_recorded = false,
            .frames = see_frames(evidence, flight),
            .quarters = {},
            .fit = {},
            .complexity = complexity,
            .alone = {},
            .together = {}},
           {});
  };
  const auto turn = [&](MetadataFault fault, Axis axis, Angle by, double complexity) {
    MetadataFinding finding;
    finding.fault = fault;
    finding.turn = by;
    finish({.finding = finding,
            .as_recorded = false,
            .frames = turned(as_recorded.frames, axis, by),
            .quarters = {},
            .fit = {},
            .complexity = complexity,
            .alone = {},
            .together = {}},
           {});
  };
  const auto plain = [](MetadataFault fault) {
    MetadataFinding finding;
    finding.fault = fault;
    return finding;
  };

  edited(plain(MetadataFault::YawSign), 1.0);
  edited(plain(MetadataFault::RollSign), 1.0);
  edited(plain(MetadataFault::PitchSign), 1.0);
  edited(plain(MetadataFault::RollPitchSwapped), 1.5);
  edited(plain(MetadataFault::RollAndPitchSign), 1.5);
  edited(plain(MetadataFault::YawFromEast), 1.5);
  edited(plain(MetadataFault::EastNorthUp), 2.0);
  edited(plain(MetadataFault::AllSigns), 2.0);
  for (const int quarter_turns : {2, 1, 3}) {
    const Angle by = Angle::degrees(90.0 * quarter_turns).wrapped();
    turn(MetadataFault::CameraTurned, Axis::Optical, by, 1.5);
    turn(MetadataFault::YawOffset, Axis::Up, by, 2.0);
  }
  const Angle offset = best_turn(evidence.disagreement, as_recorded.frames, Axis::Up);
  constexpr double kQuarter_deg = 90.0;
  if (std::abs(std::remainder(offset.degrees(), kQuarter_deg)) > kFine_deg)
    turn(MetadataFault::YawOffset, Axis::Up, offset, 3.0);
  for (const HeightZero zero : {HeightZero::Sea, HeightZero::Datum, HeightZero::Geoid}) {
    MetadataFinding finding = plain(MetadataFault::HeightsInFeet);
    finding.height_zero = zero;
    edited(finding, 1.5);
  }
  edited(plain(MetadataFault::PositionsInFeet), 1.5);
  const Geodetic place =
      evidence.flight.datum.geodetic(Point<World>{as_recorded.frames[0].origin[0]});
  if (const auto geoid_m = egm96_above_ellipsoid_m(place.latitude, place.longitude))
    for (const double shift_m : {*geoid_m, -*geoid_m}) {
      MetadataFinding finding = plain(MetadataFault::HeightReference);
      finding.height_shift_m = shift_m;
      edited(finding, 2.0);
    }
  NuisancePrior free;
  free.log_height = kFreeLogHeight;
  finish({.finding = plain(MetadataFault::HeightScale),
          .as_recorded = false,
          .frames = as_recorded.frames,
          .quarters = {},
          .fit = {},
          .complexity = 3.0,
          .alone = {},
          .together = {}},
         free);
  return out;
}

bool equivalent(const Evidence& evidence, const Reading& a, const Reading& b) {
  std::vector<double> apart_m, heights_m;
  const auto turn = [](const Reading& r, std::size_t frame) {
    return static_cast<std::size_t>(r.quarters.empty() ? 0 : r.quarters[frame]);
  };
  for (const PairRays& p : evidence.disagreement.pairs()) {
    const auto in_a =
        evidence.disagreement.on_sea(a.frames, p.a, p.rays_a[turn(a, p.a)], a.fit.nuisance);
    const auto in_b =
        evidence.disagreement.on_sea(b.frames, p.a, p.rays_a[turn(b, p.a)], b.fit.nuisance);
    for (std::size_t i = 0; i < in_a.size(); ++i) {
      const double off = (in_a[i] - in_b[i]).norm();
      apart_m.push_back(std::isfinite(off) ? off : std::numeric_limits<double>::infinity());
    }
    heights_m.push_back(std::abs(a.frames[p.a].height_m()) * std::exp(a.fit.nuisance.log_height));
  }
  return median_of(std::move(apart_m)) < kSamePlace * median_of(std::move(heights_m));
}

}  // namespace watersky::detail
