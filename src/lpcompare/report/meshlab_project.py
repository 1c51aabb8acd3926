"""A MeshLab project: the original and every result as layers, per-vertex quality = eq. 27 error.

Each result is a layer of its own points, coloured and with the error (in % of the diagonal of the bounding
box) as quality. A second, hidden layer per result holds every original with its error: the whole map.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from lpcompare.benchmark.inputs import file_name
from lpcompare.benchmark.record import Run
from lpcompare.errors import InputError
from lpcompare.files import replace_text
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_diagonal
from lpcompare.io.arrays import load_arrays
from lpcompare.mesh_library import pymeshlab
from lpcompare.report.cells import Cell, distinct, gather_cells
from lpcompare.report.clouds3d import has_cloud, input_files
from lpcompare.report.wording import percent
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
    cells, files = gather_cells(run.records), input_files(run)
    groups = {m: [c for c in cells if c.model == m and has_cloud(run, c)] for m in distinct(cells, "model")}
    groups = {model: group for model, group in groups.items() if group and model in files}
    if not groups:
        raise InputError(f"{run.folder} holds no clouds; a MeshLab project needs them: run again.")
    folder.mkdir(parents=True, exist_ok=True)
    return [_write_model(run, folder, files[model], group) for model, group in groups.items()]


def _write_model(run: Run, folder: Path, original: Path, group: Sequence[Cell]) -> Path:
    layers = []
    for label, points, faces, errors, high, visible in _layers(run, original, group):
        path = folder / f"{file_name(group[0].model)}-{len(layers):03d}.ply"
        _write_layer(path, points, faces, errors, high)
        layers.append((label, path.name, visible))
    project = folder / f"{file_name(group[0].model)}.mlp"
    replace_text(project, _document(layers))
    return project


Layer = tuple[str, Points, NDArray[np.intp] | None, Vector | None, float, bool]
"""Label, points, faces, errors, error at the top of the colour scale, visible."""


def _layers(run: Run, original: Path, group: Sequence[Cell]) -> Iterator[Layer]:
    arrays = load_arrays(original)
    points = arrays["points"].astype(float)
    to_percent = 100 / (bounding_box_diagonal(points) or 100)
    yield group[0].model, points, arrays.get("faces"), None, 0.0, True
    for reduction in sorted(distinct(group, "reduction")):
        cells = [cell for cell in group if cell.reduction == reduction]
        maps = [load_arrays(run.folder / c.cloud)["plane_errors"].astype(float) * to_percent for c in cells]
        high = float(np.median([np.percentile(errors, 99) for errors in maps]))
        for cell, errors in zip(cells, maps, strict=True):
            label = f"{cell.method} {percent(reduction)} removed"
            yield (
                label,
                *_own(run, cell, points, errors),
                high,
                reduction == max(distinct(group, "reduction")),
            )
            yield f"{label}: error of every original", points, None, errors, high, False


def _own(run: Run, cell: Cell, points: Points, errors: Vector) -> tuple[Points, None, Vector]:
    """The points of a result, each with the error of the original that it is, or lies nearest to."""
    arrays = load_arrays(run.folder / cell.cloud)
    own = arrays["points"].astype(float)
    rows = arrays["indices"] if "indices" in arrays else Neighbors(points).query(own, 1)[1][:, 0]
    return own, None, errors[rows]


def _write_layer(
    path: Path, points: Points, faces: NDArray[np.intp] | None, errors: Vector | None, high: float
) -> None:
    """A PLY file by pymeshlab, with quality and colour."""
    library = pymeshlab()
    colors = np.tile(_GREY, (len(points), 1)) if errors is None else _colors(errors, high)
    content = {"vertex_matrix": points, "v_color_matrix": colors}
    if faces is not None and len(faces):
        content["face_matrix"] = np.asarray(faces, dtype=np.int32)
    if errors is not None:
        content["v_scalar_array"] = errors
    meshes = library.MeshSet()
    meshes.add_mesh(library.Mesh(**content))
    meshes.save_current_mesh(str(path), binary=True, save_vertex_quality=True, save_vertex_color=True)


def _colors(errors: Vector, high: float) -> NDArray[np.float64]:
    from matplotlib import colormaps

    return np.asarray(colormaps["viridis"](np.clip(errors / (high or 1.0), 0, 1)), dtype=float)


def _document(layers: Sequence[tuple[str, str, bool]]) -> str:
    """The project's XML; names are escaped by the library."""
    project = ElementTree.Element("MeshLabProject")
    group = ElementTree.SubElement(project, "MeshGroup")
    for label, name, visible in layers:
        layer = ElementTree.SubElement(group, "MLMesh", label=label, filename=name, visible=str(int(visible)))
        ElementTree.SubElement(layer, "MLMatrix44").text = _IDENTITY
    ElementTree.SubElement(project, "RasterGroup")
    return "<!DOCTYPE MeshLabDocument>\n" + ElementTree.tostring(project, encoding="unicode") + "\n"
