"""Planes, lines and points through small neighbourhoods, by hand."""

import numpy as np
import pytest

from lpcompare.geometry.planes import fit_planes, plane_distances

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


def test_plane_of_a_square_is_its_plane():
    centroids, normals = fit_planes(CORNERS[None])
    assert centroids == pytest.approx(np.array([[0.5, 0.5, 0]]))
    assert np.abs(normals) == pytest.approx(np.array([[0, 0, 1.0]]))


@pytest.mark.parametrize(("k", "expected"), [(1, np.sqrt(14)), (2, np.sqrt(13)), (3, 3.0), (4, 3.0)])
def test_distance_to_a_point_a_line_and_a_plane(k, expected):
    query = np.array([[1.0, 2.0, 3.0]])
    assert plane_distances(query, CORNERS, np.arange(k)[None]) == pytest.approx([expected])


def test_two_coincident_neighbours_are_one_point():
    points = np.zeros((2, 3))
    assert plane_distances(np.array([[0.0, 3, 4]]), points, np.array([[0, 1]])) == pytest.approx([5.0])
