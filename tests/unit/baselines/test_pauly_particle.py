"""Particle simulation of Pauly, Gross and Kobbelt: even, independent of the input's density, on the surface."""

import numpy as np
import pytest
from scipy.stats import spearmanr

from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.neighbors import Neighbors
from lpcompare_baselines._hoods import normals_and_variation
from lpcompare_baselines.pauly_particle import pauly_particle


def sphere(n, ratio=1, seed=0):
    points = np.random.default_rng(seed).normal(size=(8 * n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    n_upper = n * ratio // (ratio + 1)
    upper, lower = points[points[:, 2] > 0][:n_upper], points[points[:, 2] <= 0][: n - n_upper]
    return np.concatenate([upper, lower])


def spread(points, target, seed=0, **settings):
    return pauly_particle(points, target, rng=np.random.default_rng(seed), **settings).points


def variation_of_spacing(points):
    spacings = Neighbors(points).query(points, 2)[0][:, 1]
    return spacings.std() / spacings.mean()


def test_particles_on_a_sphere_are_evenly_spread():
    points = sphere(10000)
    drawn = points[np.random.default_rng(0).choice(len(points), 1000, replace=False)]
    assert variation_of_spacing(drawn) > 0.4
    assert variation_of_spacing(spread(points, 1000)) < 0.1


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("target", [500, 2000])
def test_the_result_does_not_depend_on_the_density_of_the_input(seed, target):
    kept = spread(sphere(20000, 4, seed), target, seed)
    assert (kept[:, 2] > 0).sum() / (kept[:, 2] <= 0).sum() == pytest.approx(1, rel=0.05)


def test_particles_lie_on_the_surface_that_the_points_are_on():
    points = sphere(10000)
    spacing = np.sqrt(4 * np.pi / len(points))
    kept = spread(points, 800)
    assert np.abs(np.linalg.norm(kept, axis=1) - 1).max() < 0.01 * spacing
    assert Neighbors(points).query(kept, 1)[0].max() < 2 * spacing


def test_particles_do_not_leave_an_open_patch():
    points = np.column_stack([np.random.default_rng(0).uniform(size=(4000, 2)), np.zeros(4000)])
    kept = spread(points, 400)
    assert np.abs(kept[:, 2]).max() < 1e-9
    assert kept[:, :2].min() > -2 / np.sqrt(4000)
    assert kept[:, :2].max() < 1 + 2 / np.sqrt(4000)


def test_adaptive_particles_stand_closer_where_the_surface_is_curved():
    x, y = np.random.default_rng(0).uniform(-1, 1, size=(2, 12000))
    points = np.column_stack([x, y, 0.15 * np.exp(-8 * (x**2 + y**2)) * np.cos(9 * x)])
    variation = normals_and_variation(points, nearest_others(points, 20)[1])[1]
    correlations = []
    for adaptive in (False, True):
        kept = spread(points, 1000, adaptive=adaptive)
        inner = np.abs(kept[:, :2]).max(axis=1) < 0.9
        spacing = Neighbors(kept).query(kept, 7)[0][:, -1]
        beside = Neighbors(points).query(kept, 1)[1][:, 0]
        correlations.append(spearmanr(variation[beside][inner], 1 / spacing[inner]).statistic)
    assert correlations[1] > 0.5
    assert correlations[1] > correlations[0] + 0.3


def test_points_that_all_coincide_stay_where_they_are():
    assert np.array_equal(spread(np.full((9, 3), 4.0), 5), np.full((5, 3), 4.0))
