"""How long each metric takes on the bunny thinned to a tenth; ``hausdorff`` is the reference."""

import numpy as np
import pytest

from lpcompare.metrics.comparison import Comparison
from lpcompare.registry import METRICS


@pytest.fixture(scope="module")
def clouds():
    from lpcompare.models import load_model

    points = load_model("bunny").points
    return points, points[np.random.default_rng(0).choice(len(points), len(points) // 10, replace=False)]


@pytest.mark.parametrize("name", METRICS.names())
def test_metric(name, clouds, benchmark):
    function = METRICS.get(name)
    values = benchmark.pedantic(lambda: function(Comparison(*clouds)), rounds=3, warmup_rounds=1)
    benchmark.extra_info |= values
    assert values
