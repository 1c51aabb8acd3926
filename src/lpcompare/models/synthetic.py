"""Shapes whose surface is known exactly: the same points every time, with normals and triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.types import PointCloud

_SEED = 20170405


def sphere(n_points: int = 10_000) -> PointCloud:
    """Unit sphere on a Fibonacci lattice, evenly covered; its triangles are the convex hull's."""
    from scipy.spatial import ConvexHull

    turn = np.pi * (1 + np.sqrt(5)) * np.arange(n_points)
    height = 1 - (2 * np.arange(n_points) + 1) / n_points
    radius = np.sqrt(1 - height**2)
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    faces = ConvexHull(points).simplices.astype(np.intp)
    a, b, c = (points[faces[:, i]] for i in range(3))
    inward = np.einsum("fi,fi->f", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward][:, ::-1]
    return PointCloud(points, normals=points.copy(), faces=faces, name="sphere")


def torus(n_around: int = 200, n_across: int = 60) -> PointCloud:
    """Torus around z, radii 1 and 0.4, on a jittered grid of angles."""
    rng = np.random.default_rng(_SEED)
    around, across = np.meshgrid(np.arange(n_around), np.arange(n_across), indexing="ij")
    u = 2 * np.pi * (around.ravel() + rng.uniform(-0.3, 0.3, around.size)) / n_around
    v = 2 * np.pi * (across.ravel() + rng.uniform(-0.3, 0.3, across.size)) / n_across
    normals = np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)])
    center = np.column_stack([np.cos(u), np.sin(u), np.zeros_like(u)])
    rows = np.arange(n_around * n_across).reshape(n_around, n_across)
    closed = np.pad(rows, ((0, 1), (0, 1)), mode="wrap")
    return PointCloud(center + 0.4 * normals, normals=normals, faces=_grid_faces(closed), name="torus")


def cube(n_side: int = 41) -> PointCloud:
    """Cube of side 1 around the origin, a grid on each side; neighbours share edges and corners."""
    steps = np.linspace(-0.5, 0.5, n_side)
    first, second = np.meshgrid(steps, steps, indexing="ij")
    corners, faces = [], []
    for axis in range(3):
        for sign in (-0.5, 0.5):
            side = np.empty((n_side**2, 3))
            side[:, axis], side[:, axis - 2], side[:, axis - 1] = sign, first.ravel(), second.ravel()
            rows = np.arange(n_side**2).reshape(n_side, n_side) + len(corners) * n_side**2
            faces.append(_grid_faces(rows if sign > 0 else rows.T))
            corners.append(side)
    points, row_of = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    outside = np.where(np.abs(points) == 0.5, np.sign(points), 0.0)
    normals = outside / np.linalg.norm(outside, axis=1, keepdims=True)
    return PointCloud(points, normals, faces=row_of.ravel()[np.concatenate(faces)], name="cube")


def noisy_plane(n_side: int = 100) -> PointCloud:
    """Unit square in z = 0 on a jittered grid, Gaussian height noise of 0.2 % of its side."""
    rng = np.random.default_rng(_SEED)
    first, second = np.meshgrid(np.arange(n_side), np.arange(n_side), indexing="ij")
    flat = np.column_stack([first.ravel(), second.ravel()]) + rng.uniform(-0.3, 0.3, (n_side**2, 2))
    points = np.column_stack([flat / (n_side - 1), 0.002 * rng.standard_normal(n_side**2)])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    faces = _grid_faces(np.arange(n_side**2).reshape(n_side, n_side))
    return PointCloud(points, normals=normals, faces=faces, name="noisy-plane")


def _grid_faces(rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Two triangles for each square of a grid of row numbers, turned from the first axis to the second."""
    a, b, c, d = (s.ravel() for s in (rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]))
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
