"""Generated shapes lie on their surfaces; their triangles face outwards."""

import numpy as np
import pytest

from lpcompare.models import load_model


def area_and_volume(cloud):
    a, b, c = (cloud.points[cloud.faces[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    return np.linalg.norm(cross, axis=1).sum() / 2, np.einsum("fi,fi->", a, cross) / 6


def test_sphere_has_radius_one():
    cloud = load_model("sphere")
    assert np.allclose(np.linalg.norm(cloud.points, axis=1), 1, rtol=0, atol=1e-12)
    assert area_and_volume(cloud) == pytest.approx((4 * np.pi, 4 * np.pi / 3), rel=2e-3)


def test_torus_has_its_two_radii():
    cloud = load_model("torus")
    ring = np.hypot(cloud.points[:, 0], cloud.points[:, 1]) - 1
    assert np.allclose(np.hypot(ring, cloud.points[:, 2]), 0.4, rtol=0, atol=1e-12)
    assert area_and_volume(cloud) == pytest.approx((1.6 * np.pi**2, 0.32 * np.pi**2), rel=1e-2)


def test_cube_has_sharp_edges_and_shares_them():
    cloud = load_model("cube")
    on_sides = (np.abs(cloud.points) == 0.5).sum(axis=1)
    assert [(on_sides == k).sum() for k in (1, 2, 3)] == [6 * 39**2, 12 * 39, 8]
    assert area_and_volume(cloud) == pytest.approx((6, 1))


def test_noisy_plane_is_flat_to_its_noise():
    cloud = load_model("noisy-plane")
    assert cloud.points[:, 2].std() == pytest.approx(0.002, rel=0.05)


@pytest.mark.parametrize("name", ["sphere", "torus", "cube", "noisy-plane"])
def test_normals_are_unit_and_agree_with_the_triangles(name):
    cloud = load_model(name)
    assert np.allclose(np.linalg.norm(cloud.normals, axis=1), 1)
    a, b, c = (cloud.points[cloud.faces[:, i]] for i in range(3))
    facing = np.einsum("fi,fi->f", np.cross(b - a, c - a), cloud.normals[cloud.faces].mean(axis=1))
    assert (facing > 0).all()
