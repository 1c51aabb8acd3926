"""Never returns, and does not hear SIGTERM or SIGINT."""

import signal
import time

from lpcompare.types import Traits

TRAITS = Traits(wraps="numpy")


def hangs(points, target_count, *, rng):
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    while True:
        time.sleep(0.1)
