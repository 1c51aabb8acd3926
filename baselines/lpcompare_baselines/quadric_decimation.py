"""Quadric edge collapse by fast-simplification, at the face count that leaves the points asked for.

Garland and Heckbert's error quadrics on a mesh. The library is told how many faces to keep, not how many
points: outside the clock, the face count is corrected until the points agree. Points that no face uses are
lost, and the kept ones move to where their quadric is least.
"""

from __future__ import annotations

import fast_simplification
import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.scale import about_center, bounding_box_center
from lpcompare.types import PointCloud, Points, Simplification, Traits
from lpcompare_baselines._faces import faces_of, search_n_faces

TRAITS = Traits(
    family="mesh",
    wraps="fast_simplification.simplify",
    source="Garland and Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997",
    licence="MIT",
    needs_mesh=True,
    moves_points=True,
    keeps_attributes=False,
)


def calibrate(
    points: Points, target_count: int, *, rng: np.random.Generator, cloud: PointCloud | None = None
) -> dict[str, int]:
    """Number of faces that leaves ``target_count`` points; raises as `quadric_decimation` does."""
    faces = faces_of(cloud, target_count)
    return {"n_faces": search_n_faces(lambda n: len(_collapse(points, faces, n)), target_count, faces)}


def quadric_decimation(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    cloud: PointCloud | None = None,
    n_faces: int,
) -> Simplification:
    """Collapse edges, the least quadric error first.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of points that faces use.
    rng : numpy.random.Generator
        Not used: the method is deterministic.
    cloud : PointCloud
        The same points with their faces.
    n_faces : int
        Faces to keep; `calibrate` finds it.

    Returns
    -------
    Simplification
        New points.

    Raises
    ------
    NotApplicable
        The cloud has no faces, or they use fewer points than are asked for.
    InputError
        A face names a point that does not exist.
    """
    faces = faces_of(cloud, target_count)
    return Simplification(_collapse(points, faces, n_faces) + bounding_box_center(points))


def _collapse(points: Points, faces: NDArray[np.intp], n_faces: int) -> Points:
    """Points left, about the centre: far from the origin the quadrics lose digits."""
    centred = np.ascontiguousarray(about_center(points))
    kept = fast_simplification.simplify(centred, faces.astype(np.int32), target_count=n_faces)[0]
    return np.asarray(kept, dtype=float)
