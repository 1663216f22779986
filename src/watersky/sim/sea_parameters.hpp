// SPDX-License-Identifier: MIT
#pragma once
/// Seas made from a handful of numbers and a seed.
#include <string_view>
#include <vector>

#include "watersky/base/parameters.hpp"
#include "watersky/sim/sea.hpp"

namespace watersky::sim {

/// Floes have N(> d) ~ d^-floe_exponent within their range of sizes, d the diameter of the disc
/// of equal area; isolated objects likewise. No two pieces of ice touch.
/// With paper_patches it is the floor of the thesis's laboratory instead (laboratory.hpp), and only
/// sea_seed and paper_azimuth_deg count.
struct SeaParameters {
  int sea_seed = 1;
  bool paper_patches = false;
  double paper_azimuth_deg = 0.0;
  double extent_north_m = 420.0;
  double extent_east_m = 360.0;
  double concentration = 0.45;
  double floe_exponent = 1.8;
  double floe_min_m = 2.5;
  double floe_max_m = 70.0;
  double floe_gap_m = 0.5;
  int isolated_count = 60;
  double isolated_exponent = 0.8;
  double isolated_min_m = 1.0;
  double isolated_max_m = 15.0;
  double isolation_gap_m = 4.0;
  int lead_count = 1;
  double lead_width_m = 12.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(self.sea_seed,
          ParameterInfo{"sea_seed", "1", "another number is another sea", 0, 2147483647});
    visit(self.paper_patches,
          ParameterInfo{"paper_patches", "1",
                        "the eight paper patches of the thesis's laboratory, not ice"});
    visit(self.paper_azimuth_deg,
          ParameterInfo{"paper_azimuth_deg", "deg",
                        "direction of the laboratory's x axis, clockwise from north", -360, 360});
    visit(self.extent_north_m,
          ParameterInfo{"extent_north_m", "m", "size of the scene from south to north", 10, 20000});
    visit(self.extent_east_m,
          ParameterInfo{"extent_east_m", "m", "size of the scene from west to east", 10, 20000});
    visit(self.concentration,
          ParameterInfo{"concentration", "1",
                        "share of the scene that is ice; 0 leaves the isolated objects only", 0,
                        0.9});
    visit(self.floe_exponent,
          ParameterInfo{"floe_exponent", "1",
                        "floes larger than d are in number as d to minus this", 0.1, 5});
    visit(self.floe_min_m,
          ParameterInfo{"floe_min_m", "m", "smallest floe, diameter of the disc of equal area", 0.5,
                        10000});
    visit(self.floe_max_m, ParameterInfo{"floe_max_m", "m", "largest floe", 0.5, 10000});
    visit(self.floe_gap_m,
          ParameterInfo{"floe_gap_m", "m", "least open water between two floes", 0, 1000});
    visit(self.isolated_count,
          ParameterInfo{"isolated_count", "1",
                        "growlers and bergy bits with open water around them", 0, 100000});
    visit(self.isolated_exponent, ParameterInfo{"isolated_exponent", "1",
                                                "as floe_exponent, for isolated objects", 0.1, 5});
    visit(self.isolated_min_m,
          ParameterInfo{"isolated_min_m", "m", "smallest isolated object", 0.1, 1000});
    visit(self.isolated_max_m,
          ParameterInfo{"isolated_max_m", "m", "largest isolated object", 0.1, 1000});
    visit(self.isolation_gap_m,
          ParameterInfo{"isolation_gap_m", "m", "least open water around an isolated object", 0,
                        1000});
    visit(self.lead_count, ParameterInfo{"lead_count", "1", "cracks that cross the scene", 0, 100});
    visit(self.lead_width_m,
          ParameterInfo{"lead_width_m", "m", "width of a lead on average", 0.1, 1000});
  }
};

/// The sea of these parameters, at latitude 0, longitude 0. The same parameters give the same
/// sea. Usage for a parameter out of its range; OutOfRange when so much ice does not fit, with
/// the concentration that did.
[[nodiscard]] Result<Sea> make_sea(const SeaParameters& parameters);

/// `not_easy`: at least 30 % of the ice area in floes below 20 m, isolated objects scattered in it,
/// one lead; the sea of the acceptance figures, do not change it. `pack`: dense ice crossed by
/// leads. `marginal`: loose small floes. `bergs`: open water with growlers and bergy bits only.
/// NotFound, naming these, for another name.
[[nodiscard]] Result<SeaParameters> sea_preset(std::string_view name);
[[nodiscard]] std::vector<std::string_view> sea_preset_names();

}  // namespace watersky::sim
