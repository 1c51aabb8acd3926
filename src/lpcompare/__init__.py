"""lpcompare: thin 3D point clouds by boolean linear programs, and compare methods at equal counts.

::

    import lpcompare as lp

    cloud = lp.read("scan.laz")
    result = lp.simplify(cloud, target_reduction=0.9)
    lp.write("thin.laz", cloud.take(result.indices))
    lp.evaluate(cloud, result)
    run = lp.run(models=["bunny", cloud], methods=["lp_uniform", "poisson_disk"], reductions=[0.7, 0.9])
    run.frame

The names below are imported when they are first used, so that ``import lpcompare`` stays fast.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lpcompare.benchmark.record import Run, load_run
    from lpcompare.benchmark.runner import run
    from lpcompare.estimators import LPSimplifier, UniformSimplifier
    from lpcompare.io.formats import read, write
    from lpcompare.large.evaluate_files import evaluate_files
    from lpcompare.large.simplify_files import simplify_files
    from lpcompare.listing import methods, metrics, models
    from lpcompare.metrics.comparison import evaluate
    from lpcompare.simplify import simplify
    from lpcompare.types import PointCloud, Simplification

    __version__: str

_HOMES = {
    "LPSimplifier": "estimators",
    "PointCloud": "types",
    "Run": "benchmark.record",
    "Simplification": "types",
    "UniformSimplifier": "estimators",
    "evaluate": "metrics.comparison",
    "evaluate_files": "large.evaluate_files",
    "load_run": "benchmark.record",
    "methods": "listing",
    "metrics": "listing",
    "models": "listing",
    "read": "io.formats",
    "run": "benchmark.runner",
    "simplify": "simplify",
    "simplify_files": "large.simplify_files",
    "write": "io.formats",
}

__all__ = [
    "LPSimplifier",
    "PointCloud",
    "Run",
    "Simplification",
    "UniformSimplifier",
    "__version__",
    "evaluate",
    "evaluate_files",
    "load_run",
    "methods",
    "metrics",
    "models",
    "read",
    "run",
    "simplify",
    "simplify_files",
    "write",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("lpcompare")
    if name not in _HOMES:
        raise AttributeError(f"module 'lpcompare' has no attribute {name!r}")
    return getattr(import_module(f"lpcompare.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


class _Front(ModuleType):
    """The package, whose functions are not hidden by the sub-packages of their names."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Front
