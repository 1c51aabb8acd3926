"""Stage 2: curvature against surfaces that have a formula."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from lpcompare.paper.curvature import Curvature, estimate_curvature
from lpcompare.paper.features import feature_mask

N = 6000


def sphere(rng, radius=2.5):
    points = rng.normal(size=(N, 3))
    points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
    return points, np.full(N, 1 / radius), np.full(N, 1 / radius**2)


def cylinder(rng, radius=1.5):
    angle, height = rng.uniform(0, 2 * np.pi, N), rng.uniform(-2, 2, N)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    return points, np.full(N, 0.5 / radius), np.zeros(N)


def torus(rng, major=3.0, minor=1.0):
    u = rng.uniform(0, 2 * np.pi, 4 * N)
    v = rng.uniform(0, 2 * np.pi, 4 * N)
    even = rng.uniform(size=4 * N) < (major + minor * np.cos(v)) / (major + minor)
    u, v = u[even][:N], v[even][:N]
    ring = major + minor * np.cos(v)
    points = np.column_stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)])
    other = np.cos(v) / ring
    return points, (1 / minor + other) / 2, other / minor


def saddle(rng):
    x, y = rng.uniform(-1, 1, (2, N))
    points = np.column_stack([x, y, (x**2 - y**2) / 2])
    steep = 1 + x**2 + y**2
    return points, (y**2 - x**2) / 2 / steep**1.5, -1 / steep**2


@pytest.mark.parametrize("surface", [sphere, cylinder, torus, saddle])
def test_absolute_curvature_is_within_five_percent_of_the_formula(surface):
    points, mean, gaussian = surface(np.random.default_rng(1))
    exact = Curvature(mean, gaussian).absolute
    found = estimate_curvature(points).absolute
    assert np.median(np.abs(found - exact) / exact) < 0.05


def curvature_by_lapack(points, point, hood):
    """H and K at a point of the least-squares quadric through its neighbours (k, 3)."""
    offsets = hood - point
    normal = np.linalg.eigh(np.cov(hood.T))[1][:, 0]
    frame = np.linalg.qr(np.column_stack([normal, np.eye(3)]))[0][:, :3]
    w, u, v = (offsets @ frame).T
    basis = np.column_stack([np.ones_like(u), u, v, u * u / 2, u * v, v * v / 2])
    _, p, q, r, s, t = np.linalg.lstsq(basis, w, rcond=None)[0]
    steep = 1 + p * p + q * q
    mean = ((1 + q * q) * r - 2 * p * q * s + (1 + p * p) * t) / (2 * steep**1.5)
    return mean, (r * t - s * s) / steep**2


def test_the_kernel_agrees_with_lapack():
    points = torus(np.random.default_rng(3))[0]
    found, nearest = estimate_curvature(points), KDTree(points).query(points, 20)[1]
    for row in range(0, len(points), 100):
        mean, gaussian = curvature_by_lapack(points, points[row], points[nearest[row]])
        assert abs(found.mean[row]) == pytest.approx(abs(mean), rel=1e-5, abs=1e-6)
        assert found.gaussian[row] == pytest.approx(gaussian, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("surface", [sphere, cylinder, torus, saddle])
def test_mean_and_gaussian_curvature_are_near_the_formula(surface):
    points, mean, gaussian = surface(np.random.default_rng(1))
    scale = Curvature(mean, gaussian).absolute
    found = estimate_curvature(points)
    assert np.median(np.abs(np.abs(found.mean) - np.abs(mean)) / scale) < 0.05
    assert np.median(np.abs(found.gaussian - gaussian) / scale**2) < 0.05


def test_open_borders_do_not_explode():
    points, mean, gaussian = saddle(np.random.default_rng(2))
    border = np.abs(points[:, :2]).max(axis=1) > 0.97
    found, exact = estimate_curvature(points).absolute[border], Curvature(mean, gaussian).absolute[border]
    assert np.median(np.abs(found - exact) / exact) < 0.2
    assert found.max() < 10 * exact.max()


def test_absolute_curvature_is_the_sum_of_the_principal_ones():
    k1, k2 = np.random.default_rng(0).normal(size=(2, 100))
    assert Curvature((k1 + k2) / 2, k1 * k2).absolute == pytest.approx(np.abs(k1) + np.abs(k2))


def test_a_plane_has_no_curvature_and_no_features():
    points = np.random.default_rng(0).uniform(size=(500, 3)) * [1, 1, 0]
    absolute = estimate_curvature(points).absolute
    assert absolute.max() < 1e-9
    assert not feature_mask(absolute, np.zeros(500, dtype=int)).any()


@pytest.mark.parametrize("n_points", [1, 2, 3, 4, 5, 6, 7])
def test_few_points_have_finite_curvature(n_points):
    points = np.random.default_rng(n_points).normal(size=(n_points, 3))
    found = estimate_curvature(points)
    assert np.isfinite(found.mean).all()
    assert np.isfinite(found.gaussian).all()


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((40, 3)),
        np.repeat(np.random.default_rng(0).normal(size=(10, 3)), 25, axis=0),
        np.outer(np.linspace(0, 1, 60), [1, -2, 3]),
        np.vstack([np.zeros((19, 3)), np.random.default_rng(0).normal(size=(5, 3))]),
    ],
    ids=["all equal", "25 of each", "line", "19 equal of 24"],
)
def test_coincident_and_collinear_neighbours_have_finite_curvature(points):
    found = estimate_curvature(points)
    assert np.isfinite(found.absolute).all()
    assert np.isfinite(found.gaussian).all()


def test_curvature_scales_and_turns_with_the_cloud():
    points = torus(np.random.default_rng(4))[0]
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    still, turned = estimate_curvature(points), estimate_curvature(points @ turn.T)
    assert np.allclose(turned.absolute, still.absolute, rtol=1e-7)
    assert np.array_equal(estimate_curvature(4 * points).absolute * 4, still.absolute)


def test_one_thread_and_two_give_the_same_curvature(monkeypatch):
    points = torus(np.random.default_rng(4))[0]
    found = []
    for threads in ("1", "2"):
        monkeypatch.setenv("LPCOMPARE_THREADS", threads)
        found.append(estimate_curvature(points).mean)
    assert np.array_equal(*found)


def test_features_exceed_the_mean_of_their_own_cluster():
    curvature = np.array([1.0, 2.0, 3.0, 10.0, 20.0, 30.0, 5.0])
    labels = np.array([0, 0, 0, 2, 2, 2, 3])
    assert feature_mask(curvature, labels).tolist() == [False, False, True, False, False, True, False]
