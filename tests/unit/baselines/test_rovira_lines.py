"""Uniformly distributed lines: equal areas give equal counts, whatever the density of the input."""

import numpy as np
from scipy.stats import chi2, qmc

from lpcompare.registry import METHODS


def thin(points, m, seed=0, **settings):
    return METHODS.get("rovira_lines")(points, m, rng=np.random.default_rng(seed), **settings).indices


def sphere(n, seed=0):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def chi_square(counts):
    expected = counts.sum() / len(counts)
    return ((counts - expected) ** 2 / expected).sum()


def test_equal_patches_of_a_sphere_get_equal_counts():
    points = sphere(8000)
    kept = points[thin(points, 800)]
    band = np.minimum(((kept[:, 2] + 1) * 4).astype(int), 7)
    sector = ((np.arctan2(kept[:, 1], kept[:, 0]) / np.pi + 1) * 2).astype(int) % 4
    assert chi_square(np.bincount(band * 4 + sector, minlength=32)) < chi2.ppf(0.99, 31)


def test_the_six_faces_of_a_cube_get_equal_counts():
    rng = np.random.default_rng(1)
    faces = []
    for axis in range(3):
        for side in (0.0, 1.0):
            face = rng.random((1500, 3))
            face[:, axis] = side
            faces.append(face)
    kept = thin(np.vstack(faces), 900)
    assert chi_square(np.bincount(kept // 1500, minlength=6)) < chi2.ppf(0.99, 5)


def test_counts_do_not_follow_the_density_of_the_input():
    points = sphere(16000, seed=2)
    rng = np.random.default_rng(3)
    points = points[(points[:, 2] > 0) | (rng.random(len(points)) < 0.25)]
    kept, drawn = points[thin(points, 600)], points[rng.choice(len(points), 600, replace=False)]
    assert 0.85 < (kept[:, 2] > 0).sum() / (kept[:, 2] < 0).sum() < 1.18
    assert (drawn[:, 2] > 0).sum() / (drawn[:, 2] < 0).sum() > 3


def test_discrepancy_on_a_square_is_below_random():
    flat = np.random.default_rng(4).random((20000, 2))
    points = np.column_stack([flat, np.zeros(len(flat))])
    lines = np.mean([qmc.discrepancy(flat[thin(points, 400, seed)], method="L2-star") for seed in range(5)])
    rng = np.random.default_rng(5)
    drawn = np.mean([qmc.discrepancy(flat[rng.choice(20000, 400)], method="L2-star") for _ in range(5)])
    assert lines < drawn


def test_two_thin_sheets_are_two_crossings():
    flat = np.random.default_rng(6).random((3000, 2))
    points = np.vstack([np.column_stack([flat, np.full(3000, z)]) for z in (0.0, 0.5)])
    kept = thin(points, 600)
    assert 250 < (kept < 3000).sum() < 350
