// SPDX-License-Identifier: MIT
#include "watersky/align/detail/finding_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace watersky {

std::string_view name_of(MetadataFault fault) {
  switch (fault) {
    case MetadataFault::TurnedImages: return "turned_images";
    case MetadataFault::YawSign: return "yaw_sign";
    case MetadataFault::YawFromEast: return "yaw_from_east";
    case MetadataFault::YawOffset: return "yaw_offset";
    case MetadataFault::CameraTurned: return "camera_turned";
    case MetadataFault::RollSign: return "roll_sign";
    case MetadataFault::PitchSign: return "pitch_sign";
    case MetadataFault::RollAndPitchSign: return "roll_and_pitch_sign";
    case MetadataFault::AllSigns: return "all_signs";
    case MetadataFault::EastNorthUp: return "east_north_up";
    case MetadataFault::RollPitchSwapped: return "roll_pitch_swapped";
    case MetadataFault::HeightsInFeet: return "heights_in_feet";
    case MetadataFault::PositionsInFeet: return "positions_in_feet";
    case MetadataFault::HeightReference: return "height_reference";
    case MetadataFault::HeightScale: return "height_scale";
  }
  return "?";
}

namespace detail {

namespace {

template <class... Values>
std::string text(const char* format, Values... values) {
  char line[300];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

std::string metres(double m) {
  return m < 0.1 ? text("%.3f m", m) : m < 0.95 ? text("%.2f m", m) : text("%.1f m", m);
}

/// "A to C, F and H": frames that follow each other are one stretch.
std::string names_of(const Flight& flight, const std::vector<std::size_t>& frames) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t last = i;
    while (last + 1 < frames.size() && frames[last + 1] == frames[last] + 1) ++last;
    const std::string first_name = flight.frames[frames[i]].name;
    if (last == i) {
      parts.push_back(first_name);
    } else {
      parts.push_back(first_name + (last == i + 1 ? " and " : " to ") +
                      flight.frames[frames[last]].name);
    }
    i = last + 1;
  }
  std::string out;
  for (std::size_t i = 0; i < parts.size(); ++i) out += (i == 0 ? "" : ", ") + parts[i];
  return out;
}

std::string angle_text(Angle turn) { return text("%.0f°", turn.degrees()); }

struct Words {
  std::string claim;   ///< a clause
  std::string mended;  ///< "… and by 0.8 m <mended>"
  std::string done;
};

Words words_of(const Flight& flight, const MetadataFinding& finding) {
  switch (finding.fault) {
    case MetadataFault::TurnedImages: {
      const bool one = finding.frames.size() == 1;
      const char* by = finding.quarter_turns == 2   ? "half a turn"
                       : finding.quarter_turns == 1 ? "a quarter turn clockwise"
                                                    : "a quarter turn counter-clockwise";
      return {names_of(flight, finding.frames) + (one ? " is" : " are") + " stored turned by " +
                  by + " against " + (one ? "its" : "their") + " recorded heading",
              "turned", "turned back"};
    }
    case MetadataFault::YawSign:
      return {"the yaw angles have the wrong sign", "with yaw negated", "negated"};
    case MetadataFault::YawFromEast:
      return {"the yaw angles count counter-clockwise from east", "with yaw counted from north",
              "converted"};
    case MetadataFault::YawOffset:
      return {"all headings are off by " + angle_text(-finding.turn),
              "with " + angle_text(finding.turn) + " added to yaw", "added"};
    case MetadataFault::CameraTurned:
      return {"the camera, or every image, is turned by " + angle_text(finding.turn) +
                  " about the optical axis",
              "turned", "the mount is turned"};
    case MetadataFault::RollSign:
      return {"the roll angles have the wrong sign", "with roll negated", "negated"};
    case MetadataFault::PitchSign:
      return {"the pitch angles have the wrong sign", "with pitch negated", "negated"};
    case MetadataFault::RollAndPitchSign:
      return {"the roll and pitch angles have the wrong sign", "with both negated", "negated"};
    case MetadataFault::AllSigns:
      return {"the yaw, pitch and roll angles have the wrong sign", "with all negated", "negated"};
    case MetadataFault::EastNorthUp:
      return {"attitudes are written against east, north, up", "read so",
              "converted to north, east, down"};
    case MetadataFault::RollPitchSwapped:
      return {"roll and pitch stand in each other's place", "with both exchanged", "exchanged"};
    case MetadataFault::HeightsInFeet:
      return {std::string("heights are feet above ") +
                  (finding.height_zero == HeightZero::Sea     ? "the sea"
                   : finding.height_zero == HeightZero::Datum ? "the datum"
                                                              : "mean sea level") +
                  ", read as metres",
              "in metres", "converted"};
    case MetadataFault::PositionsInFeet:
      return {"north and east are feet, read as metres", "in metres", "converted"};
    case MetadataFault::HeightReference:
      return {text("heights above the geoid and above the ellipsoid, %.1f m apart here, are mixed "
                   "up, the poses' or the sea's",
                   std::abs(finding.height_shift_m)),
              text("with %.1f m added to the poses' heights", finding.height_shift_m), "added"};
    case MetadataFault::HeightScale:
      return {"the height above what is seen, or the focal length, is off",
              "with the height scaled", ""};
  }
  return {};
}

}  // namespace

