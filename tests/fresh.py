"""What tests run in a fresh process; most of its imports are done once, before it is forked.

The fixture `fresh` of conftest.py calls `main` there.
"""

import hashlib
import sys
import warnings

import numpy as np

from lpcompare.errors import NotApplicable
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.surface import estimate_surface
from lpcompare.registry import call
from lpcompare.types import PointCloud


def prepare():
    """Do what most methods begin with."""
    estimate_surface(Neighbors(np.random.default_rng(0).normal(size=(100, 3))))


def far_outlier(name, distance):
    """Thin a sphere of which one point is far away; print the count, or that the method declines."""
    points = np.random.default_rng(0).normal(size=(2000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    points[0] = float(distance), 0, 0
    try:
        print(len(call(name, PointCloud(points), 200)))
    except NotApplicable as reason:
        print("declined:", reason)


def draw(name, path):
    """Thin a cloud with a seed; print the count and the digest of the points."""
    with np.load(path) as file:
        cloud = PointCloud(file["points"], faces=file["faces"])
    result = call(name, cloud, 150, random_state=3)
    print(len(result), hashlib.sha256(result.points.tobytes()).hexdigest())


def main(deed, *words):
    """Do one of the above; a warning is an error."""
    warnings.simplefilter("error")
    {"far_outlier": far_outlier, "draw": draw}[deed](*words)
    sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
