// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "watersky/geo/rotation.hpp"
#include "watersky/products/alignment_report.hpp"
#include "watersky/products/detail/versions.hpp"

namespace watersky {

namespace {

using nlohmann::json;

constexpr double kDegree = 180 / std::numbers::pi;

/// JSON has no NaN; an unknown sigma is 0 in our structs.
json number(double value) { return std::isfinite(value) ? json(value) : json(); }
json sigma(double value) { return value > 0 && std::isfinite(value) ? json(value) : json(); }

/// Seconds as in the flight's own files: to the microsecond, of any epoch.
json time(Time t) { return to_seconds(t); }

json ties(const TieStatistics& s) {
  if (s.ties == 0) return {{"ties", 0}, {"median_m", {}}, {"p90_m", {}}, {"median_px", {}}};
  return {{"ties", s.ties},
          {"median_m", number(s.median_m)},
          {"p90_m", number(s.p90_m)},
          {"median_px", number(s.median_px)}};
}

json mount_json(const Mount& mount) {
  const YawPitchRoll a =
      yaw_pitch_roll(mount.rotation * forward_right_down_from_camera().conjugate());
  return {{"roll_deg", a.roll.degrees()},
          {"pitch_deg", a.pitch.degrees()},
          {"yaw_deg", a.yaw.degrees()},
          {"x_m", mount.lever_arm_m.x()},
          {"y_m", mount.lever_arm_m.y()},
          {"z_m", mount.lever_arm_m.z()},
          {"sigma_deg", sigma(kDegree * mount.sigma_rad)},
          {"assumed", mount.assumed}};
}

json pose_sigma(const PoseSigma& s) {
  const Eigen::Vector3d &p = s.position_north_east_down_m, &a = s.roll_pitch_yaw_rad;
  return {{"north_m", sigma(p.x())},
          {"east_m", sigma(p.y())},
          {"down_m", sigma(p.z())},
          {"roll_deg", sigma(kDegree * a.x())},
          {"pitch_deg", sigma(kDegree * a.y())},
          {"yaw_deg", sigma(kDegree * a.z())}};
}

json anchors_json(const Alignment& a) {
  json list = json::array();
  const auto vector = [](const Eigen::Vector2d& v) {
    return json{{"north_m", v.x()}, {"east_m", v.y()}};
  };
  for (const AnchorOutcome& o : a.anchors)
    list.push_back({{"name", o.name},
                    {"sightings", o.sightings},
                    {"used", o.used},
                    {"as_given", o.used > 0 ? vector(o.as_given_m) : json()},
                    {"after", o.used > 0 ? vector(o.after_m) : json()},
                    {"as_given_rms_m", o.used > 0 ? json(o.as_given_rms_m) : json()},
                    {"after_rms_m", o.used > 0 ? json(o.after_rms_m) : json()},
                    {"left_out", o.left_out.empty() ? json() : json(o.left_out)}});
  return list;
}

json ranges_json(const RangeOutcome& r) {
  if (r.ranges == 0) return nullptr;
  return {{"ranges", r.ranges},
          {"used", r.used},
          {"height_as_given_m", r.used > 0 ? json(r.as_given_m) : json()},
          {"height_after_m", r.used > 0 ? json(r.after_m) : json()}};
}

json left_out_json(const AlignmentRun& run, const std::vector<LeftOut>& not_written) {
  json list = json::array();
  for (const auto* some : {&run.corrected.left_out, &not_written})
    for (const LeftOut& l : *some) list.push_back({{"file", l.file}, {"reason", l.reason}});
  return list;
}

json frames_json(const AlignmentRun& run) {
  const auto corrections = pose_corrections(run);
  json list = json::array();
  std::size_t next = 0;
  for (std::size_t k = 0; k < run.alignment.frames.size(); ++k) {
    const AlignedFrame& f = run.alignment.frames[k];
    const ImageFrame& frame = run.given.frames[f.index];
    json object{{"file", frame.name},
                {"captured_s", time(f.captured)},
                {"received_s", frame.received_at ? time(*frame.received_at) : json()},
                {"delay_s", frame.captured_at || frame.own_pose ? json() : json(f.delay_s)},
                {"ties", f.ties},
                {"sigma", f.pose.sigma ? pose_sigma(*f.pose.sigma) : json()},
                {"correction", nullptr}};
    if (next < corrections.size() && corrections[next].frame == k) {
      const Eigen::Vector3d& p = corrections[next].position_m;
      const Eigen::Vector3d t = kDegree * corrections[next].turn_rad;
      object["correction"] = {{"north_m", p.x()},        {"east_m", p.y()},
                              {"down_m", p.z()},         {"about_north_deg", t.x()},
                              {"about_east_deg", t.y()}, {"about_down_deg", t.z()}};
      ++next;
    }
    list.push_back(std::move(object));
  }
  return list;
}

}  // namespace

json alignment_summary_json(const AlignmentRun& run) {
  const Alignment& a = run.alignment;
  const DelayFigures delay = delay_figures(a);
  json estimates = json::array();
  for (const Estimate& e : a.estimates)
    estimates.push_back({{"name", e.name},
                         {"unit", e.unit},
                         {"given", number(e.given)},
                         {"value", number(e.value)},
                         {"sigma", sigma(e.sigma)},
                         {"sigma_before", sigma(e.sigma_before)},
                         {"observed", e.observed}});
  const Eigen::Matrix2d& shared = a.shared_covariance_m2;
  json out{
      {"method", name_of(a.method)},
      {"reason", a.method_reason.empty() ? json() : json(a.method_reason)},
      {"delay",
       {{"estimated", delay.estimated},
        {"given_s", run.given.delay_s ? json(*run.given.delay_s) : json()},
        {"mean_s", delay.estimated ? json(delay.mean_s) : json()},
        {"sigma_s", sigma(delay.sigma_s)},
        {"least_s", delay.estimated ? json(delay.least_s) : json()},
        {"most_s", delay.estimated ? json(delay.most_s) : json()}}},
      {"estimates", std::move(estimates)},
      {"mount", {{"given", mount_json(run.given.mount)}, {"found", mount_json(a.mount)}}},
      {"focal_scale", number(a.focal_scale)},
      {"disagreement",
       {{"as_given", ties(a.as_given)},
        {"constant_delay", ties(a.constant_delay)},
        {"after", ties(a.after)}}},
      {"pixel_sigma_px", sigma(a.pixel_sigma)},
      {"navigation_sigma", pose_sigma(a.navigation_sigma)},
      {"shared_offset_covariance_m2", nullptr},
      {"anchors", anchors_json(a)},
      {"range_finder", ranges_json(a.ranges)},
      {"keyframes", a.keyframes},
      {"sightings", a.sightings},
      {"revisits", a.revisits},
      {"timings_s", {{"wall", run.wall_s}, {"tracking", a.tracking_s}, {"solving", a.solving_s}}}};
  if (shared.trace() > 0)
    out["shared_offset_covariance_m2"] = {{shared(0, 0), shared(0, 1)},
                                          {shared(1, 0), shared(1, 1)}};
  return out;
}

json alignment_json(const AlignmentRun& run, const std::vector<LeftOut>& not_written) {
  const detail::Versions versions = detail::versions();
  json out = alignment_summary_json(run);
  json parameters = json::object();
  AlignParameters::describe(run.parameters, [&](const auto& value, const ParameterInfo& info) {
    parameters[std::string(info.name)] = {
        {"value", value}, {"unit", info.unit}, {"help", info.help}};
  });
  json course = json::array();
  for (const DelaySample& s : run.alignment.delay)
    course.push_back(
        {{"received_s", time(s.received)}, {"delay_s", s.delay_s}, {"sigma_s", sigma(s.sigma_s)}});
  out["watersky"] = versions.watersky;
  out["versions"] = {{"watersky", versions.watersky}, {"opencv", versions.opencv}};
  out["flight"] = run.given.name;
  out["made_at"] =
      to_iso8601(std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now()));
  out["times_are_utc"] = run.given.times_are_utc;
  out["delay"]["course"] = std::move(course);
  const json left_out = left_out_json(run, not_written);
  out["frames"] = {{"total", run.given.frames.size() + run.given.left_out.size()},
                   {"used", run.corrected.frames.size() - not_written.size()},
                   {"left_out", left_out}};
  out["per_frame"] = frames_json(run);
  out["notes"] = run.corrected.notes;
  out["parameters"] = std::move(parameters);
  out["threads"] = run.threads;
  return out;
}

}  // namespace watersky
