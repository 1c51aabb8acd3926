"""A MeshLab project: the original and every result as layers, per-vertex quality = plane error (eq. 27).

Each result is a layer of its own points, coloured and with the error (in % of the diagonal of the bounding
box) as quality. A second layer per result holds every original with its error: the whole map. The original
and the result with the lowest error at the largest reduction are visible, the rest is hidden. The layers of
one method stand together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lpcompare.benchmark.record import Run
from lpcompare.benchmark.run_folder import file_name
from lpcompare.errors import InputError
from lpcompare.files import replace_text
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.io.arrays import load_arrays
from lpcompare.mesh_library import pymeshlab
from lpcompare.report.cells import ERROR, cells
from lpcompare.report.clouds3d import error_scale, kept_results, percent_errors
from lpcompare.report.tables import percent
from lpcompare.types import Points, Vector

_IDENTITY = "1 0 0 0 \n0 1 0 0 \n0 0 1 0 \n0 0 0 1 \n"
_GREY = np.array([0.8, 0.82, 0.85, 1.0])


def write_project(run: Run, folder: Path) -> list[Path]:
    """Write one project per model, with a PLY file for each layer beside it.

    Parameters
    ----------
    run : Run
        With its clouds.
    folder : Path
        Created if need be.

    Returns
    -------
    list of Path
        The project files.

    Raises
    ------
    InputError
        The run kept no clouds.
    Unavailable
        pymeshlab is not installed.
    """
    groups = kept_results(run, cells(run.frame))
    if not groups:
        raise InputError(f"{run.folder} holds no clouds; a MeshLab project needs them: run again.")
    folder.mkdir(parents=True, exist_ok=True)
    return [_write_model(run, folder, model, *found) for model, found in groups.items()]


@dataclass(frozen=True, eq=False)
class _Layer:
    label: str
    points: Points
    errors: Vector | None = None
    high: float = 0.0
    visible: bool = False
    faces: NDArray[np.intp] | None = None


def _write_model(run: Run, folder: Path, model: str, original: Path, group: pd.DataFrame) -> Path:
    stem = file_name(model)
    project = ElementTree.Element("MeshLabProject")
    meshes = ElementTree.SubElement(project, "MeshGroup")
    for i, layer in enumerate(_layers(run, model, original, group)):
        name = f"{stem}-{i:03d}.ply"
        _write_layer(folder / name, layer)
        facts = {"label": layer.label, "filename": name, "visible": str(int(layer.visible))}
        element = ElementTree.SubElement(meshes, "MLMesh", facts)
        ElementTree.SubElement(element, "MLMatrix44").text = _IDENTITY
    ElementTree.SubElement(project, "RasterGroup")
    text = ElementTree.tostring(project, encoding="unicode")
    replace_text(folder / f"{stem}.mlp", f"<!DOCTYPE MeshLabDocument>\n{text}\n")
    return folder / f"{stem}.mlp"


def _layers(run: Run, model: str, original: Path, group: pd.DataFrame) -> Iterator[_Layer]:
    arrays = load_arrays(original)
    points = arrays["points"].astype(float)
    yield _Layer(model, points, visible=True, faces=arrays.get("faces"))
    best = group.sort_values(["reduction", ERROR], ascending=[False, True], kind="stable").index[0]
    for reduction, part in group.groupby("reduction"):
        results = [load_arrays(run.folder / name) for name in part.cloud]
        errors = [percent_errors(run.folder, result, points) for result in results]
        high = error_scale(errors)
        for (row, cell), result, error in zip(part.iterrows(), results, errors, strict=True):
            own = result["points"].astype(float)
            nearest = result["indices"] if "indices" in result else Neighbors(points).query(own, 1)[1][:, 0]
            label = f"{cell.label} {percent(float(str(reduction)))} removed"
            yield _Layer(label, own, error[nearest], high, visible=row == best)
            yield _Layer(f"{label}: error of every original", points, error, high)


def _write_layer(path: Path, layer: _Layer) -> None:
    """A PLY file by pymeshlab, with quality and colour."""
    from matplotlib import colormaps

    library, meshes = pymeshlab(), pymeshlab().MeshSet()
    content = {"vertex_matrix": layer.points, "v_color_matrix": np.tile(_GREY, (len(layer.points), 1))}
    if layer.faces is not None and len(layer.faces):
        content["face_matrix"] = np.asarray(layer.faces, dtype=np.int32)
    if layer.errors is not None:
        shares = np.clip(layer.errors / (layer.high or 1.0), 0, 1)
        content |= {
            "v_scalar_array": layer.errors,
            "v_color_matrix": np.asarray(colormaps["viridis"](shares)),
        }
    meshes.add_mesh(library.Mesh(**content))
    meshes.save_current_mesh(str(path), binary=True, save_vertex_quality=True, save_vertex_color=True)
