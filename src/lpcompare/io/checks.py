"""What a cloud must be, and a file must hold, before anything works on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lpcompare.errors import InputError
from lpcompare.types import Points

_ROWS_NAMED = 5


def checked_points(values: ArrayLike, where: str) -> Points:
    """The coordinates as a float64 array of shape (n, 3), n >= 1, every value finite.

    Parameters
    ----------
    values : array_like
    where : str
        What they are, for the message: a file's name.

    Raises
    ------
    InputError
        Wrong shape or type, no points, NaN or infinity.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise InputError(f"{where} holds values of type {array.dtype}; coordinates must be real numbers.")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{where} holds an array of shape {array.shape}; points must have shape (n, 3).")
    if len(array) == 0:
        raise InputError(f"{where} holds no points; at least one is needed.")
    points = np.ascontiguousarray(array, dtype=np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise InputError(_not_finite(bad, len(points), where))
    return points


def check_held(what: str, promised: int, held: int) -> None:
    """Raise a `ValueError` where a file promises more of something than it has."""
    if promised > held:
        raise ValueError(f"it promises {promised} {what} and holds {max(held, 0)}")


def _not_finite(bad: np.ndarray, n_points: int, where: str) -> str:
    named = ", ".join(str(row) for row in bad[:_ROWS_NAMED])
    more = ", ..." if bad.size > _ROWS_NAMED else ""
    rows = "row" if bad.size == 1 else "rows"
    return (
        f"{where} has NaN or infinite coordinates in {bad.size} of {n_points} points "
        f"({rows} {named}{more}, counted from 0); remove these points first."
    )
