"""Make a synthetic airborne survey: LAZ files side by side, with terrain, roofs, trees and scan lines.

    python tests/benchmarks/make_survey.py FOLDER [--files 20] [--points 1000000]

Every file is one tile of 1 km by 1 km; the height is of several wavelengths, houses are boxes with gable roofs,
and every sixth point is somewhere in a tree. The density falls to a half towards the edges of flight lines.
"""

import argparse
from pathlib import Path

import laspy
import numpy as np

SIDE = 1000.0
LINE = 250.0
HOUSES = 150
TREES = 800


def terrain(x, y):
    """Height of the ground."""
    waves = [(40, 0.0011, 0.0017), (12, 0.0053, -0.0041), (3, 0.021, 0.017), (0.5, 0.11, -0.09)]
    return 200 + sum(a * np.sin(2 * np.pi * (x * u + y * v)) for a, u, v in waves)


def tile(column, row, n, rng):
    """Coordinates, class and intensity of one file."""
    x, y = rng.random((2, int(1.6 * n))) * SIDE
    across = np.abs((y % LINE) / LINE - 0.5) * 2
    stays = np.flatnonzero(rng.random(len(x)) < 1 - 0.5 * across)[:n]
    x, y = x[stays] + column * SIDE, y[stays] + row * SIDE
    z, kind = terrain(x, y), np.full(len(x), 2, dtype=np.uint8)
    for house in rng.random((HOUSES, 4)):
        cx, cy = column * SIDE + house[0] * SIDE, row * SIDE + house[1] * SIDE
        inside = (np.abs(x - cx) < 5 + 6 * house[2]) & (np.abs(y - cy) < 5 + 4 * house[3])
        z[inside] = terrain(cx, cy) + 6 + 4 * (1 - np.abs(y[inside] - cy) / 9)
        kind[inside] = 6
    trees = rng.random((TREES, 3))
    leaf = np.flatnonzero((rng.random(len(x)) < 1 / 6) & (kind == 2))
    near = rng.integers(0, TREES, len(leaf))
    offset = rng.normal(size=(len(leaf), 3)) * 1.5
    x[leaf] = column * SIDE + trees[near, 0] * SIDE + offset[:, 0]
    y[leaf] = row * SIDE + trees[near, 1] * SIDE + offset[:, 1]
    z[leaf] = terrain(x[leaf], y[leaf]) + 6 + 6 * trees[near, 2] + offset[:, 2]
    kind[leaf] = 5
    z += rng.normal(size=len(z)) * 0.02
    return np.column_stack([x, y, z]), kind, rng.integers(0, 4000, len(x)).astype(np.uint16)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--files", type=int, default=20)
    parser.add_argument("--points", type=int, default=1_000_000)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    columns = max(1, round(given.files**0.5))
    for number in range(given.files):
        points, kind, intensity = tile(
            number % columns, number // columns, given.points, np.random.default_rng(number)
        )
        header = laspy.LasHeader(version="1.4", point_format=6)
        header.scales, header.offsets = [0.001] * 3, [0, 0, 0]
        las = laspy.LasData(header)
        las.xyz, las.classification, las.intensity = points, kind, intensity
        las.gps_time = np.arange(len(points)) * 1e-6 + number
        las.write(str(given.folder / f"tile{number:03d}.laz"))


if __name__ == "__main__":
    main()
