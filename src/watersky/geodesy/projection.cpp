// SPDX-License-Identifier: MIT
#include "watersky/geodesy/projection.hpp"

#include <proj.h>

#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <mutex>
#include <string_view>

namespace watersky {

namespace {

struct ContextDeleter {
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};
struct PjDeleter {
  void operator()(PJ* p) const { proj_destroy(p); }
};
using ContextPtr = std::unique_ptr<PJ_CONTEXT, ContextDeleter>;
using PjPtr = std::unique_ptr<PJ, PjDeleter>;

/// A context that keeps PROJ's complaints off standard error.
ContextPtr quiet_context() {
  ContextPtr context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  return context;
}

/// A coordinate system as a message can hold it: one line, and not the whole of a WKT.
std::string quoted(const std::string& crs) {
  std::string text = crs.size() <= 60 ? crs : crs.substr(0, 57) + "...";
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return "\"" + text + "\"";
}

/// Why a projected system cannot carry a map; empty when it can.
std::string fault_of_axes(PJ_CONTEXT* context, const PJ* crs) {
  const PjPtr axes(proj_crs_get_coordinate_system(context, crs));
  for (int axis = 0; axis < 2; ++axis) {
    const char* direction = nullptr;
    double to_metre = 0;
    if (!axes ||
        !proj_cs_get_axis_info(context, axes.get(), axis, nullptr, nullptr, &direction, &to_metre,
                               nullptr, nullptr, nullptr) ||
        to_metre != 1.0)
      return "is not in metres";
    if (direction && std::string_view(direction) == "west") return "has an axis that points west";
  }
  return {};
}

}  // namespace

Angle ProjectedPlace::convergence() const {
  // Moving along true north moves the grid by column 0; grid north is (0, 1).
  const Eigen::Vector2d north = grid_from_north_east.col(0);
  return Angle::radians(-std::atan2(north.x(), north.y()));
}

double ProjectedPlace::scale() const { return grid_from_north_east.col(0).norm(); }

struct Projection::Impl {
  ContextPtr context = quiet_context();
  PjPtr transform;  // longitude, latitude in degrees → easting, northing in metres
  std::string name;
  std::string wkt;
  mutable std::mutex mutex;
};

Result<Projection> Projection::from_text(const std::string& crs) {
  auto impl = std::make_shared<Impl>();
  PJ_CONTEXT* context = impl->context.get();
  const auto bad = [&](const std::string& why) {
    return Error{ErrorCode::InvalidInput, "projection " + quoted(crs) + " " + why +
                                              "; give one in metres, such as EPSG:32633"};
  };
  // A PROJ string is a coordinate system only when it says so.
  const bool bare =
      crs.find("+proj=") != std::string::npos && crs.find("+type=crs") == std::string::npos;
  const PjPtr target(proj_create(context, (bare ? crs + " +type=crs" : crs).c_str()));
  if (!target || !proj_is_crs(target.get())) return bad("is not known to PROJ");
  if (proj_get_type(target.get()) != PJ_TYPE_PROJECTED_CRS) return bad("is not a map projection");
  if (const std::string fault = fault_of_axes(context, target.get()); !fault.empty())
    return bad(fault);

  const PjPtr pair(proj_create_crs_to_crs(context, "EPSG:4326", crs.c_str(), nullptr));
  if (!pair) return bad("cannot be reached from WGS-84");
  impl->transform.reset(proj_normalize_for_visualization(context, pair.get()));
  if (!impl->transform) return bad("cannot be reached from WGS-84");
  impl->name = crs;
  const char* wkt = proj_as_wkt(context, target.get(), PJ_WKT2_2019, nullptr);
  impl->wkt = wkt ? wkt : crs;
  return Projection(std::move(impl));
}

Result<Projection> Projection::for_place(const Geodetic& place) {
  const double lat_deg = place.latitude.degrees(), lon_deg = place.longitude.degrees();
  if (!(std::abs(lat_deg) <= 90.0) || !std::isfinite(lon_deg))
    return Error{ErrorCode::InvalidInput, "no projection for a position that is not on the Earth"};
  if (lat_deg >= 84.0) return from_text("EPSG:3413");
  if (lat_deg < -80.0) return from_text("EPSG:3031");
  const int zone =
      GeographicLib::UTMUPS::StandardZone(lat_deg, lon_deg, GeographicLib::UTMUPS::UTM);
  return from_text("EPSG:" + std::to_string((lat_deg >= 0 ? 32600 : 32700) + zone));
}

const std::string& Projection::name() const { return impl_->name; }
const std::string& Projection::wkt() const { return impl_->wkt; }

Result<Eigen::Vector2d> Projection::forward(Angle latitude, Angle longitude) const {
  const std::lock_guard lock(impl_->mutex);
  const PJ_COORD out = proj_trans(impl_->transform.get(), PJ_FWD,
                                  proj_coord(longitude.degrees(), latitude.degrees(), 0, 0));
  if (!std::isfinite(out.xy.x) || !std::isfinite(out.xy.y))
    return Error{ErrorCode::OutOfRange, "position " + std::to_string(latitude.degrees()) + ", " +
                                            std::to_string(longitude.degrees()) + " is outside " +
                                            quoted(name())};
  return Eigen::Vector2d(out.xy.x, out.xy.y);
}

Result<Geodetic> Projection::inverse(const Eigen::Vector2d& en) const {
  const std::lock_guard lock(impl_->mutex);
  const PJ_COORD out = proj_trans(impl_->transform.get(), PJ_INV, proj_coord(en.x(), en.y(), 0, 0));
  if (!std::isfinite(out.lp.lam) || !std::isfinite(out.lp.phi))
    return Error{ErrorCode::OutOfRange, "grid position is outside " + quoted(name())};
  return Geodetic{Angle::degrees(out.xy.y), Angle::degrees(out.xy.x), 0.0};
}

Result<ProjectedPlace> Projection::at(const Geodetic& place) const {
  ProjectedPlace result;
  WATERSKY_TRY(result.easting_northing_m, forward(place.latitude, place.longitude));
  // Central differences over ±10 m: truncation 1e-11, rounding 1e-10, both far below what a
  // footprint can show.
  constexpr double kStep_m = 10.0;
  const Rigid3<Ecef, Sea> ecef_from_here = ecef_from_sea(place);
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Vector2d end[2];
    for (int side = 0; side < 2; ++side) {
      Point<Sea> p;
      p.v[axis] = side == 0 ? -kStep_m : kStep_m;
      const Geodetic g = geodetic_from(ecef_from_here * p);
      WATERSKY_TRY(end[side], forward(g.latitude, g.longitude));
    }
    // A map of the world is cut somewhere, mostly along the antimeridian. Where the cut runs
    // between here and there, only the near side tells; no useful grid stretches a thousandfold.
    double span_m = 0;
    for (Eigen::Vector2d& e : end) {
      const bool across_the_cut = (e - result.easting_northing_m).norm() > 1000 * kStep_m;
      if (across_the_cut) e = result.easting_northing_m;
      span_m += across_the_cut ? 0 : kStep_m;
    }
    if (span_m == 0)
      return Error{ErrorCode::OutOfRange, quoted(name()) + " is torn apart at this place"};
    result.grid_from_north_east.col(axis) = (end[1] - end[0]) / span_m;
  }
  return result;
}

Result<double> egm96_above_ellipsoid_m(Angle latitude, Angle longitude) {
  struct Grid {
    ContextPtr context = quiet_context();
    PjPtr shift{proj_create(context.get(), "+proj=vgridshift +grids=egm96_15.gtx +multiplier=1")};
    std::mutex mutex;
  };
  static Grid grid;
  const std::lock_guard lock(grid.mutex);
  if (!grid.shift)
    return Error{ErrorCode::NotFound,
                 "the EGM96 geoid (egm96_15.gtx) is not installed; install the package "
                 "proj-data, or give the sea level above the ellipsoid"};
  const PJ_COORD out = proj_trans(grid.shift.get(), PJ_FWD,
                                  proj_coord(longitude.radians(), latitude.radians(), 0, 0));
  if (!std::isfinite(out.xyz.z))
    return Error{ErrorCode::OutOfRange, "no EGM96 height at this position"};
  return out.xyz.z;
}

}  // namespace watersky
