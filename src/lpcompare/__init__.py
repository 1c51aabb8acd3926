"""lpcompare: point cloud simplification by boolean linear programming, compared with its rivals.

The names below are imported when they are first used, so that ``import lpcompare`` stays fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lpcompare.paper.simplifier import LPSimplifier
    from lpcompare.simplify import simplify
    from lpcompare.types import PointCloud, Simplification

__all__ = ["LPSimplifier", "PointCloud", "Simplification", "simplify"]

_HOMES = {
    "LPSimplifier": "lpcompare.paper.simplifier",
    "PointCloud": "lpcompare.types",
    "Simplification": "lpcompare.types",
    "simplify": "lpcompare.simplify",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'lpcompare' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
