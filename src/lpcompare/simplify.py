"""The public function `simplify`: any cloud, any registered method, a count or an error to keep."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from lpcompare.checks import check_number, check_points, check_seed, check_target, valid_rows
from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.interplay import make_object, read_object
from lpcompare.max_error import simplify_within
from lpcompare.registry import METHODS, Seed, call
from lpcompare.types import Mask, PointCloud, Points, Simplification

if TYPE_CHECKING:
    from lpcompare.benchmark.isolation import Limits

_OUTLIER_NEIGHBORS = 12


def simplify(
    points: Any,
    *,
    target_reduction: float | None = None,
    target_count: int | None = None,
    max_error: float | None = None,
    tolerance: float | None = None,
    statistic: str = "mean",
    method: str = "lp_uniform",
    drop_invalid: bool = False,
    drop_outliers: float | None = None,
    order: bool = False,
    random_state: Seed = 0,
    callback: Callable[[str, int, int], None] | None = None,
    limits: Limits | None = None,
    **settings: Any,
) -> Simplification:
    """Thin a point cloud with any method that `lpcompare.methods` lists.

    Exactly one of ``target_reduction``, ``target_count``, ``max_error`` and ``tolerance`` says how far.

    Parameters
    ----------
    points : PointCloud, array_like of shape (n, 3), or an object of another library
        Coordinates in model units; never changed. Methods that need a mesh need a `PointCloud` with faces.
        Point clouds of Open3D, PyVista, trimesh and pymeshlab are read as they are.
    target_reduction : float, optional
        Share of the points to remove, from 0 to below 1.
    target_count : int, optional
        Points to keep, from 1 to n.
    max_error : float, optional
        Largest plane error (eq. 27, 8 neighbors) in % of the bounding-box diagonal. As few points are kept as
        it allows.
    tolerance : float, optional
        The same in model units.
    statistic : {"mean", "p95", "max"}
        Which value over the original points ``max_error`` or ``tolerance`` bounds.
    method : str
        A registered method.
    drop_invalid : bool
        Leave out points with NaN, infinity or a masked value instead of refusing the cloud.
    drop_outliers : float, optional
        Leave out points first that lie alone: the mean distance to their 12 nearest is more than so many
        standard deviations above the cloud's mean; 2 is usual. ``info["outliers"]`` are their rows.
    order : bool
        Ask for ``info["order"]``, the rank of each kept point, shape (m,): every prefix is a thinning too.
        Only progressive methods have it.
    random_state : int, SeedSequence, Generator or None
        Seed of every random draw. The same input, settings and seed give the same points.
    callback : callable, optional
        Called with (stage, done, total) by the methods that report their progress.
    limits : Limits, optional
        Call the method in a child process that these limits end. Methods whose library keeps a random state
        of its own get a child process in any case, so that the seed decides.
    **settings
        Settings of the method; ``lpcompare list METHOD`` shows them.

    Returns
    -------
    Simplification
        The kept points; ``indices`` are their rows in the input, or None where the method makes new points.
        ``as_given()`` is the thinned object of the class that was given.

    Raises
    ------
    InputError
        The cloud, the count or a setting cannot be worked on, or no count keeps the error.
    UnknownName
        There is no such method or setting.
    Unavailable
        The method needs a package that is not installed.
    MethodError, SolverError
        The method broke a promise, or its solver ended without a selection.

    References
    ----------
    The default answers the future work of N. Leal, E. Leal, G. Sanchez-Torres, A Linear Programming Approach for
    3D Point Cloud Simplification, 2017. ``lpcompare.methods().source`` names the source of each method.

    Examples
    --------
    >>> import numpy as np, lpcompare
    >>> cloud = np.random.default_rng(0).normal(size=(500, 3))
    >>> len(lpcompare.simplify(cloud, target_reduction=0.9))
    50
    >>> lpcompare.simplify(cloud, target_count=9, method="farthest_point").indices.shape
    (9,)
    """
    given = read_object(points)
    cloud, rows = _clean(given, drop_invalid=drop_invalid)
    outliers = None
    if drop_outliers is not None:
        cloud, rows, outliers = _without_outliers(cloud, rows, drop_outliers)
    METHODS.check_settings(method, settings)
    if not isinstance(random_state, np.random.SeedSequence):
        check_seed(random_state)
    if order and not METHODS.traits(method).progressive:
        known = ", ".join(name for name in METHODS if METHODS.traits(name).progressive)
        raise InputError(f"{method} has no order of its points; choose a progressive method: {known}.")

    def reduce(count: int) -> Simplification:
        if limits is None and not METHODS.traits(method).own_process:
            return call(method, cloud, count, random_state=random_state, settings=settings, callback=callback)
        from lpcompare.benchmark.isolation import Limits, call_isolated

        return call_isolated(
            method, cloud, count, random_state=random_state, settings=settings, limits=limits or Limits()
        )

    targets = [target_reduction, target_count, max_error, tolerance]
    if sum(value is not None for value in targets) != 1:
        raise InputError(
            "Give exactly one of target_reduction, target_count, max_error and tolerance "
            f"(got {', '.join(map(str, targets))})."
        )
    if max_error is None and tolerance is None:
        result = reduce(check_target(len(cloud), target_reduction, target_count))
    else:
        result = simplify_within(cloud.points, reduce, max_error, tolerance, statistic)
    result = _in_rows_of_the_input(result, rows, outliers, len(given))
    return replace(result, rebuild=partial(make_object, points))


def _clean(cloud: PointCloud, *, drop_invalid: bool) -> tuple[PointCloud, np.ndarray | None]:
    """The checked cloud, and the rows that it has of the input where some were left out."""
    if not drop_invalid:
        return replace(cloud, points=check_points(cloud.points)), None
    rows = np.flatnonzero(valid_rows(cloud.points))
    if len(rows) == len(cloud):
        return replace(cloud, points=check_points(cloud.points)), None
    if not len(rows):
        raise InputError(f"None of the {len(cloud)} points has finite coordinates; nothing is left.")
    kept = cloud.take(rows)
    return replace(kept, points=check_points(kept.points)), rows


def _without_outliers(
    cloud: PointCloud, rows: np.ndarray | None, n_deviations: float
) -> tuple[PointCloud, np.ndarray, np.ndarray]:
    """The cloud without the points that lie alone, its rows in the input, and theirs."""
    lonely = outlier_mask(cloud.points, check_number("drop_outliers", n_deviations, 0.0))
    rows = np.arange(len(cloud)) if rows is None else rows
    return cloud.take(np.flatnonzero(~lonely)), rows[~lonely], rows[lonely]


def outlier_mask(points: Points, n_deviations: float) -> Mask:
    """The points whose mean distance to their 12 nearest is far above the cloud's mean.

    Statistical outlier removal of Rusu, Marton, Blodow, Dolha and Beetz (Towards 3D point cloud based object
    maps for household environments, 2008, section 3.2), as in PCL, Open3D and CloudCompare.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Finite.
    n_deviations : float
        How many standard deviations above the mean is far.

    Returns
    -------
    ndarray of bool, shape (n,)
        True for outliers; never all of the points.
    """
    n_nearest = min(_OUTLIER_NEIGHBORS, len(points) - 1)
    if n_nearest < 1:
        return np.zeros(len(points), dtype=np.bool_)
    distances, _ = Neighbors(points).query(points, n_nearest + 1)
    means = distances.sum(axis=1) / n_nearest
    return means > means.mean() + n_deviations * means.std()


def _in_rows_of_the_input(
    result: Simplification, rows: np.ndarray | None, outliers: np.ndarray | None, n_input: int
) -> Simplification:
    """The result with its indices counted in the input, before points were left out."""
    if rows is None:
        return result
    indices = None if result.indices is None else rows[result.indices]
    info: dict[str, Any] = {**result.info, "n_left_out": n_input - len(rows)}
    if outliers is not None:
        info |= {"n_left_out": info["n_left_out"] - len(outliers), "outliers": outliers}
    return replace(result, indices=indices, info=info)
