"""What every test may ask for."""

from pathlib import Path

import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared" / "models"


def pytest_addoption(parser):
    parser.addoption(
        "--long", action="store_true", help="Try every case of the suites that are bounded in CI."
    )


@pytest.fixture(scope="session")
def shared_models():
    """The folder of real scans beside the checkout; tests that need it are skipped without it."""
    if not (SHARED / "upstream").is_dir():
        pytest.skip("the real scans beside the checkout (../shared/models) are absent")
    return SHARED
