"""Pivoted distance: how far the originals are from a surface triangulated from the reduced points alone.

Ball pivoting (Bernardini, Mittleman, Rushmeier, Silva and Taubin, IEEE TVCG 5(4), 1999) by MeshLab, with
normals from 10 neighbours and a ball that grows over the same surface: 0.9 times the median spacing, times 1,
2, 3 and 4.5, so that an adaptive sampling is not charged with the holes of one ball size. What stays open
counts as it is. The points are put in a fixed order first, because the triangles that ball pivoting finds
depend on where it begins: by 2 to 3 % of this distance.
"""

from __future__ import annotations

import numpy as np

from lpcompare.mesh_library import pivoted, pymeshlab
from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column, Points, Vector

COST = "slow"
COLUMNS = {
    "pivoted_distance_pct": Column(
        "% of diagonal", "Mean distance of an original to the triangulated surface"
    ),
    "pivoted_distance_max_pct": Column("% of diagonal", "Largest distance of an original to that surface"),
}


def pivoted_distance(comparison: Comparison) -> dict[str, float]:
    """Mean and largest distance of the originals to the surface of the reduced points.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``. Where the reduced points carry no triangle, the distances to the
        points themselves stand for those to the surface.
    """
    distances = _distances(comparison)
    return {
        "pivoted_distance_pct": comparison.percent(float(distances.mean())),
        "pivoted_distance_max_pct": comparison.percent(float(distances.max())),
    }


def _distances(comparison: Comparison) -> Vector:
    """Distance of each original to the surface, shape (n,), in model units."""
    spacings = comparison.spacings[comparison.spacings > 0]
    if len(spacings) < 3:
        return comparison.forward_distances
    meshes = pivoted(comparison.simplified[np.lexsort(comparison.simplified.T)], float(np.median(spacings)))
    if meshes.current_mesh().face_number() == 0:
        return comparison.forward_distances
    return _to_surface(meshes, comparison.original, comparison.diagonal)


def _to_surface(meshes, points: Points, diagonal: float) -> Vector:
    """Distance of each point to the faces of the current layer, shape (n,)."""
    ml = pymeshlab()
    surface = meshes.current_mesh_id()
    meshes.add_mesh(ml.Mesh(points))
    meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(
        measuremesh=meshes.current_mesh_id(),
        refmesh=surface,
        signeddist=False,
        maxdist=ml.PureValue(2 * diagonal),
    )
    return np.abs(meshes.current_mesh().vertex_scalar_array())
