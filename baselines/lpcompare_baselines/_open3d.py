"""Open3D point clouds from and to numpy arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import open3d  # pyright: ignore[reportMissingImports]

from lpcompare.geometry.scale import about_center
from lpcompare.types import Points


def point_cloud(points: Points) -> Any:
    """The points as an Open3D cloud, about the centre of their bounding box."""
    centred = about_center(points)
    return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(centred))


def points_of(cloud: Any) -> Points:
    """The coordinates, still about the centre, shape (m, 3)."""
    return np.array(cloud.points, dtype=float).reshape(-1, 3)
