"""The command line in a process of its own, forked from one that has imported what it is made of.

The fixture `lpcompare` of conftest.py calls `main` there. No name of a method or a metric is looked up before
the fork, so that a call finds the plug-ins of its own environment.
"""

import json
import os
import sys
import tempfile
import traceback
from importlib import import_module

import numpy as np

from lpcompare import cli


def prepare():
    """Import what most commands import, and draw a picture."""
    for name in ("benchmark.runner", "cli._progress", "report.page"):
        import_module(f"lpcompare.{name}")
    from lpcompare.report.figures import cloud_still

    cli.build_app()
    cloud_still(np.eye(3))


def main(environment, *words):
    """Run the command with the environment variables of a JSON object, and end as it does."""
    os.environ.clear()
    os.environ.update(json.loads(environment))
    tempfile.tempdir = None
    sys.path[:0] = [p for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p]
    sys.argv = ["lpcompare", *words]
    # those from before the fork believe that they are the file that was there
    sys.stdout = open(1, "w", encoding=sys.stdout.encoding, closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding=sys.stderr.encoding, errors="backslashreplace", closefd=False)  # noqa: SIM115
    code = 0
    try:
        cli.main()
    except SystemExit as end:
        code = end.code or 0
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    main(*sys.argv[1:])
