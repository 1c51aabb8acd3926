"""Surface distance: how far the originals are from triangles through the reduced points alone.

Around every reduced point lie the triangles of its star (see `lpcompare.geometry.stars`): the neighbours of
its Voronoi cell in its tangent plane, which is the plane through its 10 nearest reduced points. The
distance of an original is that to the triangles of its 4 nearest reduced points. No radius has to be
chosen, so that a scan whose density falls with distance is judged near and far alike.

What it judges: how well flat triangles between neighbours represent the originals, and what is lost beyond
rims. What it cannot judge: whether the triangles form one surface, and false triangles across gaps where no
original is. In a volume, such as the crown of a tree, it is the distance to the nearest of many triangles.
Where the reduced points are farther apart than two sheets of the object, their tangent planes mix the
sheets. `pivoted_distance` triangulates by ball pivoting and judges holes as well, on objects of even
density.
"""

from __future__ import annotations

import numpy as np

from lpcompare.metrics.comparison import Comparison
from lpcompare.types import Column

COLUMNS = {
    "surface_distance_pct": Column(
        "% of diagonal", "Mean distance of an original to triangles of the reduced points"
    ),
    "surface_distance_p95_pct": Column("% of diagonal", "95 % of these distances are at most this"),
    "surface_distance_max_pct": Column("% of diagonal", "Largest of these distances"),
}

_CORNERS = 24
_STARS = 4


def surface_distance(comparison: Comparison) -> dict[str, float]:
    """Mean, 95 % quantile and largest distance of the originals to the stars of the reduced points.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    dict of str to float
        One value per entry of ``COLUMNS``. Where the reduced points carry no triangle, the distances to the
        points themselves stand for those to the surface.
    """
    from lpcompare.geometry.stars import make_stars

    sites, originals = comparison.simplified, comparison.original
    _, corners = comparison.simplified_neighbors.query(sites, _CORNERS)
    _, nearest = comparison.simplified_neighbors.query(originals, _STARS)
    distances = make_stars(sites, comparison.simplified_normals, corners).distances(originals, nearest)
    return {
        "surface_distance_pct": comparison.percent(float(distances.mean())),
        "surface_distance_p95_pct": comparison.percent(float(np.percentile(distances, 95))),
        "surface_distance_max_pct": comparison.percent(float(distances.max())),
    }
