"""What makes a bare cloud look like a surface: local normals, and the axis that points up."""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes
from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Points, Vector

_N_NEIGHBORS = 12


def local_normals(points: Points) -> Points:
    """Unit normals (n, 3) of the plane through the neighbours of each point; their sign is arbitrary."""
    if len(points) < 3:
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))
    centred = points - bounding_box_center(points)
    return fit_planes(centred, Neighbors(centred).query(centred, _N_NEIGHBORS)[1])[1]


def brightness(normals: Points, light: Vector) -> Vector:
    """From 0 to 1 (n,): how squarely each surface faces a light from a unit direction, on either side."""
    return np.abs(normals @ light)


def up_axis(points: Points) -> str:
    """The axis to draw upright: z for a cloud that is flat in x and y, as scanned ground is; y otherwise."""
    x, y, z = np.ptp(points, axis=0)
    return "z" if z < 0.5 * min(x, y) else "y"
