// SPDX-License-Identifier: MIT
#include "watersky/products/alignment_run.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace watersky {

namespace {

/// Where nothing was better than what was given, that: no regular clock under the arrivals either,
/// and no frame of which only the arrival is known when nobody knows the delay.
void put_back_as_given(const Flight& given, Duration max_gap, Alignment& alignment) {
  std::vector<AlignedFrame> kept;
  for (AlignedFrame& f : alignment.frames) {
    const ImageFrame& frame = given.frames[f.index];
    const auto leave_out = [&](const Error& e) {
      alignment.left_out.push_back({frame.name, e.message});
    };
    if (!frame.own_pose || (given.gimbal_reference && !frame.own_gimbal)) {
      const auto time = given.capture_time(frame);
      if (!time) {
        leave_out(time.error());
        continue;
      }
      const auto pose = frame.own_pose ? Result<StampedPose>(*frame.own_pose)
                                       : given.trajectory.at(*time, max_gap);
      if (!pose) {
        leave_out(pose.error());
        continue;
      }
      if (given.gimbal_reference) {
        const auto gimbal = frame.own_gimbal ? Result<Eigen::Quaterniond>(*frame.own_gimbal)
                                             : given.gimbal.at(*time, max_gap);
        if (!gimbal) {
          leave_out(gimbal.error());
          continue;
        }
        f.gimbal = *gimbal;
      }
      f.captured = f.pose.time = *time;
      f.pose.world_from_body = pose->world_from_body;
      f.delay_s = given.delay_s.value_or(0.0);
    }
    kept.push_back(std::move(f));
  }
  std::stable_sort(kept.begin(), kept.end(), [](const AlignedFrame& x, const AlignedFrame& y) {
    return x.captured < y.captured;
  });
  alignment.frames = std::move(kept);
}

/// The check asks where frames lie, roughly: it allows for a delay itself.
Result<MetadataCheck> checked_metadata(const Flight& flight, const Progress& progress) {
  constexpr double kAnyDelay_s = 0.2;
  if (flight.delay_s) return check_metadata(flight, {}, progress);
  Flight timed = flight;
  timed.delay_s = kAnyDelay_s;
  return check_metadata(timed, {}, progress);
}

}  // namespace

Result<AlignmentRun> run_alignment(const Flight& recorded, const AlignOptions& options,
                                   const Progress& progress) {
  const auto started = std::chrono::steady_clock::now();
  WATERSKY_TRY(MetadataCheck metadata, checked_metadata(recorded, progress));
  WATERSKY_TRY(Flight flight, mended(recorded, metadata.findings));
  for (const MetadataFinding& finding : metadata.findings)
    if (!finding.certain) flight.notes.push_back(finding.sentence);
  WATERSKY_TRY(Alignment alignment, align_flight(flight, options, progress));
  if (alignment.method == AlignMethod::AsGiven)
    put_back_as_given(flight, seconds(options.parameters.align_max_pose_gap_s), alignment);
  WATERSKY_TRY(Flight corrected, aligned(flight, alignment));
  AlignmentRun run{std::move(flight), std::move(corrected), std::move(alignment),
                   options.parameters, options.threads};
  run.corrected.notes.insert(run.corrected.notes.end(), run.alignment.notes.begin(),
                             run.alignment.notes.end());
  run.metadata = std::move(metadata);
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return run;
}

DelayFigures delay_figures(const Alignment& alignment) {
  DelayFigures figures;
  if (!alignment.delay_estimated || alignment.delay.empty()) return figures;
  figures.estimated = true;
  figures.least_s = figures.most_s = alignment.delay.front().delay_s;
  const auto n = static_cast<double>(alignment.delay.size());
  double squares = 0.0;
  for (const DelaySample& sample : alignment.delay) {
    figures.mean_s += sample.delay_s / n;
    squares += sample.sigma_s * sample.sigma_s / n;
    figures.least_s = std::min(figures.least_s, sample.delay_s);
    figures.most_s = std::max(figures.most_s, sample.delay_s);
  }
  figures.sigma_s = std::sqrt(squares);
  return figures;
}

