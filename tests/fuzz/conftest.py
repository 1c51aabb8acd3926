"""How long and with which seed files are damaged."""

import os
from types import SimpleNamespace

import pytest


def pytest_addoption(parser):
    group = parser.getgroup("fuzz")
    group.addoption(
        "--fuzz-seconds", type=float, default=float(os.environ.get("LPCOMPARE_FUZZ_SECONDS", "60"))
    )
    group.addoption("--fuzz-files", type=int, default=10**9)
    group.addoption("--fuzz-seed", default="1")


@pytest.fixture
def fuzz(request):
    """The options of this folder."""
    option = request.config.getoption
    return SimpleNamespace(**{n: option(f"--fuzz-{n}") for n in ("seconds", "files", "seed")})
