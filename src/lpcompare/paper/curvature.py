"""Stage 2: curvature of a quadric fitted to each neighbourhood, eqs. 6-11 of Leal et al. (2017).

The neighbours of a point are written in a frame around their direction of least variance ``w``, and
``w = c + p u + q v + r uu/2 + s uv + t vv/2`` is fitted by least squares. H and K are those of that graph at
the point itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import estimate_surface
from lpcompare.threads import Progress
from lpcompare.types import Points, Vector


@dataclass(frozen=True, eq=False)
class Curvature:
    """Curvature of the surface at each point.

    Attributes
    ----------
    mean : ndarray, shape (n,)
        H = (k1 + k2) / 2, eq. 9, in 1 / model units; its sign is arbitrary, as the normal's is.
    gaussian : ndarray, shape (n,)
        K = k1 k2, eq. 10, in 1 / model units squared.
    """

    mean: Vector
    gaussian: Vector

    @property
    def absolute(self) -> Vector:
        """A = |k1| + |k2|, eq. 11, shape (n,), in 1 / model units."""
        spread = np.sqrt(np.maximum(self.mean**2 - self.gaussian, 0.0))
        return 2.0 * np.maximum(np.abs(self.mean), spread)

    def in_units(self, scale: float) -> Curvature:
        """The curvature of the cloud multiplied by ``scale``."""
        return Curvature(self.mean / scale, self.gaussian / scale**2)


def estimate_curvature(points: Points, n_neighbors: int = 20, progress: Progress | None = None) -> Curvature:
    """Least-squares quadric through the nearest neighbours of every point (eqs. 6-11).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Finite, in any unit.
    n_neighbors : int
        Points per fit, the point itself among them; cut to the size of the cloud.
    progress : callable, optional
        Called with (blocks done, blocks).

    Returns
    -------
    Curvature
        In the units of ``points``. Zero where the neighbours coincide; where they are too few or lie on a
        line, of the fit with the smallest coefficients.
    """
    neighbors = Neighbors(points)
    return Curvature(*neighbors.in_rows(estimate_surface(neighbors, n_neighbors, progress).curvatures).T)
