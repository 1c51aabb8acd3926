"""The records that travel through lpcompare, and its array aliases."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Points: TypeAlias = NDArray[np.float64]
"""Coordinates, shape ``(n, 3)``, in model units."""

Vector: TypeAlias = NDArray[np.float64]
"""One number per point, shape ``(n,)``."""

Indices: TypeAlias = NDArray[np.intp]
"""Row numbers, shape ``(m,)``."""

Mask: TypeAlias = NDArray[np.bool_]
"""One truth value per point, shape ``(n,)``."""


@dataclass(frozen=True, eq=False)
class PointCloud:
    """A point cloud as it was read, with everything that its file said about each point.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        Coordinates in model units.
    normals : ndarray, shape (n, 3), or None
        Unit normals.
    colors : ndarray, shape (n, 4), or None
        Red, green, blue, alpha, each from 0 to 1.
    attributes : mapping of str to ndarray, each of shape (n, ...)
        Further values per point.
    faces : ndarray of int, shape (f, 3), or None
        Triangles as rows of ``points``.
    name : str
        The model's name or the file's stem.
    beside : tuple of str
        What its file has beside the points, such as a coordinate reference system. It does not travel, and
        `write` says so.

    Examples
    --------
    >>> import numpy as np
    >>> cloud = PointCloud(np.eye(3), attributes={"id": np.array([7, 8, 9])}, name="corners")
    >>> cloud
    PointCloud('corners': 3 points; attributes id)
    >>> len(cloud)
    3
    """

    points: Points
    normals: Points | None = None
    colors: NDArray[np.float64] | None = None
    attributes: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    faces: NDArray[np.intp] | None = None
    name: str = ""
    beside: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        parts = [f"{len(self)} points"]
        parts += [n for n in ("normals", "colors") if getattr(self, n) is not None]
        parts += [f"{len(self.faces)} faces"] if self.faces is not None else []
        parts += [f"attributes {', '.join(self.attributes)}"] if self.attributes else []
        return f"PointCloud({self.name!r}: {'; '.join(parts)})"

    def take(self, rows: Indices | Mask) -> PointCloud:
        """The cloud of some of the points: everything but the faces follows.

        Parameters
        ----------
        rows : ndarray of int or bool, shape (m,) or (n,)

        Returns
        -------
        PointCloud

        Examples
        --------
        >>> import numpy as np
        >>> cloud = PointCloud(np.eye(3), attributes={"id": np.array([7, 8, 9])})
        >>> cloud.take(np.array([0, 2])).attributes["id"]
        array([7, 9])
        """
        return PointCloud(
            np.asanyarray(self.points)[rows],
            normals=None if self.normals is None else np.asanyarray(self.normals)[rows],
            colors=None if self.colors is None else np.asanyarray(self.colors)[rows],
            attributes={name: np.asanyarray(values)[rows] for name, values in self.attributes.items()},
            name=self.name,
            beside=self.beside,
        )


@dataclass(frozen=True, eq=False)
class Simplification:
    """What a method returns.

    Attributes
    ----------
    points : ndarray, shape (m, 3)
        The reduced cloud, in model units.
    indices : ndarray of int, shape (m,), or None
        The rows of the input that were kept, ascending; None when the points are new.
    timings : mapping of str to float
        Seconds per stage.
    info : mapping of str to Any
        What else the method has to say; the keys are the method's own.
    method : str
        Registered name; `lpcompare.registry.call` fills in this and what follows.
    settings : mapping of str to Any
        Every setting as it was used, calibrated ones among them.
    runtime_s, calibration_s : float or None
        Seconds of the call, and of the search for a setting that gives the count before it.
    note : str
        A word on a result that is not all that was promised.
    rebuild : callable or None
        Makes the object of `as_given`; `lpcompare.simplify` fills it in.

    Examples
    --------
    >>> import numpy as np, lpcompare
    >>> points = np.random.default_rng(0).normal(size=(50, 3))
    >>> result = lpcompare.simplify(points, target_count=5, method="farthest_point")
    >>> bool((result.points == points[result.indices]).all())
    True
    """

    points: Points
    indices: Indices | None = None
    timings: Mapping[str, float] = field(default_factory=dict)
    info: Mapping[str, Any] = field(default_factory=dict)
    method: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    runtime_s: float | None = None
    calibration_s: float | None = None
    note: str = ""
    rebuild: Callable[[Simplification], Any] | None = None

    def __len__(self) -> int:
        return len(self.points)

    def as_given(self) -> Any:
        """The result as an object of the class that `lpcompare.simplify` was given.

        Returns
        -------
        PointCloud, ndarray of shape (m, 3), or an object of another library
            Where points of the input were kept, their attributes follow.

        Examples
        --------
        >>> import numpy as np, lpcompare
        >>> cloud = PointCloud(np.eye(3), attributes={"id": np.array([7, 8, 9])})
        >>> result = lpcompare.simplify(cloud, target_count=2, method="farthest_point")
        >>> len(result.as_given().attributes["id"])
        2
        """
        return self.points if self.rebuild is None else self.rebuild(self)

    def __repr__(self) -> str:
        kind = "new points" if self.indices is None else "points of the input"
        seconds = "" if self.runtime_s is None else f", {self.runtime_s:.3g} s"
        return f"Simplification({self.method or 'method'}: {len(self)} {kind}{seconds})"


@dataclass(frozen=True)
class Traits:
    """What a method needs, loses and promises; every method file states its own as ``TRAITS``.

    The values are literals: they are read from the source without importing the file.

    Attributes
    ----------
    wraps : str
        The library that does the work and its function.
    source : str
        The paper or manual that defines the method.
    licence : str
        Licence of the wrapped library.
    family : str
        Group for tables and pages: "ours", "mesh", "voxel", "random", "spacing", "curvature", "clustering",
        "surface", "graph" or "" where none fits.
    needs_mesh : bool
        The method works on the triangles, not on the points alone.
    moves_points : bool
        The result is not a subset of the input.
    keeps_attributes : bool
        Attributes can follow the points: by index, or because the method carries them.
    exact_count : bool
        The result has exactly the number of points asked for.
    progressive : bool
        The method adds its points one by one: every prefix of its order is a thinning. It says the order as
        ``info["order"]``, the rank of each kept point, shape (m,).
    reading : bool
        The original could not be read; the file implements what other sources say of it.
    own_process : bool
        The wrapped library keeps a random state that nobody can seed: the same seed gives the same points
        only in a fresh process, so that `lpcompare.simplify` starts one.
    repeatable : bool
        The same seed gives the same points; false where a wrapped program draws from a generator that
        cannot be seeded.
    in_tiles : bool
        The method works on clouds larger than memory, tile by tile: `lpcompare.simplify_files`.
    requires : tuple of str
        Importable modules that must be present.
    programs : tuple of str
        Programs that must be on the search path.
    extra : str
        The extra of lpcompare that installs the modules; empty for a default method.
    install : str
        How to get what no extra installs, such as a program.
    """

    wraps: str = "lpcompare"
    source: str = ""
    licence: str = "GPL-3.0-or-later"
    family: str = ""
    needs_mesh: bool = False
    moves_points: bool = False
    keeps_attributes: bool = True
    exact_count: bool = True
    progressive: bool = False
    reading: bool = False
    own_process: bool = False
    repeatable: bool = True
    in_tiles: bool = False
    requires: tuple[str, ...] = ()
    programs: tuple[str, ...] = ()
    extra: str = ""
    install: str = ""

    @property
    def keeps_indices(self) -> bool:
        """Whether the result names the rows of the input that it kept."""
        return not self.moves_points


@dataclass(frozen=True)
class Column:
    """One number that a metric reports.

    Attributes
    ----------
    unit : str
        "% of diagonal", "model units", "degrees", "share" or "".
    better : str
        "lower" or "higher".
    title : str
        One line for tables and legends.
    alias : str
        Where the value follows from another column: that column's name. Ranks and ratios do not count it.
    """

    unit: str
    title: str
    better: str = "lower"
    alias: str = ""
