"""MeshLab's Poisson disk: its law, its count, and its draws in fresh processes."""

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial import KDTree

from lpcompare.errors import NotApplicable
from lpcompare.registry import call
from lpcompare.types import PointCloud
from lpcompare_baselines.poisson_disk import calibrate, poisson_disk

DRAW = """
import json, sys
import numpy as np
from lpcompare_baselines.poisson_disk import calibrate, poisson_disk
points = np.random.default_rng(0).random((3000, 3)) * [1, 1, 0.01]
seed = int(sys.argv[1])
found = calibrate(points, 400, rng=np.random.default_rng(seed))
print(json.dumps(poisson_disk(points, 400, rng=np.random.default_rng(seed), **found).indices.tolist()))
"""


@pytest.fixture(scope="module")
def cloud():
    return np.random.default_rng(0).random((3000, 3)) * [1, 1, 0.01]


def draw(seed):
    child = subprocess.run(
        [sys.executable, "-c", DRAW, str(seed)], capture_output=True, text=True, timeout=60, check=True
    )
    return json.loads(child.stdout)


def test_kept_points_are_a_radius_apart_and_cover_the_rest(cloud):
    found = calibrate(cloud, 400, rng=np.random.default_rng(0))
    kept = poisson_disk(cloud, 400, rng=np.random.default_rng(0), **found).points
    spacing = KDTree(kept).query(kept, k=2)[0][:, 1].min()
    covering = KDTree(kept).query(cloud)[0].max()
    assert spacing >= found["radius"] * (1 - 1e-6)
    assert covering <= found["radius"] * (1 + 1e-6)


@pytest.mark.skipif(sys.platform != "linux", reason="a draw is foreseen by forking")
@pytest.mark.parametrize("target", [1, 57, 400, 2900])
def test_the_count_is_the_one_asked_for(cloud, target):
    assert len(call("poisson_disk", PointCloud(cloud), target, random_state=1)) == target


def test_a_seed_gives_the_same_draw_in_a_fresh_process_and_another_seed_another():
    first, again, other = draw(4), draw(4), draw(5)
    assert first == again
    assert first != other


def test_more_points_than_are_distinct_is_declined_not_searched_for_ever():
    points = np.repeat(np.random.default_rng(0).random((30, 3)), 2, axis=0)
    with pytest.raises(NotApplicable, match="only 30 of the 60 are distinct"):
        call("poisson_disk", PointCloud(points), 31)
    assert len(call("poisson_disk", PointCloud(points), 20)) == 20
