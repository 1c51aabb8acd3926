"""Tangent-plane quadrics on shapes whose planes are known."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import Surface, estimate_surface
from lpcompare.uniform.quadrics import cheapest_of_each, tangent_quadrics
from lpcompare.uniform.rims import Rims

NO_RIMS = Rims(np.empty(0, dtype=np.intp), np.empty((0, 3)), np.empty(0))


def two_planes():
    """A right angle: z = 0 for x < 0 and x = 0 for z > 0, with the edge along y."""
    t, y = np.random.default_rng(0).random((2, 400))
    flat = np.column_stack([-t, y, np.zeros(400)])
    upright = np.column_stack([np.zeros(400), y, t])
    normals = np.repeat([[0.0, 0, 1], [1.0, 0, 0]], 400, axis=0)
    return np.concatenate([flat, upright]), Surface(normals, np.ones(800), np.zeros((800, 2)))


def test_the_minimum_lies_on_the_edge():
    points, surface = two_planes()
    quadrics = tangent_quadrics(points, surface, NO_RIMS, np.array([[-0.1, 0.5, 0.05]]))
    minimum = quadrics.minima(1e-9)[0]
    assert minimum == pytest.approx([0.0, 0.5, 0.0], abs=1e-6)


def test_cost_is_the_squared_distance_to_every_plane():
    points, surface = two_planes()
    site = np.array([[0.0, 0.5, 0.0]])
    costs = tangent_quadrics(points, surface, NO_RIMS, site).costs(points, 0.0)
    assert costs == pytest.approx(400 * points[:, 0] ** 2 + 400 * points[:, 2] ** 2)


def test_spread_adds_the_squared_distance_to_the_site():
    points, surface = two_planes()
    site = np.array([[0.0, 0.5, 0.0]])
    quadrics = tangent_quadrics(points, surface, NO_RIMS, site)
    added = quadrics.costs(points, 0.1) - quadrics.costs(points, 0.0)
    assert added == pytest.approx(0.1 * 800 * np.sum((points - site) ** 2, axis=1))


def test_a_rim_draws_the_minimum_out_to_it():
    """One cell of a plane that ends at x = 1: the planes leave x open, the rim settles it."""
    x, y = np.random.default_rng(0).random((2, 400))
    points = np.column_stack([x, y, np.zeros(400)])
    surface = Surface(np.tile([0.0, 0, 1], (400, 1)), np.ones(400), np.zeros((400, 2)))
    rows = np.flatnonzero(x > 0.97)
    rims = Rims(rows, np.tile([1.0, 0, 0], (len(rows), 1)), np.ones(len(rows)))
    minimum = tangent_quadrics(points, surface, rims, np.array([[0.5, 0.5, 0.0]])).minima(1e-9)[0]
    assert minimum == pytest.approx([x[rows].mean(), 0.5, 0.0], abs=1e-3)


def test_normals_of_a_plane():
    plane = np.random.default_rng(0).random((300, 3)) * [1, 1, 0]
    tree = Neighbors(plane)
    surface = estimate_surface(tree)
    assert np.abs(surface.normals[:, 2]) == pytest.approx(np.ones(300))
    distances = KDTree(tree.sorted_points).query(tree.sorted_points, 9)[0]
    assert surface.areas == pytest.approx(distances[:, 8] ** 2)
    assert surface.curvatures == pytest.approx(np.zeros((300, 2)), abs=1e-6)


def test_coinciding_points_do_not_move():
    same = np.ones((20, 3))
    quadrics = tangent_quadrics(same, estimate_surface(Neighbors(same)), NO_RIMS, same[:2])
    assert quadrics.minima(0.1) == pytest.approx(same[:2])


def test_the_cheapest_of_each_cell_is_the_first_among_equals():
    costs, cells = np.array([3.0, 1.0, 1.0, 2.0]), np.array([0, 2, 2, 0])
    assert cheapest_of_each(costs, cells, 4).tolist() == [3, -1, 1, -1]
