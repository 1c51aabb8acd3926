"""Read one file with pymeshlab and leave its arrays in an .npz; run as a program by `foreign`."""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

from lpcompare.errors import LpcompareError
from lpcompare.mesh_library import pymeshlab

_MEMORY_BYTES = 16 * 2**30


def main(path: str, result: str) -> None:
    """Write ``result``, or one JSON line {"reason"} to stderr."""
    _limit_memory()
    try:
        np.savez(result, allow_pickle=False, **_arrays(path))
    except LpcompareError as error:
        _refuse(f"is missing: {error}")
    except Exception as error:
        _refuse(f"says: {' '.join(str(error).split())[:200].rstrip('.')}")


def _arrays(path: str) -> dict[str, np.ndarray]:
    """Points, normals, colours, quality and triangles of all layers, joined, each in its place."""
    layers = pymeshlab().MeshSet()
    layers.load_new_mesh(path)
    if layers.mesh_number() > 1:
        layers.generate_by_merging_visible_meshes(mergevertices=False, deletelayer=True, mergevisible=False)
    mesh: Any = layers.current_mesh()
    arrays = {"points": np.asarray(mesh.transformed_vertex_matrix())}
    if mesh.face_number():
        arrays["faces"] = mesh.face_matrix().astype(np.intp)
    if mesh.has_vertex_color():
        arrays["colors"] = mesh.vertex_color_matrix()
    if mesh.has_vertex_scalar():
        arrays["quality"] = mesh.vertex_scalar_array()
    return arrays


def _limit_memory() -> None:
    """A damaged count must not take the machine's memory; systems without such limits go without."""
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))


def _refuse(reason: str) -> None:
    sys.stderr.write("\n" + json.dumps({"reason": reason}) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
