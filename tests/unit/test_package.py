"""What `import lpcompare` costs and offers."""

import subprocess
import sys

import pytest

import lpcompare

HEAVY = (
    "numpy",
    "scipy",
    "sklearn",
    "cvxpy",
    "highspy",
    "pymeshlab",
    "fast_simplification",
    "typer",
    "plotly",
)


def run_python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_import_loads_no_library():
    code = "import lpcompare, sys; print(*sys.modules)"
    assert not set(HEAVY) & set(run_python(code).split())


def test_listing_the_methods_loads_no_rival():
    code = (
        "import sys; from lpcompare.registry import METHODS\n"
        "for n in METHODS: METHODS.summary(n), METHODS.traits(n), METHODS.missing(n)\n"
        "print(*sys.modules)"
    )
    loaded = set(run_python(code).split())
    assert not {"pymeshlab", "fast_simplification", "cvxpy", "sklearn"} & loaded
    assert not any(m.startswith("lpcompare_baselines.") for m in loaded)


def test_a_command_that_the_first_word_names_loads_no_other():
    code = (
        "import sys; from lpcompare.cli import build_app; build_app('list')\n"
        "print(*(m for m in sys.modules if m.startswith('lpcompare.cli.') and '._' not in m))"
    )
    assert run_python(code).split() == ["lpcompare.cli.list"]


def test_what_a_report_says_of_columns_loads_no_metric():
    code = (
        "import sys; from lpcompare.report.cells import columns; import pandas as pd\n"
        "print(columns(pd.DataFrame({'hausdorff_pct': [1.0]}))['hausdorff_pct'].unit)\n"
        "print(*(m for m in sys.modules if m.startswith('lpcompare.metrics.')))"
    )
    assert run_python(code).splitlines() == ["% of diagonal", ""]


def test_clusters_that_are_certified_without_a_solver_load_no_cvxpy():
    code = (
        "import sys, lpcompare; from lpcompare.models.synthetic import torus\n"
        "result = lpcompare.simplify(torus(), target_reduction=0.9)\n"
        "print(result.method, 'cvxpy' in sys.modules)"
    )
    assert run_python(code).split() == ["lp_uniform", "False"]


def test_every_public_name_can_be_had():
    for name in lpcompare.__all__:
        assert getattr(lpcompare, name).__doc__
    assert dir(lpcompare) == sorted(lpcompare.__all__)


def test_unknown_attribute_is_an_attribute_error():
    with pytest.raises(AttributeError, match="nosuch"):
        lpcompare.nosuch  # noqa: B018
