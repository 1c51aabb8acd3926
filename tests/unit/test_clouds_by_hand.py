"""Clouds that a caller puts together: what fits works at every door, what does not is one sentence."""

import numpy as np
import pytest

import lpcompare
from lpcompare.errors import InputError
from lpcompare.types import PointCloud

POINTS = np.random.default_rng(0).normal(size=(60, 3))
SUFFIXES = (".ply", ".npz", ".npy", ".las", ".csv", ".xyz", ".pcd", ".obj", ".off")


class OfAnotherLibrary:
    """What numpy can read but nothing else is known of."""

    def __init__(self, values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        if self.values is None:
            raise RuntimeError("the values are on another device")
        return self.values


def doors(cloud, tmp_path):
    yield lambda: lpcompare.simplify(cloud, target_count=9, method="farthest_point")
    yield lambda: lpcompare.evaluate(cloud, POINTS[:20])
    yield lambda: lpcompare.evaluate(POINTS, cloud)
    for suffix in SUFFIXES:
        yield lambda suffix=suffix: lpcompare.write(tmp_path / f"a{suffix}", cloud)


@pytest.mark.parametrize(
    ("parts", "says"),
    [
        ({"attributes": {"a": np.arange(5)}}, r"attribute 'a' has shape \(5,\)"),
        ({"attributes": {"a": np.float64(3)}}, r"attribute 'a' has shape \(\)"),
        ({"attributes": {"a": [[1], [1, 2]]}}, "attribute 'a' has rows of several lengths"),
        ({"attributes": {7: np.arange(60)}}, "attributes is"),
        ({"attributes": None}, "attributes is"),
        ({"normals": POINTS[:5]}, r"normals has shape \(5, 3\)"),
        ({"colors": np.abs(POINTS)}, r"colors has shape \(60, 3\).*needs \(60, 4\)"),
        ({"faces": np.array([[0, 1, 60]])}, "rows 0 to 60; this cloud has 0 to 59"),
        ({"faces": np.array([[0.0, 1, 2]])}, "faces .*give integers"),
        ({"name": 7}, "name is 7"),
    ],
)
def test_parts_that_do_not_fit_are_refused_at_every_door(tmp_path, parts, says):
    for call in doors(PointCloud(POINTS, **parts), tmp_path):
        with pytest.raises(InputError, match=says):
            call()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "given",
    [POINTS, POINTS.tolist(), OfAnotherLibrary(POINTS), PointCloud(POINTS.tolist())],
    ids=["array", "list", "object", "cloud of lists"],
)
def test_what_numpy_can_read_passes_every_door(tmp_path, given):
    for call in doors(given, tmp_path):
        call()
    for suffix in SUFFIXES:
        np.testing.assert_allclose(lpcompare.read(tmp_path / f"a{suffix}").points, POINTS, atol=1e-6)
    result = lpcompare.simplify(given, target_count=9, method="farthest_point")
    kept = result.as_given()
    np.testing.assert_array_equal(kept.points if isinstance(kept, PointCloud) else kept, result.points)


def test_what_numpy_cannot_read_is_refused(tmp_path):
    for call in doors(OfAnotherLibrary(None), tmp_path):
        with pytest.raises(InputError, match="must be an array of real numbers"):
            call()


def test_lists_are_as_good_as_arrays(tmp_path):
    lists = {"normals": POINTS.tolist(), "attributes": {"a": list(range(60))}, "faces": [[0, 1, 2]]}
    cloud = PointCloud(POINTS, **lists)
    for call in doors(cloud, tmp_path):
        call()
    assert lpcompare.read(tmp_path / "a.ply").faces.tolist() == [[0, 1, 2]]
    kept = lpcompare.simplify(cloud, target_count=9, method="farthest_point")
    assert kept.as_given().attributes["a"].tolist() == kept.indices.tolist()