std::vector<PoseCorrection> pose_corrections(const AlignmentRun& run) {
  std::vector<PoseCorrection> corrections;
  const Duration max_gap = seconds(run.parameters.align_max_pose_gap_s);
  const Flight& given = run.given;
  for (std::size_t k = 0; k < run.alignment.frames.size(); ++k) {
    const AlignedFrame& after = run.alignment.frames[k];
    const ImageFrame& frame = given.frames[after.index];
    const auto before = frame.own_pose ? Result<StampedPose>(*frame.own_pose)
                                       : given.trajectory.at(after.captured, max_gap);
    if (!before) continue;
    const Rigid3<World, Body>&from = before->world_from_body, &to = after.pose.world_from_body;
    const Eigen::Quaterniond ned_from_world =
        given.datum.world_from_ned_rotation(given.datum.geodetic(from.origin())).conjugate();
    PoseCorrection correction{k, ned_from_world * (to.origin().v - from.origin().v)};
    Eigen::Quaterniond turn =
        ned_from_world * (to.rotation() * from.rotation().conjugate()) * ned_from_world.conjugate();
    if (given.gimbal_reference == GimbalReference::NorthEastDown && after.gimbal) {
      const auto gimbal = frame.own_gimbal ? Result<Eigen::Quaterniond>(*frame.own_gimbal)
                                           : given.gimbal.at(after.captured, max_gap);
      if (!gimbal) continue;
      turn = *after.gimbal * gimbal->conjugate();
    }
    if (turn.w() < 0) turn.coeffs() *= -1.0;
    const Eigen::AngleAxisd about(turn);
    correction.turn_rad = about.angle() * about.axis();
    corrections.push_back(correction);
  }
  return corrections;
}

bool anchored(const Alignment& alignment) {
  return alignment.method == AlignMethod::Full &&
         std::any_of(alignment.anchors.begin(), alignment.anchors.end(),
                     [](const AnchorOutcome& o) { return o.used > 0; });
}

std::string summary(const AlignmentRun& run) {
  const Alignment& a = run.alignment;
  if (a.method == AlignMethod::AsGiven)
    return "Not aligned by its images, used as it was given: " +
           (a.method_reason.empty() ? std::string("nothing better was found") : a.method_reason) +
           ".";
  char text[300];
  const DelayFigures delay = delay_figures(a);
  std::string out = a.method == AlignMethod::Full ? "Aligned by its images"
                                                  : "Aligned by its images in a constant delay "
                                                    "alone";
  if (delay.estimated) {
    if (delay.sigma_s > 0)
      std::snprintf(text, sizeof text, ": delay %.1f ± %.1f ms", 1e3 * delay.mean_s,
                    1e3 * delay.sigma_s);
    else
      std::snprintf(text, sizeof text, ": delay %.1f ms", 1e3 * delay.mean_s);
    out += text;
  }
  std::snprintf(text, sizeof text,
                "%s places that took no part lie %.3g m apart in the median, as given %.3g m",
                delay.estimated ? ";" : ":", a.after.median_m, a.as_given.median_m);
  out += text;
  if (!a.method_reason.empty()) out += " (" + a.method_reason + ")";
  return out + ".";
}

std::string spoken_name(const Estimate& estimate) {
  std::string name = estimate.name;
  std::string unit = "_" + estimate.unit;
  std::replace(unit.begin(), unit.end(), '/', '_');
  if (name.size() > unit.size() && name.ends_with(unit)) name.resize(name.size() - unit.size());
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string to_its_sigma(double value, double sigma) {
  int decimals = 4;
  if (sigma > 0 && std::isfinite(sigma))
    decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 7);
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  // "-0.00" is a zero.
  const bool zero = std::string_view(text).find_first_of("123456789") == std::string_view::npos;
  return zero && text[0] == '-' ? text + 1 : text;
}

}  // namespace watersky
