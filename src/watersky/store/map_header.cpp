// SPDX-License-Identifier: MIT
#include "watersky/store/map_header.hpp"

#include <algorithm>
#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/string_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace watersky {

namespace {

using nlohmann::json;

json time_json(const std::optional<Time>& time) {
  return time ? json(time->time_since_epoch().count()) : json();
}

/// Reads fields and remembers the first that is wrong.
class Fields {
 public:
  Fields(const json& object, std::string where) : object_(object), where_(std::move(where)) {}

  void number(const char* name, double& into, double least, double most) {
    const json& value = field(name);
    // NaN is no JSON, but a number may be too large for a double.
    if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most))
      return wrong(name, "a number in its range");
    into = value.get<double>();
  }
  void text(const char* name, std::string& into) {
    const json& value = field(name);
    if (!value.is_string()) return wrong(name, "a text");
    into = value.get<std::string>();
  }
  void flag(const char* name, bool& into) {
    const json& value = field(name);
    if (!value.is_boolean()) return wrong(name, "true or false");
    into = value.get<bool>();
  }
  void time(const char* name, std::optional<Time>& into) {
    const json& value = field(name);
    if (value.is_null()) return;
    if (!value.is_number_integer()) return wrong(name, "nanoseconds as a whole number, or null");
    into = Time(Duration(value.get<std::int64_t>()));
  }
  void equals(const char* name, int expected) {
    const json& value = field(name);
    if (!value.is_number_integer() || value.get<std::int64_t>() != expected)
      wrong(name, std::to_string(expected));
  }
  [[nodiscard]] const json& field(const char* name) const {
    static const json none;
    const auto found = object_.is_object() ? object_.find(name) : object_.end();
    return found == object_.end() ? none : *found;
  }
  void wrong(const char* name, const std::string& expected) {
    if (status_.ok())
      status_ = Error{ErrorCode::InvalidInput, "header: " + where_ + name + " must be " + expected};
  }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  const json& object_;
  std::string where_;
  Status status_;
};

constexpr double kFarthest_m = 1e9;
constexpr double kAlignedWithin = 1e-6;  // of a cell

}  // namespace

std::string new_source_id() {
  thread_local boost::uuids::random_generator generate;
  return to_string(generate());
}

std::string source_id_from(std::string_view text) {
  // Drawn once, so that nobody else's names meet ours.
  static const boost::uuids::uuid kOurs =
      boost::uuids::string_generator()("6f1c1f0e-8a52-4b0e-9d0b-6c1c3f4a7b21");
  return to_string(boost::uuids::name_generator_sha1(kOurs)(text.data(), text.size()));
}

std::optional<std::size_t> MapHeader::find_source(std::string_view id) const {
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i].id == id) return i;
  return std::nullopt;
}

std::string describe_grid(const MapHeader& header) {
  char cell[32];
  std::snprintf(cell, sizeof cell, "%g", header.cell_m);
  return header.projection + ", cells of " + cell + " m";
}

Result<TileIndex> tiles_between(const MapHeader& from, const MapHeader& to) {
  // Versions of PROJ write one projection in different words, hence the name.
  const bool same = from.wkt == to.wkt || from.projection == to.projection;
  if (!same || from.cell_m != to.cell_m)
    return Error{ErrorCode::InvalidInput,
                 "the maps do not share a grid (" + describe_grid(from) + " and " +
                     describe_grid(to) +
                     "); map one of the flights anew with --projection and --cell-m of the other"};
  if (from.prior != to.prior) {
    char text[64];
    std::snprintf(text, sizeof text, "%g and %g", from.prior, to.prior);
    return Error{ErrorCode::InvalidInput, std::string("the maps assume different priors (") + text +
                                              "); map one of the flights anew with --prior of the "
                                              "other"};
  }
  const double tile_m = kTileCells * to.cell_m;
  const double columns = (from.anchor_easting_m - to.anchor_easting_m) / tile_m;
  const double rows = (to.anchor_northing_m - from.anchor_northing_m) / tile_m;
  const auto off = [](double x) { return std::abs(x - std::round(x)) * kTileCells; };
  if (off(columns) > kAlignedWithin || off(rows) > kAlignedWithin ||
      std::max(std::abs(columns), std::abs(rows)) > 1e7) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "the maps' tiles do not meet: their anchors are %.6f east, %.6f south tiles apart, "
        "which must be whole numbers",
        columns, rows);
    return Error{ErrorCode::InvalidInput,
                 std::string(text) + "; map one of the flights anew with this watersky"};
  }
  return TileIndex{static_cast<int>(std::lround(columns)), static_cast<int>(std::lround(rows))};
}

std::string header_json(const MapHeader& header) {
  json sources = json::array();
  for (const MapSource& s : header.sources)
    sources.push_back({{"id", s.id},
                       {"name", s.name},
                       {"first_ns", time_json(s.first)},
                       {"last_ns", time_json(s.last)},
                       {"times_are_utc", s.times_are_utc}});
  json object = {{"what", "log-odds of sea ice in cells, relative to the prior's"},
                 {"projection", {{"name", header.projection}, {"wkt", header.wkt}}},
                 {"anchor_easting_m", header.anchor_easting_m},
                 {"anchor_northing_m", header.anchor_northing_m},
                 {"cell_m", header.cell_m},
                 {"tile_cells", kTileCells},
                 {"block_cells", MapTile::kBlockCells},
                 {"evidence_units", kEvidenceUnits},
                 {"prior", header.prior},
                 {"max_probability", header.max_probability},
                 {"sources", sources}};
  if (header.half_life_s > 0) object["half_life_s"] = header.half_life_s;
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

Result<MapHeader> parse_header(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) return Error{ErrorCode::InvalidInput, "header: is not a JSON object"};
  MapHeader header;
  Fields fields(object, "");
  fields.equals("tile_cells", kTileCells);
  fields.equals("block_cells", MapTile::kBlockCells);
  fields.equals("evidence_units", kEvidenceUnits);
  fields.number("anchor_easting_m", header.anchor_easting_m, -kFarthest_m, kFarthest_m);
  fields.number("anchor_northing_m", header.anchor_northing_m, -kFarthest_m, kFarthest_m);
  fields.number("cell_m", header.cell_m, 0.001, 1000.0);
  fields.number("prior", header.prior, 0.001, 0.999);
  fields.number("max_probability", header.max_probability, 0.5, 1.0);
  // Not in the first maps, whose cells did not forget.
  if (object.contains("half_life_s")) fields.number("half_life_s", header.half_life_s, 0.0, 1e9);
  WATERSKY_CHECK(fields.status());
  Fields projection(fields.field("projection"), "projection.");
  projection.text("name", header.projection);
  projection.text("wkt", header.wkt);
  WATERSKY_CHECK(projection.status());
  const json& sources = fields.field("sources");
  constexpr std::size_t kMostSources = 4096;
  if (!sources.is_array() || sources.size() > kMostSources)
    return Error{ErrorCode::InvalidInput, "header: sources must be a list"};
  for (const json& source : sources) {
    MapSource s;
    Fields of(source, "sources.");
    of.text("id", s.id);
    of.text("name", s.name);
    of.time("first_ns", s.first);
    of.time("last_ns", s.last);
    of.flag("times_are_utc", s.times_are_utc);
    WATERSKY_CHECK(of.status());
    if (s.id.empty() || header.find_source(s.id))
      return Error{ErrorCode::InvalidInput, "header: sources.id must be there, each once"};
    header.sources.push_back(std::move(s));
  }
  return header;
}

}  // namespace watersky
