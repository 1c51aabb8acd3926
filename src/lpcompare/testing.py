"""The contract of a method, as checks that anybody can run on a file of his own."""

from __future__ import annotations

import inspect

import numpy as np

from lpcompare.errors import MethodError, NotApplicable
from lpcompare.registry import METHODS, call
from lpcompare.types import PointCloud, Simplification

N_POINTS, TARGET = 600, 150


def check_method(name: str) -> None:
    """Check that a registered method keeps its promises.

    It is called on a closed triangulated sphere, a cloud without faces, duplicates, a line, one point and
    survey coordinates. Count, subset, finiteness and an unchanged input are verified on each, and the same
    seed has to give the same points.

    Parameters
    ----------
    name : str
        A method of `lpcompare.methods`, from any package.

    Raises
    ------
    MethodError
        A promise is broken; the message says which.
    UnknownName, Unavailable
        There is no such method, or it needs a package that is not installed.

    Examples
    --------
    >>> from lpcompare.testing import check_method
    >>> check_method("random_sample")
    """
    _check_signature(name)
    _check_text(name)
    whole = sphere()
    first = _kept(name, whole, TARGET)
    if first is None:
        raise MethodError(f"{name} declines a closed sphere of {N_POINTS} points with faces.")
    if METHODS.traits(name).repeatable and not METHODS.traits(name).own_process:
        again = _kept(name, whole, TARGET)
        if again is None or not np.array_equal(first.points, again.points):
            raise MethodError(f"{name} gives other points for the same seed.")
    if METHODS.traits(name).progressive:
        _check_order(name, first)
    bare = _kept(name, PointCloud(whole.points, name="bare"), TARGET)
    if METHODS.traits(name).needs_mesh and bare is not None:
        raise MethodError(f"{name} says that it needs a mesh and takes a cloud without faces.")
    for cloud, target in _hard_clouds():
        _kept(name, cloud, target)


def sphere() -> PointCloud:
    """600 points of the unit sphere with normals and outward triangles."""
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(7).normal(size=(N_POINTS, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    a, b, c = (points[faces[:, i]] for i in range(3))
    inward = np.einsum("fi,fi->f", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward][:, ::-1]
    return PointCloud(points, normals=points.copy(), faces=faces.astype(np.intp), name="sphere")


def _check_signature(name: str) -> None:
    function = METHODS.get(name)
    parameters = list(inspect.signature(function).parameters.values())
    if [p.name for p in parameters[:2]] != ["points", "target_count"]:
        raise MethodError(f"{name} must take (points, target_count, *, rng, ...).")
    if "rng" not in {p.name for p in parameters} or any(
        p.kind not in (p.KEYWORD_ONLY, p.VAR_KEYWORD) for p in parameters[2:]
    ):
        raise MethodError(f"{name} must take rng and its settings by keyword only.")


def _check_text(name: str) -> None:
    traits = METHODS.traits(name)
    if not METHODS.summary(name).endswith(".") or not METHODS.get(name).__doc__:
        raise MethodError(f"{name} needs a one-line summary of its file and a docstring of its function.")
    if not traits.wraps or not traits.licence or (traits.requires and not traits.extra):
        raise MethodError(
            f"The traits of {name} must say wraps and licence, and the extra of what it requires."
        )


def _check_order(name: str, result: Simplification) -> None:
    """The order is a rank of every kept point."""
    rank = np.asarray(result.info.get("order"))
    if rank.shape != (len(result),) or set(rank.tolist()) != set(range(len(result))):
        raise MethodError(f"{name} is progressive; info['order'] must be a rank from 0 to m - 1 per point.")


def _kept(name: str, cloud: PointCloud, target: int) -> Simplification | None:
    """The verified result, or None where the method declines."""
    try:
        return call(name, cloud, target, random_state=3)
    except NotApplicable:
        return None


def _hard_clouds() -> list[tuple[PointCloud, int]]:
    rng = np.random.default_rng(5)
    points = rng.normal(size=(200, 3))
    line = np.outer(rng.random(200), [1.0, 2.0, 3.0])
    return [
        (PointCloud(np.repeat(points[:60], 3, axis=0), name="duplicates"), 30),
        (PointCloud(line, name="line"), 20),
        (PointCloud(points * [1, 1, 0], name="plane"), 20),
        (PointCloud(points[:1], name="one point"), 1),
        (PointCloud(points + np.array([5e5, 5.4e6, 100.0]), name="survey coordinates"), 20),
    ]
