"""Shares: numbers from 0 to 1 with a given sum, the relaxation of choosing so many of some points."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Vector

_HALVINGS = 30


def nearest_shares(values: Vector, total: float) -> Vector:
    """The shares nearest to some values: all are shifted by one number and cut to [0, 1].

    Parameters
    ----------
    values : ndarray, shape (n,)
    total : float
        Sum of the shares, from 0 to n; it is met to about 1e-9 of the spread of the values.

    Returns
    -------
    ndarray, shape (n,)

    Examples
    --------
    >>> import numpy as np
    >>> nearest_shares(np.array([0.9, 0.8, 0.3]), 1.0).round(6)
    array([0.55, 0.45, 0.  ])
    """
    low, high = values.min() - 1.0, values.max()
    for _ in range(_HALVINGS):
        shift = (low + high) / 2
        low, high = (shift, high) if np.clip(values - shift, 0.0, 1.0).sum() > total else (low, shift)
    return np.clip(values - (low + high) / 2, 0.0, 1.0)
