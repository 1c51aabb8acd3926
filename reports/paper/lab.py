"""The clouds of a reproduction and the fits that its experiments share."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from lpcompare import LPSimplifier, PointCloud
from lpcompare.types import Points


class Lab:
    """Clouds by name, and the paper's method fitted to them.

    Parameters
    ----------
    clouds : mapping of str to PointCloud
    """

    def __init__(self, clouds: Mapping[str, PointCloud]) -> None:
        self.clouds = dict(clouds)
        self.fitted = lru_cache(maxsize=8)(self._fit)

    def points(self, model: str) -> Points:
        """The points of a cloud, shape (n, 3)."""
        return self.clouds[model].points

    def _fit(
        self, model: str, reading: str, retention: str, n_clusters: int, reduction: float, seed: int
    ) -> LPSimplifier:
        return LPSimplifier(
            target_reduction=reduction,
            method=reading,
            retention=retention,
            n_clusters=n_clusters,
            random_state=seed,
        ).fit(self.points(model))
