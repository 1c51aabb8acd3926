"""The radius of a Poisson disk sampling of the whole cloud, from counts of disks in tiles."""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import normalized
from lpcompare.types import Points, Vector
from lpcompare.uniform.disks import SAMPLE, count_disks, disk_radius

_STEPS = np.array([0.7, 0.85, 1.0, 1.18, 1.4])


def trial_radii(job: Job) -> Vector:
    """Radii about that which the sample foresees, in normalised units, shape (5,)."""
    sample = normalized(job, job.load("sample")["points"])
    few = max(1, min(job.target_count, len(sample) // SAMPLE))
    fewer = max(1, few // 4)
    radius, wider = disk_radius(sample, few), disk_radius(sample, fewer)
    slope = np.log(wider / radius) / np.log(few / fewer) if fewer < few and 0 < radius < wider else 0.5
    foreseen = radius * (few / job.target_count) ** float(np.clip(slope, 1 / 3, 1.0))
    return _STEPS * (foreseen or bounding_box_diagonal(sample) or 1.0)


def disk_counts(points: Points, radii: Vector, share: float) -> Vector:
    """Points of a tile that a Poisson disk sampling of each radius keeps.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    radii : ndarray, shape (r,)
    share : float
        Points that stay, of all; of more than 12 points for each, only every so many is looked at.
    """
    sample = np.ascontiguousarray(points[:: max(1, int(1 / (SAMPLE * share)))])
    order = np.random.default_rng(0).permutation(len(sample))
    table = np.empty(1 << (2 * len(sample) + 2).bit_length(), dtype=np.int32)
    return np.array([count_disks(sample, order, radius, len(sample), table) for radius in radii])


def radius_of(total: int, radii: Vector, counts: Vector) -> float:
    """The radius at which ``total`` points stay, between the radii whose counts are known."""
    falling = np.log(np.maximum(np.minimum.accumulate(counts), 1.0))
    return float(np.exp(np.interp(-np.log(total), -falling, np.log(radii))))
