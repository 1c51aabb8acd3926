"""What a method may return."""

from dataclasses import replace

import numpy as np
import pytest

from lpcompare.errors import MethodError
from lpcompare.models.synthetic import torus
from lpcompare.registry import Invocation
from lpcompare.types import PointCloud, Simplification, Traits

CLOUD = torus(16, 16)
SUBSET, MOVED = Traits(), Traits(moves_points=True)


def keep(rows):
    rows = np.asarray(rows)
    return Simplification(CLOUD.points[rows], rows)


def words(result, target=100, traits=SUBSET, after=CLOUD):
    """What is said of a result; of a fault what is wrong."""
    invocation = Invocation("random_sample", after, target)
    invocation.traits, invocation._exact = traits, traits.exact_count
    try:
        return invocation.verify(result, CLOUD)
    except MethodError as error:
        return str(error).removeprefix("random_sample: ")


def test_good_results_pass():
    assert words(keep(range(100))) == ""
    assert words(Simplification(CLOUD.points[:100] + 0.1), traits=MOVED) == ""
    assert words(keep(range(80)), traits=replace(SUBSET, exact_count=False)) == ""


@pytest.mark.parametrize(
    ("result", "sentence"),
    [
        (None, "NoneType"),
        (CLOUD.points[:100], "ndarray"),
        (Simplification(CLOUD.points[:100, :2]), r"(100, 2)"),
        (Simplification(CLOUD.points[:100].astype(np.float32)), "float32"),
        (Simplification(CLOUD.points[:0], np.arange(0)), "no points"),
        (keep(range(101)), "promises exactly 100"),
        (keep(range(98)), "promises exactly 100"),
        (Simplification(np.vstack([CLOUD.points, CLOUD.points])), "more than the 256"),
        (Simplification(np.full((100, 3), np.inf)), "NaN or infinite"),
        (Simplification(CLOUD.points[:100]), "names no rows"),
        (Simplification(CLOUD.points[:100], np.arange(99)), "(100,) integers"),
        (Simplification(CLOUD.points[:100], np.arange(100.0)), "integers"),
        (keep([1, 0, *range(2, 100)]), "ascending"),
        (keep([0, 0, *range(2, 100)]), "ascending"),
        (Simplification(CLOUD.points[:100], np.arange(1, 101)), "not the rows"),
    ],
)
def test_bad_results_are_named(result, sentence):
    assert sentence in words(result)


def test_a_count_that_a_broken_mesh_cannot_give_is_forgiven_up_to_one_percent():
    assert words(keep(range(99))) == "The method returned 99 points and promises exactly 100."
    with pytest.raises(MethodError):
        Invocation("random_sample", CLOUD, 100).verify(keep(range(98)), CLOUD)
    Invocation("random_sample", CLOUD, 100).verify(keep(range(99)), CLOUD)


@pytest.mark.parametrize("field", ["points", "normals", "faces"])
def test_a_changed_input_is_found(field):
    changed = getattr(CLOUD, field).copy()
    changed[3] = changed[4]
    after = PointCloud(**{**vars(CLOUD), field: changed})
    assert words(keep(range(100)), after=after) == "The method changed its input."
