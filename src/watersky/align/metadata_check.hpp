// SPDX-License-Identifier: MIT
#pragma once
/// Does a flight's metadata say what its pictures say? Frames that overlap show the same places of
/// the sea; poses that put such a place here by one frame and there by another contradict the
/// pictures. Whichever of the faults below makes them agree is what is wrong.
///
///   WATERSKY_TRY(const MetadataCheck check, check_metadata(flight));
///   if (!check.checked) …                      // check.summary says why
///   for (const MetadataFinding& f : check.findings) …  // f.sentence, f.certain
///   WATERSKY_TRY(const Flight better, mended(std::move(flight), check.findings));
///
/// What a flight may have besides faults is let vary while two sets of poses are compared: a
/// constant delay, a mount off by some degrees, a height off by a tenth. What remains is the
/// *disagreement*: how far apart the poses put one place, in metres on the sea, for a pair of
/// frames the root mean square over its tie points.
///
/// What pictures cannot show is not found: a fault of all positions and heights by one factor
/// (every picture fits then), yaw signs where all headings are north or south, signs of roll and
/// pitch where the aircraft never rolls or pitches.
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "watersky/align/frame_pairs.hpp"
#include "watersky/base/angle.hpp"
#include "watersky/base/parameters.hpp"
#include "watersky/base/progress.hpp"
#include "watersky/flight/flight.hpp"

namespace watersky {

enum class MetadataFault {
  TurnedImages,      ///< some images are stored turned by quarter turns
  YawSign,           ///< yaw counts the other way round
  YawFromEast,       ///< yaw counts from east, and the other way round
  YawOffset,         ///< all headings are off by one angle
  CameraTurned,      ///< the camera, or every image, is turned about the optical axis
  RollSign,          ///< roll has the other sign
  PitchSign,         ///< pitch has
  RollAndPitchSign,  ///< both have
  AllSigns,          ///< of yaw, pitch and roll
  EastNorthUp,       ///< yaw counts from east, the other way round, and pitch has the other sign
  RollPitchSwapped,  ///< each stands where the other should
  HeightsInFeet,     ///< heights are feet, read as metres
  PositionsInFeet,   ///< north and east are feet, read as metres
  HeightReference,   ///< heights above the geoid taken as above the ellipsoid, or the reverse
  HeightScale,       ///< the height above the sea, or the focal length, is off by a factor
};

/// "turned_images", "yaw_sign", …
[[nodiscard]] std::string_view name_of(MetadataFault fault);

/// What heights in feet count from.
enum class HeightZero { Sea, Datum, Geoid };

struct MetadataFinding {
  MetadataFault fault = MetadataFault::TurnedImages;
  std::vector<std::size_t> frames;  ///< indices into Flight::frames; empty: the whole flight
  bool certain = false;             ///< else only suspected, and not mended
  std::string sentence;             ///< for the report, with the figures

  /// The disagreement with and without the fault, median over the pairs that it concerns.
  double before_m = 0.0, after_m = 0.0;
  /// The same, over the side of a footprint (the root of its area).
  double before_share = 0.0, after_share = 0.0;
  std::size_t pairs = 0;

  /// What mends it, where it applies: stored images are turned clockwise by so many quarters;
  /// the angle to add to the recorded headings, or of the camera about its optical axis
  /// (clockwise seen from behind it); what to add to heights; what heights in feet count from.
  int quarter_turns = 0;
  Angle turn;
  double height_shift_m = 0.0;
  HeightZero height_zero = HeightZero::Sea;
};

struct MetadataCheckParameters {
  FramePairParameters pairs;
  int most_pairs = 60;
  int most_pairs_if_suspicious = 1500;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    FramePairParameters::describe(self.pairs, visit);
    visit(self.most_pairs,
          ParameterInfo{"most_pairs", "1",
                        "pairs of frames that are registered to check the metadata", 3, 100000});
    visit(
        self.most_pairs_if_suspicious,
        ParameterInfo{"most_pairs_if_suspicious", "1",
                      "the same, where some images seem turned and it is asked which", 3, 100000});
  }
};

struct MetadataCheck {
  bool checked = false;  ///< false: not enough pairs could be registered, see summary
  /// In the order in which mended() must apply them.
  std::vector<MetadataFinding> findings;
  std::size_t frames_total = 0;
  std::size_t frames = 0;  ///< in registered pairs: of others nothing is said
  std::size_t pairs_tried = 0, pairs_registered = 0;
  double disagreement_m = 0.0;         ///< median over pairs, of the flight as it was recorded
  double disagreement_share = 0.0;     ///< the same over the side of a footprint
  double mended_disagreement_m = 0.0;  ///< of the flight with what is certain mended
  /// What then still disagrees is more than noise explains: something else is wrong.
  bool contradiction = false;
  std::string summary;  ///< one sentence
};

/// Checks a sample of a flight's pairs that covers its time and its headings. Usage for a
/// parameter at fault; a flight that cannot be checked is a MetadataCheck that says why.
[[nodiscard]] Result<MetadataCheck> check_metadata(const Flight& flight,
                                                   const MetadataCheckParameters& parameters = {},
                                                   const Progress& progress = {});

/// The flight without the faults that are certain, and a note of each. Turned images are turned
/// back as they are loaded, so that the principal point, the distortion, masks and the sensor's
/// pattern are where the camera has them.
[[nodiscard]] Result<Flight> mended(Flight flight, std::span<const MetadataFinding> findings);

/// Loads what `load` loads, turned back by `quarter_turns` counter-clockwise. `width_px` and
/// `height_px` are those of the camera, that is of the result; a reduced image is reduced by
/// whole blocks from the top left of the result, as CameraModel::reduced_by() expects.
[[nodiscard]] ImageLoader turned_back(ImageLoader load, int quarter_turns, int width_px,
                                      int height_px);

}  // namespace watersky
