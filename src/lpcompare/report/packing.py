"""Arrays as base64 text in a page; assets/decode.js is the counterpart.

Coordinates and values become 16-bit steps of their range, which is finer than a screen shows; a mask becomes
one bit per point.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import Mask, Points, Vector

_STEPS = 65535


def pack(array: NDArray[Any]) -> str:
    """An array's bytes."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


def pack_mask(mask: Mask) -> str:
    """A mask (n,), one bit per point, least significant first."""
    return pack(np.packbits(mask, bitorder="little"))


def pack_points(points: Points, low: Vector, span: Vector) -> str:
    """Points (n, 3) within a box; what lies outside is moved to its wall."""
    return pack(_steps(points - low, span))


def pack_values(values: Vector) -> dict[str, Any]:
    """Values (n,), with the smallest and the span that give them back."""
    low, span = float(values.min()), float(np.ptp(values))
    return {"low": low, "span": span, "steps": pack(_steps(values - low, np.array(span)))}


def _steps(offsets: NDArray[np.float64], span: NDArray[np.float64]) -> NDArray[np.uint16]:
    share = np.divide(offsets, span, out=np.zeros_like(offsets), where=span > 0)
    return (np.clip(share, 0, 1) * _STEPS).round().astype("<u2")
