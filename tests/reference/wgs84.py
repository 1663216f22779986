#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the reference tables wgs84_ecef.csv and wgs84_world.csv beside this script.

Independent of the library: closed formulas of WGS-84 in 60-digit decimal arithmetic, with sine
and cosine by their Taylor series; rounded to 1 nm only when printed. Angles are decimal degrees,
taken exactly as printed. Run it without arguments; it must leave the tables unchanged.
"""
import itertools
import pathlib
import random
from decimal import Decimal as D, getcontext

getcontext().prec = 60

A = D("6378137")
F = 1 / D("298.257223563")
E2 = F * (2 - F)


def arctan_inverse(n):
    """arctan(1/n) for a whole number n."""
    total, term, k = D(0), 1 / D(n), 1
    while abs(term) > D(10) ** -62:
        total += term / k if k % 4 == 1 else -term / k
        term /= n * n
        k += 2
    return total


PI = 4 * (4 * arctan_inverse(5) - arctan_inverse(239))  # Machin


def sin_cos(degrees):
    """Exact at multiples of 90 degrees, as the poles and the antimeridian need."""
    quarter, rest = divmod(D(degrees), 90)
    x = rest * PI / 180
    s = c = D(0)
    term, k = D(1), 0
    while abs(term) > D(10) ** -62 or k < 4:
        if k % 2 == 0:
            c += term if k % 4 == 0 else -term
        else:
            s += term if k % 4 == 1 else -term
        k += 1
        term = term * x / k
    return [(s, c), (c, -s), (-s, -c), (-c, s)][int(quarter) % 4]


def ecef(lat, lon, height):
    (sin_lat, cos_lat), (sin_lon, cos_lon) = sin_cos(lat), sin_cos(lon)
    n = A / (1 - E2 * sin_lat * sin_lat).sqrt()
    h = D(height)
    return ((n + h) * cos_lat * cos_lon, (n + h) * cos_lat * sin_lon,
            (n * (1 - E2) + h) * sin_lat)


def world(datum, azimuth, place):
    """North, east, down at the datum, turned so that the first axis points along the azimuth."""
    d = [p - o for p, o in zip(ecef(*place), ecef(*datum))]
    (sin_lat, cos_lat), (sin_lon, cos_lon) = sin_cos(datum[0]), sin_cos(datum[1])
    north = -sin_lat * cos_lon * d[0] - sin_lat * sin_lon * d[1] + cos_lat * d[2]
    east = -sin_lon * d[0] + cos_lon * d[1]
    down = -(cos_lat * cos_lon * d[0] + cos_lat * sin_lon * d[1] + sin_lat * d[2])
    s, c = sin_cos(azimuth)
    return (c * north + s * east, -s * north + c * east, down)


def write(name, header, rows):
    path = pathlib.Path(__file__).with_name(name)
    path.write_text(header + "\n" + "".join(",".join(row) + "\n" for row in rows))


def nanometres(values):
    return [f"{v:.9f}" for v in values]


def main():
    places = list(itertools.product(
        ["-90", "-77.85", "-33.9", "0", "0.0000001", "45", "78.2", "78.9", "80.8", "89.9999", "90"],
        ["-180", "-179.9999999", "-45.25", "0", "11.9", "90", "179.9999999", "180"],
        ["-100", "0", "20000"]))
    write("wgs84_ecef.csv", "lat_deg,lon_deg,height_ellipsoid_m,x_m,y_m,z_m",
          [list(p) + nanometres(ecef(*p)) for p in places])

    rng = random.Random(1)
    rows = []
    for datum in [("78.9", "11.9", "30"), ("78.2", "15.6", "0"), ("0", "0", "0"),
                  ("-54.8", "-68.3", "17.5"), ("71.3", "179.95", "5"), ("-77.85", "-179.99", "20"),
                  ("89.999", "-30", "0"), ("90", "0", "0"), ("-90", "25", "2835")]:
        for azimuth in ["0", "-37.5", "90", "211.25"]:
            # Up to about 200 km in latitude, and as far in longitude as the place allows.
            spread = [D("0.0005"), D("0.01"), D("0.36"), D("1.8")][rng.randrange(4)]
            lat = min(max(D(datum[0]) + spread * D(str(round(rng.uniform(-1, 1), 6))), D(-90)), D(90))
            lon = D(datum[1]) + 4 * spread * D(str(round(rng.uniform(-1, 1), 6)))
            lon = lon - 360 if lon > 180 else lon + 360 if lon < -180 else lon
            height = D(str(round(rng.uniform(-100, 20000), 3)))
            place = (f"{lat:f}", f"{lon:f}", f"{height:f}")
            rows.append(list(datum) + [azimuth] + list(place) +
                        nanometres(world(datum, azimuth, place)))
    for place in [("78.54171", "11.9", "130"), ("78.9", "13.76", "130"), ("80.69", "11.9", "130")]:
        datum = ("78.9", "11.9", "30")  # 40 km south, 40 km east, 200 km north
        rows.append(list(datum) + ["0"] + list(place) + nanometres(world(datum, "0", place)))
    write("wgs84_world.csv",
          "datum_lat_deg,datum_lon_deg,datum_height_ellipsoid_m,x_azimuth_deg,"
          "lat_deg,lon_deg,height_ellipsoid_m,x_m,y_m,z_m", rows)


if __name__ == "__main__":
    main()
