"""A frame around each of many normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors (3, q) that make a right-handed frame with each unit normal (3, q).

    Duff and others, Building an orthonormal basis, revisited, JCGT 6(1), 2017.
    """
    x, y, z = normals
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x])
    return first, np.stack([b, sign + y * y * a, -y])
