"""What every test may ask for."""

import os
import signal
from pathlib import Path

import pytest

from lpcompare.processes.children import Children

SHARED = Path(__file__).resolve().parents[2] / "shared" / "models"


def pytest_addoption(parser):
    parser.addoption(
        "--long", action="store_true", help="Try every case of the suites that are bounded in CI."
    )


def pytest_configure(config):
    """Keep pytest-xdist at the order of `testpaths`, and let tests interrupt what they start.

    Files with few and long tests must not come last.
    """
    config.option.loadscopereorder = False
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a job in the background of a script
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def shared_models():
    """The folder of real scans beside the checkout; tests that need it are skipped without it."""
    if not (SHARED / "upstream").is_dir():
        pytest.skip("the real scans beside the checkout (../shared/models) are absent")
    return SHARED


@pytest.fixture(scope="session")
def fresh(tmp_path_factory):
    """Call ``main`` of fresh.py in a fresh process, a fork of one that has imported our packages."""
    folder = tmp_path_factory.mktemp("fresh")
    with pytest.MonkeyPatch.context() as patch, Children() as children:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=os.pathsep)
        children.prepare("fresh")

        def call(*words):
            ending = children.call("fresh", *words, folder=folder, time_limit_s=60, memory_limit_mib=8192)
            assert ending.code == 0, ending.errors
            return ending.answer

        yield call
