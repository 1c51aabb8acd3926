"""The closed form of the plane distances against the eigenvalue routine that judges."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.geometry.fits import mean_plane_distances
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import plane_distances


def both(queries, points, sizes):
    nearest = Neighbors(points).query(queries, max(sizes))[1]
    expected = np.mean([plane_distances(queries, points, nearest[:, :k]) for k in sizes], axis=0)
    return mean_plane_distances(queries, points, nearest, sizes), expected


@given(seed=st.integers(0, 2**32 - 1), flatness=st.sampled_from([1.0, 1e-2, 1e-4]))
@settings(max_examples=30, deadline=None)
def test_agrees_with_the_eigenvalue_routine(seed, flatness):
    points = np.random.default_rng(seed).normal(size=(200, 3)) * [1.0, 0.7, flatness]
    closed, expected = both(points, points[::4], (6, 8, 12))
    # a nearly isotropic neighbourhood has no stable plane: the typical original must agree, not each
    assert np.median(np.abs(closed - expected)) < 1e-9
    assert closed.mean() == pytest.approx(expected.mean(), rel=1e-3)


def test_plane_at_a_known_height():
    grid = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0), [0.0]), axis=-1).reshape(-1, 3)
    above = np.add(grid[44:46], [0.1, 0.1, 0.25])
    nearest = Neighbors(grid).query(above, 12)[1]
    assert mean_plane_distances(above, grid, nearest, (6, 8, 12)) == pytest.approx([0.25, 0.25])


@pytest.mark.parametrize("points", [np.ones((20, 3)), np.arange(20.0)[:, None] * [1.0, 2.0, 3.0]])
def test_undecided_planes_are_left_to_the_eigenvalue_routine(points):
    queries = np.add(points[:3], [0.0, 0.0, 0.5])
    closed, expected = both(queries, points, (6, 8))
    assert closed == pytest.approx(expected)
