"""Draw what the measures measure, on a profile: ``python docs/images/draw_metrics.py`` from the root."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

KEPT = np.array([0, 9, 18, 24, 27, 30, 33, 36, 42, 51, 60])


def profile() -> np.ndarray:
    """Sixty-one points of a line with a ridge, shape (61, 2)."""
    x = np.linspace(0, 3, 61)
    return np.column_stack([x, 0.9 * np.exp(-((x - 1.5) ** 2) / 0.12)])


def nearest(points: np.ndarray, kept: np.ndarray, count: int) -> np.ndarray:
    """Rows of the ``count`` kept points nearest to each point."""
    gaps = np.linalg.norm(points[:, None] - kept[None], axis=2)
    return np.argsort(gaps, axis=1)[:, :count]


def to_points(points: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """The kept point nearest to each point."""
    return kept[nearest(points, kept, 1)[:, 0]]


def to_planes(points: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """The foot of each point on the line fitted to its three nearest kept points."""
    hoods = kept[nearest(points, kept, 3)]
    centers = hoods.mean(axis=1)
    axes = np.linalg.svd(hoods - centers[:, None])[2][:, 0]
    along = np.einsum("ij,ij->i", points - centers, axes)
    return centers + along[:, None] * axes


def to_segments(points: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """The nearest point of the chain through the kept points: a surface, in a profile."""
    starts, ways = kept[:-1], np.diff(kept, axis=0)
    along = np.einsum("ijk,jk->ij", points[:, None] - starts[None], ways) / np.square(ways).sum(axis=1)
    feet = starts[None] + np.clip(along, 0, 1)[..., None] * ways[None]
    best = np.linalg.norm(points[:, None] - feet, axis=2).argmin(axis=1)
    return feet[np.arange(len(points)), best]


def main() -> None:
    """Write metrics.png beside this file."""
    points = profile()
    kept = points[KEPT]
    panels = {
        "mean distance and Hausdorff distance:\nto the nearest kept point": to_points,
        "plane error (eq. 27):\nto the plane through near kept points": to_planes,
        "surface distance:\nto triangles of kept points": to_segments,
    }
    figure, axes = plt.subplots(1, 3, figsize=(9.6, 1.9), layout="constrained")
    for axis, (title, foot) in zip(axes, panels.items(), strict=True):
        feet = foot(points, kept)
        axis.plot(*np.stack([points, feet]).transpose(2, 0, 1), color="#c03000", linewidth=0.9)
        axis.plot(*points.T, ".", color="#90a0b0", markersize=4)
        axis.plot(*kept.T, "o", color="#123048", markersize=4.5)
        mean = np.linalg.norm(points - feet, axis=1).mean()
        axis.set_title(f"{title}, mean {mean:.3f}", fontsize=9)
        axis.set(aspect="equal", xlim=(-0.1, 3.1), ylim=(-0.15, 1.0))
        axis.axis("off")
    figure.savefig(Path(__file__).with_name("metrics.png"), dpi=130)


if __name__ == "__main__":
    main()
