"""Starts a process that would run for an hour, then hangs."""

import os
import subprocess
import time
from pathlib import Path

from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def leaves_a_child(points, target_count, *, rng):
    Path(os.environ["CHILD_PID_FILE"]).write_text(str(subprocess.Popen(["sleep", "3600"]).pid))
    while True:
        time.sleep(0.1)
