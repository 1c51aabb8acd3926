"""The made runs of tests/plugins/made_runs.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "plugins"))

sys.path.insert(0, str(Path(__file__).resolve().parent))

from made_runs import new_run, plain_run  # noqa: F401
