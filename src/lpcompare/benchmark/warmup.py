"""What happens before the clock starts: the library is loaded, the method has run once on a small torus."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import Any

import numpy as np

from lpcompare.types import PointCloud, Traits

_RINGS, _TARGET = 16, 64
_ONE_GENERATOR_PER_PROCESS = "pymeshlab"


def library(traits: Traits) -> str:
    """The module that a method wraps: the first word of ``wraps``."""
    return re.split(r"\W", traits.wraps, maxsplit=1)[0]


def load_library(traits: Traits) -> None:
    """Import the library that the method wraps; what is missing is the method's to report."""
    for name in (library(traits), *traits.requires):
        with suppress(ImportError):
            import_module(name)


def warm_up(method: Callable[[PointCloud, int, np.random.Generator], Any], traits: Traits) -> None:
    """Call the method once on a small closed mesh, so that lazy imports and thread pools are not timed.

    MeshLab's methods are left out: they draw from one generator per process that cannot be seeded, and give
    the same points again only after the same calls in a fresh process. An error is left to the call itself.
    """
    if library(traits) == _ONE_GENERATOR_PER_PROCESS:
        return
    try:
        method(torus(), _TARGET, np.random.default_rng(0))
    except MemoryError:
        raise
    except Exception:
        return


def torus() -> PointCloud:
    """256 points of a torus with normals and 512 triangles."""
    u, v = np.divmod(np.arange(_RINGS**2), _RINGS)
    a, b = 2 * np.pi * u / _RINGS, 2 * np.pi * v / _RINGS
    normals = np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], axis=1)
    points = np.stack([2 * np.cos(a), 2 * np.sin(a), 0 * a], axis=1) + 0.7 * normals
    right, up = (u + 1) % _RINGS * _RINGS, (v + 1) % _RINGS
    corner = [u * _RINGS + v, right + v, right + up, u * _RINGS + up]
    faces = np.concatenate([np.stack(corner[:3], axis=1), np.stack([corner[0], *corner[2:]], axis=1)])
    return PointCloud(points, normals=normals, faces=faces.astype(np.intp), name="torus")
