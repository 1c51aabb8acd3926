"""pymeshlab, imported in one place, so that a missing system library is one sentence everywhere; pivoting by it."""

from __future__ import annotations

import re
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from lpcompare.errors import Unavailable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_BALLS = (1.0, 2.0, 3.0, 4.5)
_SHARE_OF_SPACING = 0.9
_PACKAGES = {"libGL.so.1": "libgl1 (Debian, Ubuntu), mesa-libGL (Fedora) or libglvnd (Arch)"}


def pymeshlab() -> ModuleType:
    """The module pymeshlab.

    Raises
    ------
    Unavailable
        pymeshlab, or a system library that it loads, is not installed; the message says what to install.
    """
    try:
        return import_module("pymeshlab")
    except ImportError as error:
        raise Unavailable(_sentence(str(error))) from error


def pivoted(points: NDArray[np.float64], spacing: float) -> Any:
    """A MeshSet whose layer has triangles through points (n, 3): ball pivoting with balls of growing size.

    One size alone leaves holes where points are sparse.
    """
    library = pymeshlab()
    meshes = library.MeshSet()
    meshes.add_mesh(library.Mesh(points))
    meshes.compute_normal_for_point_clouds(k=10)
    for ball in _BALLS:
        radius = library.PureValue(_SHARE_OF_SPACING * spacing * ball)
        meshes.generate_surface_reconstruction_ball_pivoting(ballradius=radius)
    return meshes


def _sentence(reason: str) -> str:
    library = re.search(r"lib[\w.+-]+\.so[.\d]*", reason)
    if library is None:
        return f"pymeshlab cannot be imported ({reason}); install it with: pip install pymeshlab."
    package = _PACKAGES.get(library[0], f"the package that holds {library[0]}")
    return f"pymeshlab needs the system library {library[0]}, which is not installed; install {package}."
