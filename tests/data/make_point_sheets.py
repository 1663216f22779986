#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the points of glacier_bay_points.csv and the sheets from which they were labelled by eye.

    make_point_sheets.py TILES OUT

TILES is the folder of the tiles (*.JPG). Writes to OUT: points.csv (tile,x_px,y_px), tiles.png
(the chosen tiles, numbered), and per tile overview.png (the tile at twice its size, the points
numbered) and two sheets of 25 enlarged crops each. In a crop the thin frame surrounds the point's
pixel without covering it; the four corners mark the square of pixels within 2 px of it.

Decides nothing about ice or water: pixel values are only copied. The choice of tiles, the points
and their order depend on the seed and the file names alone. Needs Pillow.
"""
import argparse
import csv
import pathlib
import random
import re

from PIL import Image, ImageDraw, ImageFont

SEED = 20261123
TILES = 20
POINTS = 50  # per tile
BORDER_PX = 8  # no point nearer to the tile's border
HALF_PX = 16  # a crop shows 2 * HALF_PX + 1 pixels
ZOOM = 6
COLUMNS = 5
MARK = (255, 0, 0)


def choose_tiles(names):
    """One tile of each flight in turn, each flight's tiles in seeded order."""
    flights = {}
    for name in sorted(names):
        flights.setdefault(re.sub(r"_\d+_\d+_\d+$", "", name), []).append(name)
    for flight, of_flight in flights.items():
        random.Random(f"{SEED} {flight}").shuffle(of_flight)
    longest = max(len(of_flight) for of_flight in flights.values())
    turns = [of_flight[i] for i in range(longest) for of_flight in flights.values()
             if i < len(of_flight)]
    return turns[:TILES]


def draw_points(name, size):
    """Distinct uniform points of one tile; the same whichever other tiles are chosen."""
    generator = random.Random(f"{SEED} {name}")
    points = []
    while len(points) < POINTS:
        point = tuple(generator.randint(BORDER_PX, side - 1 - BORDER_PX) for side in size)
        if point not in points:
            points.append(point)
    return points


def draw_crop(tile, point):
    x, y = point
    side = (2 * HALF_PX + 1) * ZOOM
    # Outside the tile Pillow's crop is black.
    crop = tile.crop((x - HALF_PX, y - HALF_PX, x + HALF_PX + 1, y + HALF_PX + 1))
    crop = crop.resize((side, side), Image.NEAREST)
    draw = ImageDraw.Draw(crop)
    first, last = HALF_PX * ZOOM, (HALF_PX + 1) * ZOOM
    draw.rectangle((first - 1, first - 1, last, last), outline=MARK)
    near, far, arm = first - 2 * ZOOM - 1, last + 2 * ZOOM, ZOOM // 2
    for cx, sx in ((near, 1), (far, -1)):
        for cy, sy in ((near, 1), (far, -1)):
            draw.line((cx, cy, cx + sx * arm, cy), fill=MARK)
            draw.line((cx, cy, cx, cy + sy * arm), fill=MARK)
    return crop


def draw_sheet(tile, numbered, font):
    side = (2 * HALF_PX + 1) * ZOOM
    head, gap = 20, 8
    rows = -(-len(numbered) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * (side + gap) + gap, rows * (side + head) + gap), (90, 90, 90))
    draw = ImageDraw.Draw(sheet)
    for i, (number, point) in enumerate(numbered):
        left, top = gap + i % COLUMNS * (side + gap), i // COLUMNS * (side + head)
        draw.text((left, top + 2), f"{number}", font=font, fill=(255, 255, 255))
        sheet.paste(draw_crop(tile, point), (left, top + head))
    return sheet


def draw_overview(tile, numbered, font):
    overview = tile.resize((2 * tile.width, 2 * tile.height), Image.BICUBIC)
    draw = ImageDraw.Draw(overview)
    for number, (x, y) in numbered:
        cx, cy = 2 * x + 1, 2 * y + 1
        draw.rectangle((cx - 4, cy - 4, cx + 4, cy + 4), outline=MARK)
        draw.text((cx + 7, cy - 8), f"{number}", font=font, fill=(255, 255, 0),
                  stroke_width=2, stroke_fill=(0, 0, 0))
    return overview


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("tiles", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    font = ImageFont.truetype("DejaVuSans.ttf", 15)

    names = choose_tiles([path.stem for path in arguments.tiles.glob("*.JPG")])
    small = 240
    contact = Image.new("RGB", (COLUMNS * small, -(-len(names) // COLUMNS) * small))
    rows = []
    for i, name in enumerate(names):
        tile = Image.open(arguments.tiles / f"{name}.JPG").convert("RGB")
        points = draw_points(name, tile.size)
        rows += [(name, x, y) for x, y in points]
        numbered = list(enumerate(points, 1))
        stem = arguments.out / f"{i + 1:02d}_{name}"
        draw_overview(tile, numbered, font).save(f"{stem}_overview.png")
        draw_sheet(tile, numbered[:25], font).save(f"{stem}_points_01.png")
        draw_sheet(tile, numbered[25:], font).save(f"{stem}_points_26.png")
        left, top = i % COLUMNS * small, i // COLUMNS * small
        contact.paste(tile.resize((small - 4, small - 4), Image.BICUBIC), (left, top))
        ImageDraw.Draw(contact).text((left + 4, top + 4), f"{i + 1}", font=font, fill=(255, 255, 0),
                                     stroke_width=2, stroke_fill=(0, 0, 0))
    contact.save(arguments.out / "tiles.png")
    with open(arguments.out / "points.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("tile", "x_px", "y_px"))
        writer.writerows(rows)


if __name__ == "__main__":
    main()
