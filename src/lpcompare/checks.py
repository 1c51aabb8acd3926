"""What is accepted from outside: each check returns the clean value or says in one sentence what is wrong."""

from __future__ import annotations

import numbers
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from lpcompare.errors import InputError, PointsLeftOut, UnknownName
from lpcompare.types import Mask, PointCloud, Points

_LARGEST = 1e150
_SMALLEST = 1e-150


def check_points(values: object, where: str = "points") -> Points:
    """The coordinates as a C-ordered float64 array (n, 3), copied only where it has to be.

    Parameters
    ----------
    values : array_like, shape (n, 3)
        Masked entries count as missing.
    where : str
        What the values are, for the message.

    Raises
    ------
    InputError
        Not (n, 3), empty, not numeric, or not finite.
    """
    array = check_coordinates(values, where)
    if not len(array):
        raise InputError(f"{where} is empty; give at least one point.")
    cloud = np.ascontiguousarray(array, dtype=np.float64)
    bad = np.flatnonzero(~valid_rows(cloud))
    if len(bad):
        raise InputError(
            f"{where} has {len(bad)} of {len(cloud)} rows with NaN, infinity or a masked value, the first is "
            f"row {bad[0]}; remove them, or say drop_invalid=True."
        )
    check_magnitude(cloud.min(axis=0), cloud.max(axis=0), where)
    return cloud


def check_coordinates(values: object, where: str = "points") -> np.ndarray:
    """An array of numbers of shape (n, 3), finite or not; masked entries become NaN; raises `InputError`."""
    array = _numbers(values, where)
    if array.ndim != 2 or array.shape[1] != 3:
        hint = " It looks transposed; give its .T." if array.ndim == 2 and array.shape[0] == 3 else ""
        raise InputError(
            f"{where} has shape {array.shape}; give an array of shape (n, 3), one row per point.{hint}"
        )
    return array


def check_cloud(cloud: PointCloud) -> PointCloud:
    """The cloud with every part as an array that has a row for each point; coordinates may be NaN.

    Raises
    ------
    InputError
        A part is not numeric, has another number of rows, or faces name points that there are not.
    """
    points = check_coordinates(cloud.points)
    if not isinstance(cloud.attributes, Mapping) or not all(isinstance(a, str) for a in cloud.attributes):
        raise InputError(
            f"attributes is {cloud.attributes!r:.80}; give a dict of arrays by name, {{}} for none."
        )
    if not isinstance(cloud.name, str):
        raise InputError(f"name is {cloud.name!r}; give a text.")
    n_points = len(points)
    return replace(
        cloud,
        points=points,
        normals=None if cloud.normals is None else _part(cloud.normals, "normals", (n_points, 3)),
        colors=None if cloud.colors is None else _part(cloud.colors, "colors", (n_points, 4)),
        attributes={name: _attribute(name, values, n_points) for name, values in cloud.attributes.items()},
        faces=None if cloud.faces is None else _faces(cloud.faces, n_points),
    )


def _part(values: object, where: str, shape: tuple[int, int]) -> np.ndarray:
    array = _numbers(values, where)
    if array.shape != shape:
        raise InputError(f"{where} has shape {array.shape}; this cloud needs {shape}, one row per point.")
    return array


def _attribute(name: str, values: object, n_points: int) -> np.ndarray:
    try:
        array = np.asanyarray(values)
    except ValueError:
        raise InputError(f"attribute {name!r} has rows of several lengths; give an array.") from None
    if array.shape[:1] != (n_points,):
        raise InputError(
            f"attribute {name!r} has shape {array.shape}; it needs one value for each of the {n_points} points."
        )
    return array


def _faces(values: object, n_points: int) -> np.ndarray:
    array = _numbers(values, "faces")
    if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 3:
        raise InputError(
            f"faces has shape {array.shape} and type {array.dtype}; give integers, shape (f, 3)."
        )
    if array.size and not 0 <= int(array.min()) <= int(array.max()) < n_points:
        raise InputError(
            f"faces names the rows {array.min()} to {array.max()}; this cloud has 0 to {n_points - 1}."
        )
    return array.astype(np.intp, copy=False)


def check_magnitude(low: np.ndarray, high: np.ndarray, where: str) -> None:
    """Refuse a cloud of which the coordinates or the extent cannot be squared, by its box."""
    if np.abs([low, high]).max() > _LARGEST:
        raise InputError(
            f"{where} has coordinates beyond {_LARGEST:g}, whose squares overflow; rescale them."
        )
    extent = float((high - low).max())
    if 0 < extent < _SMALLEST:
        raise InputError(f"{where} spreads over {extent:g} only, whose squares underflow; rescale it.")


