"""How long each method takes on the same bunny, and with which error (eq. 27, in ``extra_info``).

Compare the columns with each other, not with those of another machine: ``random_sample`` is the reference.
"""

import inspect

import numpy as np
import pytest

from lpcompare.errors import NotApplicable
from lpcompare.metrics.comparison import Comparison
from lpcompare.registry import METHODS

SHARE_KEPT = 0.1


@pytest.fixture(scope="module")
def bunny():
    from lpcompare.models import load_model

    return load_model("bunny")


@pytest.mark.parametrize("name", METHODS.names())
def test_method(name, bunny, benchmark):
    if METHODS.missing(name):
        pytest.skip(METHODS.missing(name))
    function, module = METHODS.get(name), METHODS.module(name)
    known = {"cloud": bunny} if "cloud" in inspect.signature(function).parameters else {}
    target, settings = int(SHARE_KEPT * len(bunny)), {}
    try:
        if hasattr(module, "calibrate"):
            settings = module.calibrate(bunny.points, target, rng=np.random.default_rng(0), **known)
        result = benchmark.pedantic(
            lambda: function(bunny.points, target, rng=np.random.default_rng(0), **known, **settings),
            rounds=3,
            warmup_rounds=1,
        )
    except NotApplicable as reason:
        pytest.skip(str(reason))
    comparison = Comparison(bunny.points, result.points)
    error = comparison.plane_error_percent()
    benchmark.extra_info |= {"n_asked": target, "n_output": len(result), "plane_error_pct": error}
    assert np.isfinite(error)
