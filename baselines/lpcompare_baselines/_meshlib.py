"""MeshLib point clouds from numpy arrays, and rows from its bit sets."""

from __future__ import annotations

from typing import Any

import numpy as np
from meshlib import mrmeshnumpy  # pyright: ignore[reportMissingImports]

from lpcompare.geometry.scale import about_center
from lpcompare.types import Indices, Points


def point_cloud(points: Points) -> Any:
    """The points as a MeshLib cloud in single precision, about the centre of their bounding box."""
    centred: Any = about_center(points)
    return mrmeshnumpy.pointCloudFromPoints(centred)


def rows_of(kept: Any) -> Indices:
    """Rows that are set, ascending."""
    return np.flatnonzero(mrmeshnumpy.getNumpyBitSet(kept))
