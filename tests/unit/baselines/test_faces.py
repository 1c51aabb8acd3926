"""The mesh guard, the face count that leaves n points, and rows found by position."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lpcompare.errors import InputError, NotApplicable
from lpcompare.types import PointCloud
from lpcompare_baselines._faces import faces_of, rows_at, search_n_faces

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def test_a_cloud_without_faces_is_declined():
    for cloud in (None, PointCloud(SQUARE), PointCloud(SQUARE, faces=np.empty((0, 3), int))):
        with pytest.raises(NotApplicable, match="no faces"):
            faces_of(cloud, 2)


def test_a_count_beyond_the_points_that_faces_use_is_declined():
    assert np.array_equal(faces_of(PointCloud(SQUARE, faces=FACES), 4), FACES)
    with pytest.raises(NotApplicable, match="only 4 of the 5"):
        faces_of(PointCloud(SQUARE, faces=FACES), 5)


def test_a_face_that_names_no_point_is_an_error():
    with pytest.raises(InputError, match="0 to 9"):
        faces_of(PointCloud(SQUARE, faces=np.array([[0, 1, 9]])), 2)


@given(st.integers(4, 500), st.integers(-40, 200), st.integers(500, 900))
def test_the_excess_points_correct_the_faces(target, border, n_points):
    assume(target > abs(border))

    def count(n_faces):
        return max((n_faces + border) // 2 + 2, 3)

    faces = np.resize(np.arange(n_points), (2000, 3))
    n_faces = search_n_faces(count, target, faces)
    assert count(n_faces) == target


@given(st.integers(4, 500))
def test_on_a_closed_mesh_one_collapse_finds_the_face_count(target):
    asked = []

    def count(n_faces):
        asked.append(n_faces)
        return n_faces // 2 + 2

    faces = np.resize(np.arange(600), (2 * 600 - 4, 3))
    assert asked == [search_n_faces(count, target, faces)]
    assert count(asked[0]) == target


def test_rows_are_found_by_position_each_duplicate_once():
    points = np.array([[1.0, 0, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 0]])
    assert rows_at(points, points[[3, 0, 1]]).tolist() == [0, 1, 3]
    assert rows_at(points, points[[1, 4, 2]]).tolist() == [0, 1, 4]
    assert rows_at(points, np.array([[0.0, 0, 0], [-0.0, 0, 0]])).tolist() == [1, 4]
