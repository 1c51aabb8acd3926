"""Pictures of clouds and surfaces: where points land, which triangles are found, what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_runs import dented_sphere
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lpcompare.errors import InputError
from lpcompare.report.projections import draw_cloud, draw_mesh, local_normals, project, triangulate


@given(st.floats(-180, 180), st.floats(-80, 80), st.sampled_from(["y", "z"]))
def test_a_projection_keeps_lengths(right, above, up):
    points = dented_sphere(20)
    places, depth = project(points, (right, above), up)
    picture = np.c_[places, depth]
    before = np.linalg.norm(points[0] - points, axis=1)
    assert np.allclose(np.linalg.norm(picture[0] - picture, axis=1), before)


@pytest.mark.parametrize(("up", "high"), [("y", [0, 5, 0]), ("z", [0, 0, 5])])
def test_what_is_up_is_above_and_what_is_in_front_is_near(up, high):
    front = [0, 0, 1] if up == "y" else [0, -1, 0]
    places, depth = project(np.array([[0, 0, 0], high, front], float), (0, 0), up)
    assert places[1, 1] > places[0, 1]
    assert depth[2] > depth[0]


def test_from_above_the_near_side_of_the_top_is_seen():
    points = np.array([[0, 0, 0], [0, 1, 0]], float)
    assert project(points, (0, 60))[1][1] > project(points, (0, 60))[1][0]


def test_normals_of_a_sphere_point_outward_or_inward():
    points = np.random.default_rng(0).normal(size=(2000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    assert np.median(np.abs(np.einsum("ni,ni->n", local_normals(points), points))) > 0.99


def test_triangles_through_a_sphere_close_most_of_it():
    indices = np.arange(1200) + 0.5
    height, turn = 1 - 2 * indices / 1200, np.pi * (1 + 5**0.5) * indices
    radius = np.sqrt(1 - height**2)
    points = np.c_[radius * np.cos(turn), radius * np.sin(turn), height]
    faces = triangulate(points)
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(4 * np.pi, rel=0.03)


@pytest.mark.parametrize(
    "points", [np.zeros((5, 3)), np.c_[np.arange(9.0), np.zeros((9, 2))], np.repeat(np.eye(3), 2, axis=0)]
)
def test_points_that_carry_no_surface_give_few_triangles_or_none(points):
    assert len(triangulate(points)) <= 2


@pytest.fixture
def axes():
    return Figure().subplots()


def drawn(axes):
    """The number of different colours after the picture is rendered."""
    canvas = FigureCanvasAgg(axes.figure)
    canvas.draw()
    return len(np.unique(np.asarray(canvas.buffer_rgba()).reshape(-1, 4), axis=0))


@pytest.mark.parametrize("colouring", ["values", "labels", "mask", None])
def test_every_colouring_is_drawn(axes, colouring):
    points = dented_sphere(300)
    chosen = {"values": points[:, 0], "labels": np.arange(300) % 13, "mask": points[:, 0] > 0}
    draw_cloud(axes, points, **({colouring: chosen[colouring]} if colouring else {}), size=30)
    assert drawn(axes) > 10


@pytest.mark.parametrize("wireframe", [False, True])
def test_a_mesh_is_drawn(axes, wireframe):
    points = dented_sphere(300)
    draw_mesh(axes, points, triangulate(points), wireframe=wireframe)
    assert drawn(axes) > 10


@pytest.mark.parametrize(
    "points", [np.zeros((1, 3)), np.zeros((4, 3)), np.c_[np.arange(5.0), np.zeros((5, 2))]]
)
def test_clouds_without_extent_are_drawn(axes, points):
    draw_cloud(axes, points, np.zeros(len(points)))
    drawn(axes)


def test_what_cannot_be_drawn_is_refused(axes):
    points = dented_sphere(30)
    with pytest.raises(InputError, match="one colour"):
        draw_cloud(axes, points, points[:, 0], mask=points[:, 0] > 0)
    with pytest.raises(InputError, match="30 points"):
        draw_cloud(axes, points, points[:9, 0])
    with pytest.raises(InputError, match="'x'"):
        draw_cloud(axes, points, up="x")
    with pytest.raises(InputError, match="at least 3"):
        triangulate(points[:2])