std::string sentence_of(const Flight& flight, const MetadataFinding& finding,
                        const Alternatives& alternatives) {
  const Words words = words_of(flight, finding);
  std::string out = finding.certain ? words.claim : "it is suspected that " + words.claim;
  for (const MetadataFinding& other : alternatives.same_poses)
    out += ", or " + words_of(flight, other).claim + " (which here comes to the same)";
  for (const MetadataFinding& other : alternatives.other_poses)
    out += ", or that " + words_of(flight, other).claim;
  out += ": overlapping frames disagree by " + metres(finding.before_m) + " as recorded and by " +
         metres(finding.after_m) + " " + words.mended +
         text(" (median of %zu pairs)", finding.pairs);
  return out + "; " + (finding.certain ? words.done : "left as recorded");
}

std::string height_evidence(double recorded_m, double shown_m, double sigma_m) {
  return text(
      "; the pictures' scale against the way flown puts the camera %.1f ± %.1f m above the "
      "sea, the metadata %.1f m",
      shown_m, sigma_m, recorded_m);
}

std::string unchecked_text(std::size_t registered, std::size_t tried, const std::string& reason) {
  return text(
             "the metadata could not be checked against the pictures: %zu of %zu pairs of frames "
             "could be registered",
             registered, tried) +
         (reason.empty() ? "" : " (commonest reason: " + reason + ")");
}

std::string too_few_frames_text(std::size_t posed, const std::vector<LeftOut>& left_out) {
  std::string out = "the metadata could not be checked against the pictures: ";
  out += posed == 1 ? "only one frame has a pose" : "no frame has a pose";
  if (!left_out.empty()) out += " (" + left_out.front().file + ": " + left_out.front().reason + ")";
  return out;
}

std::string summary_of(const MetadataCheck& check) {
  const std::string of_pairs = text("%zu pairs of overlapping frames (%zu of %zu frames)",
                                    check.pairs_registered, check.frames, check.frames_total);
  if (check.findings.empty())
    return (check.contradiction
                ? "the pictures contradict the metadata, and no fault that is known explains it: "
                : "the metadata agree with the pictures: ") +
           of_pairs + " disagree by " + metres(check.disagreement_m) +
           text(" (median; %.1f %% of a footprint's side)", 100.0 * check.disagreement_share);
  const auto certain =
      static_cast<std::size_t>(std::count_if(check.findings.begin(), check.findings.end(),
                                             [](const MetadataFinding& f) { return f.certain; }));
  return "the pictures contradict the metadata: " +
         text("%zu %s certain, %zu suspected; ", certain, certain == 1 ? "fault" : "faults",
              check.findings.size() - certain) +
         of_pairs + " disagree by " + metres(check.disagreement_m) + " as recorded and by " +
         metres(check.mended_disagreement_m) + " with what is certain mended (median)" +
         (check.contradiction ? "; something else is wrong" : "");
}

}  // namespace detail

}  // namespace watersky