def valid_rows(points: Points) -> Mask:
    """Which rows have three finite coordinates, shape (n,)."""
    return np.asarray(np.isfinite(points).all(axis=1))


def left_out(n_bad: int, n_points: int, where: str) -> str:
    """The sentence that says how many points of a cloud count for nothing."""
    return f"{where}: {n_bad:,} of {n_points:,} points have no finite coordinates and are left out."


def warn_left_out(n_bad: int, n_points: int, where: str) -> None:
    """Say it as a `PointsLeftOut` where there are such points."""
    if n_bad:
        warnings.warn(left_out(n_bad, n_points, where), PointsLeftOut, stacklevel=3)


def _numbers(values: object, where: str) -> np.ndarray:
    """The values as an array of numbers; masked ones become NaN."""
    try:
        if isinstance(values, np.ma.MaskedArray):
            return np.ma.filled(values.astype(np.float64), np.nan)
        array = np.asarray(values)
        if array.dtype.kind not in "iuf":
            raise TypeError
    except Exception:  # an object of another library may raise anything in __array__
        raise InputError(f"{where} must be an array of real numbers of shape (n, 3).") from None
    return array


def target_from_reduction(n_points: int, reduction: float) -> int:
    """Points kept: floor((1 - reduction) n), rounded to nine digits first, at least one."""
    return max(1, int(np.floor(round((1.0 - reduction) * n_points, 9))))


def check_target(n_points: int, target_reduction: float | None, target_count: int | None) -> int:
    """The number of points to keep, from exactly one of the two ways to say it.

    Raises
    ------
    InputError
        Both or neither given, a reduction outside [0, 1), a count outside [1, n].
    """
    if (target_reduction is None) == (target_count is None):
        raise InputError(
            f"Give exactly one of target_reduction (got {target_reduction}) "
            f"and target_count (got {target_count})."
        )
    if target_count is not None:
        return check_integer("target_count", target_count, 1, n_points)
    reduction = check_number("target_reduction", target_reduction, 0.0, 1.0)
    if reduction == 1.0:
        raise InputError("target_reduction is 1, which keeps no point; give a share below 1.")
    return target_from_reduction(n_points, reduction)


def check_integer(name: str, value: object, low: int, high: int | None = None) -> int:
    """An integer from ``low`` to ``high``."""
    allowed = f"an integer from {low} to {high}" if high is not None else f"an integer of at least {low}"
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        raise InputError(f"{name} is {value!r}; give {allowed}.")
    number = int(value)
    if number < low or (high is not None and number > high):
        raise InputError(f"{name} is {value}; give {allowed}.")
    return number


def check_number(name: str, value: object, low: float, high: float = np.inf) -> float:
    """A finite number from ``low`` to ``high``."""
    allowed = f"a number from {low:g} to {high:g}" if np.isfinite(high) else f"a number of at least {low:g}"
    if isinstance(value, bool) or not isinstance(value, numbers.Real) or not np.isfinite(float(value)):
        raise InputError(f"{name} is {value!r}; give {allowed}.")
    if not low <= float(value) <= high:
        raise InputError(f"{name} is {value}; give {allowed}.")
    return float(value)


def check_choice(name: str, value: object, allowed: Iterable[str]) -> str:
    """One of the ``allowed`` words."""
    if value not in (known := list(allowed)):
        raise UnknownName(name, str(value), known)
    return str(value)


def check_seed(random_state: object) -> np.random.Generator:
    """A generator from a non-negative integer, a generator, or None for fresh randomness."""
    if random_state is None or isinstance(random_state, np.random.Generator):
        return np.random.default_rng(random_state)
    return np.random.default_rng(check_integer("random_state", random_state, 0))


def check_solver(name: object) -> str:
    """Return "highs", "highs-cold", or a mixed-integer solver that cvxpy finds installed."""
    if name in ("highs", "highs-cold"):
        return str(name)
    import cvxpy as cp
    from cvxpy.reductions.solvers.defines import INSTALLED_MI_SOLVERS

    installed = sorted(set(cp.installed_solvers()) & set(INSTALLED_MI_SOLVERS))
    if str(name).upper() not in installed:
        raise UnknownName("solver", str(name), ["highs", "highs-cold", *installed])
    return str(name).upper()
