"""Planes found, their rims kept, their insides thinned."""

import numpy as np

from lpcompare.geometry.graphs import nearest_others
from lpcompare.registry import METHODS
from lpcompare_baselines._hoods import normals_and_variation
from lpcompare_baselines.whelan_planes import segments


def segments_of(points, angle=10.0):
    _, neighbors = nearest_others(points, 16)
    return segments(neighbors, *normals_and_variation(points, neighbors), angle, 0.05)


def thin(points, m):
    return METHODS.get("whelan_planes")(points, m, rng=np.random.default_rng(0))


def cube(n=30):
    """Six faces of n x n points, jittered within each face, no point on an edge."""
    rng, faces = np.random.default_rng(0), []
    grid = (np.stack(np.meshgrid(np.arange(n), np.arange(n)), axis=-1).reshape(-1, 2) + 0.5) / n
    for axis in range(3):
        for side in (0.0, 1.0):
            face = np.insert(grid + rng.uniform(-0.3, 0.3, grid.shape) / n, axis, side, axis=1)
            faces.append(face)
    return np.vstack(faces)


def test_a_cube_has_six_planes():
    points = cube()
    segment = segments_of(points)
    large = np.flatnonzero(np.bincount(segment) > 300)
    assert len(large) == 6
    face = np.arange(len(points)) // 900
    assert all(len(np.unique(face[segment == s])) == 1 for s in large)


def test_most_inner_points_of_a_cube_go_before_those_of_its_edges():
    points = cube()
    to_edge = np.sort(np.minimum(points, 1 - points), axis=1)[:, 1]
    kept = thin(points, 900).indices
    inner, edge = to_edge > 4 / 30, to_edge < 2 / 30
    share_inner = np.isin(np.flatnonzero(inner), kept).mean()
    share_edge = np.isin(np.flatnonzero(edge), kept).mean()
    assert share_inner <= 0.05
    assert share_edge > 8 * share_inner


def test_the_concave_corner_of_a_plane_stays():
    grid = np.stack(np.meshgrid(np.arange(40), np.arange(40)), axis=-1).reshape(-1, 2).astype(float)
    flat = grid[(grid[:, 0] < 20) | (grid[:, 1] < 20)]
    flat = flat + np.random.default_rng(1).uniform(-0.2, 0.2, flat.shape)
    kept = thin(np.column_stack([flat, np.zeros(len(flat))]), 240).points
    corner_sides = flat[(np.abs(flat - 19).min(axis=1) < 0.5) & (flat.max(axis=1) > 20)]
    near = np.linalg.norm(kept[:, None, :2] - corner_sides, axis=2).min(axis=0)
    assert (near < 1.5).mean() > 0.9


def test_no_segment_creeps_round_a_cylinder():
    rng = np.random.default_rng(2)
    angle = rng.random(8000) * 2 * np.pi
    points = np.column_stack([np.cos(angle), np.sin(angle), rng.random(8000) * 2])
    segment = segments_of(points)
    for s in np.flatnonzero(np.bincount(segment) > 20):
        mean = np.angle(np.exp(1j * angle[segment == s]).mean())
        spread = np.abs(np.angle(np.exp(1j * (angle[segment == s] - mean)))).max()
        assert spread < np.radians(4 * 10)


def test_the_inside_of_a_noisy_plane_is_thinned_by_more_than_nine_tenths():
    """Half plane, half rough: the plane's inside loses the points that the rough half keeps."""
    rng = np.random.default_rng(3)
    flat = rng.random((8000, 2)) * [2, 1]
    height = np.where(flat[:, 0] < 1, 0.002, 0.1) * rng.normal(size=8000)
    kept = thin(np.column_stack([flat, height]), 800).indices
    inside = (flat[:, 0] < 0.9) & (flat[:, 0] > 0.1) & (flat[:, 1] > 0.1) & (flat[:, 1] < 0.9)
    assert np.isin(np.flatnonzero(inside), kept).mean() < 0.1
