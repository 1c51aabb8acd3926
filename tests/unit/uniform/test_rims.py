"""Rims are found where a surface ends, and nowhere else."""

import numpy as np
import pytest

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import estimate_surface
from lpcompare.uniform.rims import find_rims


def rims_of(points, n_keep):
    tree = Neighbors(points)
    return tree.sorted_points, find_rims(tree.sorted_points, estimate_surface(tree), n_keep)


@pytest.mark.parametrize("n_keep", [60, 300])
def test_the_rim_of_a_disc_points_outwards(n_keep):
    rng = np.random.default_rng(0)
    radius, angle = np.sqrt(rng.random(4000)), rng.uniform(0, 2 * np.pi, 4000)
    points, rims = rims_of(
        np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle]), n_keep
    )
    found = points[rims.rows]
    spacing = np.sqrt(np.pi / n_keep)
    assert len(rims.rows) > 0.3 * 2 * np.pi / spacing
    assert np.quantile(np.linalg.norm(found, axis=1), 0.2) > 1 - 1.5 * spacing
    outwards = np.einsum("ri,ri->r", found / np.linalg.norm(found, axis=1)[:, None], rims.directions)
    assert np.quantile(outwards, 0.2) > 0.5
    assert np.median(outwards) > 0.9


def test_a_closed_surface_has_few_rims():
    sphere = np.random.default_rng(0).normal(size=(5000, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    assert len(rims_of(sphere, 500)[1].rows) < 0.03 * 5000


def test_points_at_one_place_have_no_rim():
    assert not len(rims_of(np.zeros((30, 3)), 5)[1].rows)
