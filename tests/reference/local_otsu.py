#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes local_otsu.csv: scikit-image's rank.otsu and watershed on a small image.

Made with scikit-image 0.19.3 (Debian 12: python3-skimage). Run: /usr/bin/python3 local_otsu.py
"""
import csv
import pathlib

import numpy as np
from scipy import ndimage as ndi
from skimage.filters import rank, sobel
from skimage.morphology import disk
from skimage.segmentation import watershed

ROWS, COLS, RADIUS = 36, 44, 6


def picture():
    """Two floes on shaded water, with noise; what lies beyond the threshold differs by place."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[0:ROWS, 0:COLS]
    level = 60.0 + 1.5 * x
    level[(x - 12) ** 2 + (y - 14) ** 2 < 64] += 70
    level[(x - 33) ** 2 + (y - 24) ** 2 < 49] += 60
    return np.clip(np.round(level + rng.normal(0, 6, level.shape)), 0, 255).astype(np.uint8)


def main():
    here = pathlib.Path(__file__).parent
    image = picture()
    valid = np.ones_like(image)
    valid[20:30, 5:17] = 0
    with_disk = rank.otsu(image, disk(RADIUS))
    with_square = rank.otsu(image, np.ones((2 * RADIUS + 1, 2 * RADIUS + 1), np.uint8))
    masked = rank.otsu(image, disk(RADIUS), mask=valid)

    relief = np.clip(np.round(255 * sobel(ndi.gaussian_filter(image / 255.0, 1.0)) * 4), 0, 255).astype(np.uint8)
    markers = np.zeros(image.shape, np.int32)
    markers[image < 95] = 1
    markers[image > 150] = 2
    flooded = watershed(relief, markers)

    with open(here / "local_otsu.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow("row column level valid disk square masked relief marker flooded".split())
        for r in range(ROWS):
            for c in range(COLS):
                out.writerow([r, c, image[r, c], valid[r, c], with_disk[r, c], with_square[r, c],
                              masked[r, c], relief[r, c], markers[r, c], flooded[r, c]])


if __name__ == "__main__":
    main()
