"""Planes, lines and points through small neighbourhoods: by hand, and against LAPACK's eigenvectors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.geometry.kernels import least_direction, tangents
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import fit_planes, plane_distances

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


def fit_by_lapack(hoods):
    """Centroids and least eigenvectors of neighbourhoods (q, k, 3)."""
    centroids = hoods.mean(axis=1)
    centred = hoods - centroids[:, None]
    return centroids, np.linalg.eigh(np.einsum("qki,qkj->qij", centred, centred))[1][:, :, 0]


@pytest.mark.parametrize("spreads", [(1, 1, 1), (1, 0.7, 1e-6), (1, 1e-3, 1e-9), (1, 0, 0), (0, 0, 0)])
def test_least_direction_has_the_least_variance(spreads):
    rng = np.random.default_rng(0)
    for _ in range(200):
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        offsets = rng.normal(size=(9, 3)) * spreads @ axes
        matrix = offsets.T @ offsets
        xx, yy, zz = np.diag(matrix)
        direction = np.array(least_direction(xx, yy, zz, matrix[0, 1], matrix[0, 2], matrix[1, 2]))
        assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-14)
        least, _, largest = np.linalg.eigvalsh(matrix)
        assert direction @ matrix @ direction - least <= 1e-14 * largest


@pytest.mark.parametrize("matrix", [np.eye(3), np.zeros((3, 3)), np.diag([2.0, 1, 1]), np.ones((3, 3))])
def test_least_direction_is_a_unit_vector_where_several_would_do(matrix):
    xx, yy, zz = np.diag(matrix)
    direction = np.array(least_direction(xx, yy, zz, matrix[0, 1], matrix[0, 2], matrix[1, 2]))
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    assert direction @ matrix @ direction == pytest.approx(np.linalg.eigvalsh(matrix)[0])


@given(seed=st.integers(0, 2**32 - 1))
def test_tangents_make_a_right_handed_frame(seed):
    normal = np.random.default_rng(seed).normal(size=3)
    normal /= np.linalg.norm(normal)
    frame = np.array([*tangents(*normal), *normal]).reshape(3, 3)
    assert frame @ frame.T == pytest.approx(np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1.0)


@given(seed=st.integers(0, 2**32 - 1), flatness=st.sampled_from([1.0, 1e-2, 1e-4]))
@settings(max_examples=30, deadline=None)
def test_planes_agree_with_lapack(seed, flatness):
    points = np.random.default_rng(seed).normal(size=(200, 3)) * [1.0, 0.7, flatness]
    indices = Neighbors(points).query(points, 8)[1]
    centroids, normals = fit_planes(points, indices)
    middles, directions = fit_by_lapack(points[indices])
    assert centroids == pytest.approx(middles)
    ours, theirs = (
        np.einsum("qki,qi->q", points[indices] - middles[:, None], n) for n in (normals, directions)
    )
    assert np.abs(ours) == pytest.approx(np.abs(theirs), abs=1e-12)


@given(seed=st.integers(0, 2**32 - 1), flatness=st.sampled_from([1.0, 1e-2, 1e-4]))
@settings(max_examples=30, deadline=None)
def test_distances_averaged_over_sizes_agree_with_lapack(seed, flatness):
    points = np.random.default_rng(seed).normal(size=(200, 3)) * [1.0, 0.7, flatness]
    kept = points[::4]
    indices = Neighbors(kept).query(points, 12)[1]
    expected = []
    for size in (6, 8, 12):
        centroids, normals = fit_by_lapack(kept[indices[:, :size]])
        expected.append(np.abs(np.einsum("qi,qi->q", points - centroids, normals)))
    # a nearly isotropic neighbourhood has no stable plane: the typical original must agree, not each
    ours = plane_distances(points, kept, indices, (6, 8, 12))
    assert np.median(np.abs(ours - np.mean(expected, axis=0))) < 1e-9
    assert ours.mean() == pytest.approx(np.mean(expected), rel=1e-3)


def test_plane_of_a_square_is_its_plane():
    centroids, normals = fit_planes(CORNERS, np.arange(4)[None])
    assert centroids == pytest.approx(np.array([[0.5, 0.5, 0]]))
    assert np.abs(normals) == pytest.approx(np.array([[0, 0, 1.0]]))


def test_plane_at_a_known_height():
    grid = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0), [0.0]), axis=-1).reshape(-1, 3)
    above = np.add(grid[44:46], [0.1, 0.1, 0.25])
    nearest = Neighbors(grid).query(above, 12)[1]
    assert plane_distances(above, grid, nearest, (6, 8, 12)) == pytest.approx([0.25, 0.25])


@pytest.mark.parametrize(("k", "expected"), [(1, np.sqrt(14)), (2, np.sqrt(13)), (3, 3.0), (4, 3.0)])
def test_distance_to_a_point_a_line_and_a_plane(k, expected):
    query = np.array([[1.0, 2.0, 3.0]])
    assert plane_distances(query, CORNERS, np.arange(k)[None]) == pytest.approx([expected])


def test_two_coincident_neighbours_are_one_point():
    points = np.zeros((2, 3))
    assert plane_distances(np.array([[0.0, 3, 4]]), points, np.array([[0, 1]])) == pytest.approx([5.0])
