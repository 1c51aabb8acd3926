"""An original cloud and its simplification: what the metrics share, and every quick metric at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.checks import check_points, valid_rows, warn_left_out
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes, plane_distances
from lpcompare.geometry.scale import bounding_box_center, bounding_box_diagonal
from lpcompare.interplay import read_object
from lpcompare.registry import METRICS
from lpcompare.types import Points, Simplification, Vector

_LARGEST_NEIGHBORHOOD = 12
_NORMAL_NEIGHBORS = 10


def evaluate(
    cloud: Any,
    result: Any,
    *,
    metrics: Sequence[str] | None = None,
) -> dict[str, float]:
    """Every quick metric of a simplification.

    Parameters
    ----------
    cloud : PointCloud, array_like of shape (n, 3), or an object that `simplify` takes
        The original, in model units.
    result : Simplification, or what ``cloud`` may be, with m >= 1 points
        The reduced cloud, in the same units.
    metrics : sequence of str, optional
        The metrics to take; by default all that are quick.

    Returns
    -------
    dict of str to float
        One number per column. `lpcompare.metrics` explains the columns; the slow metrics, which triangulate
        a surface, are left out.

    Raises
    ------
    InputError
        A cloud is not (n, 3), or has no point with finite coordinates.
    UnknownName
        There is no such metric.

    Warns
    -----
    PointsLeftOut
        Points of an array or of a cloud have a coordinate that is NaN or infinite, and do not count.

    References
    ----------
    The plane error is eq. 27 of N. Leal, E. Leal, G. Sanchez-Torres, A Linear Programming Approach for 3D Point
    Cloud Simplification, 2017. The file of each metric names the source of the others.

    Examples
    --------
    >>> import numpy as np
    >>> from lpcompare.metrics.comparison import evaluate
    >>> ground = np.random.default_rng(0).uniform(size=(2000, 3)) * [10.0, 10.0, 0.0]
    >>> values = evaluate(ground, ground[::10])
    >>> round(values["plane_error_pct"], 6), values["hausdorff_pct"] > values["mean_distance_pct"] > 0
    (0.0, True)
    """
    comparison = Comparison(_coordinates(cloud, "The original"), _coordinates(result, "The reduced cloud"))
    return {
        key: value
        for name in metrics or METRICS.quick
        for key, value in METRICS.get(name)(comparison).items()
    }


def _coordinates(cloud: Any, where: str) -> Points:
    """Clean coordinates; points without any are left out, as `lpcompare.simplify` can leave them out."""
    points = read_object(cloud.points if isinstance(cloud, Simplification) else cloud, where).points
    valid = valid_rows(points)
    if valid.any():
        warn_left_out(int((~valid).sum()), len(points), where)
        points = points[valid]
    return check_points(points, where)


class Comparison:
    """Both clouds, moved to the centre of the original; each shared quantity is computed once.

    Parameters
    ----------
    original : ndarray, shape (n, 3)
        The clean input cloud, finite, in model units.
    simplified : ndarray, shape (m, 3)
        The reduced cloud, m >= 1.
    """

    def __init__(self, original: Points, simplified: Points) -> None:
        center = bounding_box_center(original)
        self.original: Points = original - center
        self.simplified: Points = simplified - center
        self.diagonal = bounding_box_diagonal(original)
        self._plane_errors: dict[int, Vector] = {}

    @cached_property
    def original_neighbors(self) -> Neighbors:
        """k-d tree over the original."""
        return Neighbors(self.original)

    @cached_property
    def simplified_neighbors(self) -> Neighbors:
        """k-d tree over the simplified cloud."""
        return Neighbors(self.simplified)

    @cached_property
    def _forward(self) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        return self.simplified_neighbors.query(self.original, _LARGEST_NEIGHBORHOOD)

    @cached_property
    def _backward(self) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        return self.original_neighbors.query(self.simplified, 1)

    @cached_property
    def _within(self) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        return self.simplified_neighbors.query(self.simplified, _NORMAL_NEIGHBORS)

    @property
    def forward_distances(self) -> Vector:
        """Distance of each original to its nearest simplified point, shape (n,), in model units."""
        return self._forward[0][:, 0]

    @property
    def backward_distances(self) -> Vector:
        """Distance of each simplified point to its nearest original, shape (m,), in model units."""
        return self._backward[0][:, 0]

    @property
    def forward_nearest(self) -> NDArray[np.intp]:
        """Row of the nearest simplified point of each original, shape (n,)."""
        return self._forward[1][:, 0]

    @property
    def backward_nearest(self) -> NDArray[np.intp]:
        """Row of the nearest original of each simplified point, shape (m,)."""
        return self._backward[1][:, 0]

    def nearest(self, n_neighbors: int) -> NDArray[np.intp]:
        """Rows of the nearest simplified points of each original, nearest first, shape (n, k)."""
        if n_neighbors <= _LARGEST_NEIGHBORHOOD:
            return self._forward[1][:, :n_neighbors]
        return self.simplified_neighbors.query(self.original, n_neighbors)[1]

    @property
    def spacings(self) -> Vector:
        """Distance of each simplified point to the next one, shape (m,), in model units; 0 for one alone."""
        distances = self._within[0]
        return distances[:, 1] if distances.shape[1] > 1 else np.zeros(len(self.simplified))

    @cached_property
    def original_normals(self) -> Points:
        """Unit normal of each original's plane through its 10 nearest, shape (n, 3), no sign."""
        _, nearest = self.original_neighbors.query(self.original, _NORMAL_NEIGHBORS)
        return fit_planes(self.original, nearest)[1]

    @cached_property
    def simplified_normals(self) -> Points:
        """Unit normal of each simplified point's plane through its 10 nearest, shape (m, 3), no sign."""
        return fit_planes(self.simplified, self._within[1])[1]

    def plane_errors(self, n_neighbors: int) -> Vector:
        """Eq. 27 before the mean: distance of each original to the plane of its nearest simplified points.

        Parameters
        ----------
        n_neighbors : int
            Simplified points that carry each plane.

        Returns
        -------
        ndarray, shape (n,), in model units.
        """
        if n_neighbors not in self._plane_errors:
            nearest = self.nearest(n_neighbors)
            self._plane_errors[n_neighbors] = plane_distances(self.original, self.simplified, nearest)
        return self._plane_errors[n_neighbors]

    def plane_error_percent(self, n_neighbors: int = 8) -> float:
        """Eq. 27: mean of `plane_errors`, in % of the original's bounding-box diagonal."""
        return self.percent(float(self.plane_errors(n_neighbors).mean()))

    def percent(self, length: float) -> float:
        """A length in % of the original's bounding-box diagonal; of a cloud without extent, 0 or infinity."""
        if self.diagonal > 0:
            return 100.0 * length / self.diagonal
        return 0.0 if length == 0 else float("inf")
