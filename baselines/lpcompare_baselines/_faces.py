"""What the rivals that work on triangle meshes share: the guard, and the face count that leaves n points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError, NotApplicable
from lpcompare.types import Indices, PointCloud, Points

_MOST_CALLS = 12


def faces_of(cloud: PointCloud | None, target_count: int) -> NDArray[np.intp]:
    """The triangles of a cloud that can be reduced to ``target_count`` points, shape (f, 3).

    Raises
    ------
    NotApplicable
        The cloud has no faces, or its faces use fewer points than are asked for.
    InputError
        A face names a point that does not exist.
    """
    if cloud is None or cloud.faces is None or len(cloud.faces) == 0:
        raise NotApplicable("The method needs a triangle mesh and the cloud has no faces; give it a mesh.")
    faces = np.asarray(cloud.faces)
    if faces.min() < 0 or faces.max() >= len(cloud):
        raise InputError(
            f"Faces name points {faces.min()} to {faces.max()}; allowed are 0 to {len(cloud) - 1}."
        )
    n_used = len(np.unique(faces))
    if target_count > n_used:
        raise NotApplicable(
            f"{target_count} points are asked for, but the faces use only {n_used} of the {len(cloud)} "
            "points and the method loses the others; ask for fewer."
        )
    return faces


def search_n_faces(count: Callable[[int], int], target_count: int, faces: NDArray[np.intp]) -> int:
    """Face count whose point count is nearest to the target.

    A collapse takes one point and about two faces away: where it starts says how many faces there are first,
    and the points in excess, doubled, correct them. On a closed mesh the first count is right.

    Parameters
    ----------
    count : callable
        Points left by a face count.
    target_count : int
    faces : ndarray of int, shape (f, 3)
        The mesh.

    Returns
    -------
    int
    """
    n_points, misses = len(np.unique(faces)), dict[int, int]()
    wanted = len(faces) - 2 * (n_points - target_count)
    for _ in range(_MOST_CALLS):
        wanted = min(max(wanted, 1), len(faces))
        if wanted in misses:
            break
        excess = count(wanted) - target_count
        misses[wanted] = abs(excess)
        if excess == 0:
            break
        wanted -= 2 * excess
    return min(misses, key=misses.__getitem__)


def rows_at(points: Points, kept: Points) -> Indices:
    """Rows of ``points`` (n, 3) at the positions of ``kept`` (m, 3), ascending.

    Where several rows share a position, as many of them are named as it was kept times.
    """
    _, place = np.unique(np.concatenate([points, kept]), axis=0, return_inverse=True)
    places, wanted = place.ravel()[: len(points)], np.sort(place.ravel()[len(points) :])
    order = np.argsort(places, kind="stable")
    repeat = np.arange(len(wanted)) - np.searchsorted(wanted, wanted)
    return np.sort(order[np.searchsorted(places[order], wanted) + repeat])
