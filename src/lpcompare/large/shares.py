"""Whole numbers in proportion to weights, with an exact sum; quotients of sums that may be empty."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Indices, Vector


def largest_remainder(total: int, weights: Vector | Indices, most: Indices) -> Indices:
    """Share ``total`` in proportion to weights, none above its limit.

    Parameters
    ----------
    total : int
        From 0 to the sum of ``most``.
    weights : ndarray, shape (k,)
        Not negative.
    most : ndarray of int, shape (k,)

    Returns
    -------
    ndarray of int, shape (k,)
        Sums exactly to ``total``. What one cannot take is shared among the others; ties go to the first.

    Examples
    --------
    >>> import numpy as np
    >>> largest_remainder(10, np.array([5.0, 3.0, 2.0]), np.array([3, 9, 9]))
    array([3, 4, 3])
    """
    shares = np.zeros(len(most), dtype=np.intp)
    while missing := total - int(shares.sum()):
        open_weights = np.where(shares < most, weights, 0.0)
        if open_weights.sum() <= 0:
            open_weights = (most - shares).astype(np.float64)
        wanted = missing * open_weights / open_weights.sum()
        more = np.floor(wanted).astype(np.intp)
        order = np.argsort(more - wanted, kind="stable")
        more[order[: missing - int(more.sum())]] += 1
        shares = np.minimum(shares + more, most)
    return shares


def quotients(
    above: NDArray[np.floating | np.integer], below: NDArray[np.floating | np.integer], otherwise: float = 0.0
) -> NDArray[np.float64]:
    """Quotients of arrays of shapes that fit together, and another value where there is nothing below.

    Examples
    --------
    >>> import numpy as np
    >>> quotients(np.array([1.0, 2.0]), np.array([4, 0]))
    array([0.25, 0.  ])
    """
    shape = np.broadcast_shapes(above.shape, below.shape)
    return np.divide(above, below, out=np.full(shape, otherwise), where=below > 0)
