"""What other programs take of the machine."""

import subprocess
import sys
import time

import pytest

from lpcompare.benchmark import timing


def test_a_program_beside_this_one_is_seen():
    spin = [sys.executable, "-c", "import time\nend = time.time() + 2\nwhile time.time() < end: pass"]
    with subprocess.Popen(spin):
        time.sleep(0.3)
        others = timing.OtherPrograms()
        time.sleep(0.5)
        assert others.load() > 0.3


@pytest.mark.parametrize(("own", "load"), [(3.0, 0.0), (2.0, 0.5), (3.1, 0.0)])
def test_what_this_process_used_is_not_counted(monkeypatch, own, load):
    readings = iter([(0.0, 10.0, 2.0), (2.0, 13.0, 2.0 + own)])
    monkeypatch.setattr(timing, "_used", lambda: next(readings))
    assert timing.OtherPrograms().load() == load
