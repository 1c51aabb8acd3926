"""Clouds and surfaces as orthographic pictures in a matplotlib Axes; no display and no GPU needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lpcompare.errors import InputError
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import about_center
from lpcompare.mesh_library import pivoted
from lpcompare.report.styles import CLUSTER_COLORS, MARK_COLORS
from lpcompare.types import Points, Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

VIEW = (15.0, 12.0)
"""Direction from which things are seen: degrees to the right of the front, degrees above."""

_N_NEIGHBORS = 12
_LIGHT = np.array([-0.35, 0.5, 0.8]) / np.linalg.norm([-0.35, 0.5, 0.8])
_AMBIENT = 0.35


def draw_cloud(
    axes: Axes,
    points: Points,
    values: ArrayLike | None = None,
    *,
    labels: ArrayLike | None = None,
    mask: ArrayLike | None = None,
    limits: tuple[float, float] | None = None,
    colormap: str = "viridis",
    size: float = 1.0,
    view: tuple[float, float] = VIEW,
    up: str = "y",
    shaded: bool = True,
    plain: str = "#d3d9e0",
) -> ScalarMappable:
    """Draw a cloud, nearest points last, coloured by one of ``values``, ``labels`` and ``mask``, or plain.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    points : ndarray, shape (n, 3)
        In model units.
    values : array-like of float, shape (n,), optional
        Coloured by ``colormap`` over ``limits``.
    labels : array-like of int, shape (n,), optional
        Clusters, ten colours in turn.
    mask : array-like of bool, shape (n,), optional
        Two colours: kept and removed.
    limits : (float, float), optional
        Values at the ends of the colour map; 0 and the 99th percentile by default.
    colormap : str
    size : float
        Area of a point, in square typographic points.
    view : (float, float)
        Degrees to the right of the front, and above.
    up : str
        "y" or "z".
    shaded : bool
        Darken points that face away from the light, by their local plane.
    plain : str
        The colour where nothing else is given.

    Returns
    -------
    matplotlib.cm.ScalarMappable
        For a colour bar.

    Raises
    ------
    InputError
        More than one colouring, a colouring of another length than the cloud, or an unknown axis.
    """
    places, depth = project(points, view, up)
    order = np.argsort(depth)
    colors, mappable = _point_colors(len(points), (values, labels, mask), limits, colormap, plain)
    if shaded:
        normals = _turned(local_normals(points), view, up)
        colors[:, :3] *= (_AMBIENT + (1 - _AMBIENT) * brightness(normals, _LIGHT))[:, None]
    axes.scatter(*places[order].T, s=size, c=colors[order], linewidths=0, rasterized=True)
    _frame(axes)
    return mappable


def draw_mesh(
    axes: Axes,
    points: Points,
    faces: NDArray[np.intp],
    *,
    wireframe: bool = False,
    up: str = "y",
) -> None:
    """Draw triangles, the farthest first, shaded by their normals or as wires over a plain fill.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    points : ndarray, shape (n, 3)
        In model units.
    faces : ndarray of int, shape (f, 3)
        Rows of ``points``.
    wireframe : bool
        Draw the edges.
    up : str
        "y" or "z".
    """
    from matplotlib.collections import PolyCollection

    places, depth = project(points, VIEW, up)
    order = np.argsort(depth[faces].mean(axis=1))
    corners = _turned(about_center(points), VIEW, up)[faces[order]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    grey = (_AMBIENT + (1 - _AMBIENT) * brightness(normals, _LIGHT))[:, None] * np.array([[0.86, 0.89, 0.93]])
    style: dict[str, Any] = {"facecolors": grey, "edgecolors": grey, "linewidths": 0.2}
    if wireframe:
        style = {"facecolors": "white", "edgecolors": "#2b3138", "linewidths": 0.25}
    axes.add_collection(PolyCollection(list(places[faces[order]]), rasterized=True, **style))
    axes.update_datalim(places)
    axes.autoscale_view()
    _frame(axes)


def local_normals(points: Points) -> Points:
    """Unit normals (n, 3) of the plane through the neighbours of each point; their sign is arbitrary.

    By scipy and numpy: a picture is not worth the second that compiled kernels take to load.
    """
    from scipy.spatial import KDTree

    if len(points) < 3:
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))
    centred = about_center(points)
    near = centred[KDTree(centred).query(centred, min(_N_NEIGHBORS, len(points)))[1]]
    offsets = near - near.mean(axis=1, keepdims=True)
    return np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))[1][:, :, 0]


def brightness(normals: Points, light: Vector) -> Vector:
    """From 0 to 1 (n,): how squarely each surface faces a light from a unit direction, on either side."""
    return np.abs(normals @ light)


def up_axis(points: Points) -> str:
    """The axis to draw upright: z for a cloud that is flat in x and y, as scanned ground is; y otherwise."""
    x, y, z = np.ptp(points, axis=0)
    return "z" if z < 0.5 * min(x, y) else "y"


def scale_top(values: ArrayLike) -> float:
    """The value at the top of a colour scale: the 99th percentile; no single point takes all colours."""
    return float(np.percentile(values, 99))


def triangulate(points: Points) -> NDArray[np.intp]:
    """Triangles through points alone: MeshLab's ball pivoting with balls of growing size.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        In model units.

    Returns
    -------
    ndarray of int, shape (f, 3)
        Rows of ``points``; empty where no ball rests on three points.

    Raises
    ------
    InputError
        Fewer than three points.
    """
    if len(points) < 3:
        raise InputError(f"{len(points)} points span no triangle; give at least 3.")
    distances = Neighbors(points).query(points, 2)[0][:, 1]
    if not distances.any():
        return np.empty((0, 3), dtype=np.intp)
    spacing = float(np.median(distances[distances > 0]))
    meshes = pivoted(about_center(points), spacing)
    mesh = meshes.current_mesh()  # which is gone when the MeshSet is
    if mesh.vertex_number() != len(points):
        raise InputError(
            "Ball pivoting dropped points; the triangles cannot be told by the rows of the input."
        )
    return np.asarray(mesh.face_matrix(), dtype=np.intp)


def project(points: Points, view: tuple[float, float] = VIEW, up: str = "y") -> tuple[Points, Vector]:
    """Places (n, 2) on the picture, and depth (n,) towards the viewer, both in model units."""
    turned = _turned(about_center(points), view, up)
    return turned[:, :2], turned[:, 2]


def _turned(vectors: Points, view: tuple[float, float], up: str) -> Points:
    """Vectors (n, 3) in the picture's frame: right, up, towards the viewer."""
    if up not in ("y", "z"):
        raise InputError(f"The axis that points up is {up!r}; it must be 'y' or 'z'.")
    upright = vectors if up == "y" else vectors[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    right, above = np.deg2rad(view)
    turn = np.array([[np.cos(right), 0, -np.sin(right)], [0, 1, 0], [np.sin(right), 0, np.cos(right)]])
    tilt = np.array([[1, 0, 0], [0, np.cos(above), -np.sin(above)], [0, np.sin(above), np.cos(above)]])
    return upright @ (tilt @ turn).T


def _point_colors(
    n: int,
    choices: tuple[ArrayLike | None, ArrayLike | None, ArrayLike | None],
    limits: tuple[float, float] | None,
    colormap: str,
    plain: str,
) -> tuple[NDArray[np.float64], ScalarMappable]:
    """Red, green, blue, alpha of each point (n, 4), and what a colour bar needs."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize

    values, labels, _ = choices
    given = [np.asarray(a) for a in choices if a is not None]
    if len(given) > 1:
        raise InputError("Give one of values, labels and mask: a point has one colour.")
    if any(a.shape != (n,) for a in given):
        raise InputError(f"The colouring has shape {given[0].shape}; the cloud has {n} points.")
    if not given:
        mappable = ScalarMappable(Normalize(0, 1), ListedColormap([plain]))
        return mappable.to_rgba(np.zeros(n)), mappable
    if values is not None:
        low, high = limits or (0.0, scale_top(given[0]))
        mappable = ScalarMappable(Normalize(low, max(high, low + 1e-300)), colormaps[colormap])
    elif labels is not None:
        given = [given[0] % len(CLUSTER_COLORS)]
        mappable = ScalarMappable(Normalize(0, len(CLUSTER_COLORS) - 1), ListedColormap(CLUSTER_COLORS))
    else:
        mappable = ScalarMappable(Normalize(0, 1), ListedColormap(MARK_COLORS))
    return mappable.to_rgba(given[0].astype(float)), mappable


def _frame(axes: Axes) -> None:
    axes.set_aspect("equal")
    axes.set_axis_off()
