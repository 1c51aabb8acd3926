"""The command line in a process of its own, forked from one that has imported what it is made of.

The fixture `lpcompare` of conftest.py calls `main` there. No name of a method or a metric is looked up before
the fork, so that a call finds the plug-ins of its own environment.
"""

import json
import os
import signal
import sys
import tempfile
import traceback
from importlib import import_module
from pathlib import Path

import numpy as np

from lpcompare import cli
from lpcompare.types import PointCloud


def prepare():
    """Import what most commands import, and write a page."""
    for name in (
        "benchmark.runner",
        "cli._progress",
        "metrics.comparison",
        "models.catalogue",
        "report.tables",
    ):
        import_module(f"lpcompare.{name}")
    from lpcompare.report import page

    cli.build_app()(["--version"], standalone_mode=False)
    with tempfile.TemporaryDirectory() as folder:
        page.write_view(PointCloud(np.eye(3)), Path(folder) / "page.html")
    templates = page._environment()
    for name in templates.list_templates():
        templates.get_template(name)
    page._plotly()


def main(environment, *words):
    """Run the command with the environment variables of a JSON object, and end as it does.

    No file grows beyond the bytes of LARGEST_FILE.
    """
    os.environ.clear()
    os.environ.update(json.loads(environment))
    if size := os.environ.get("LARGEST_FILE"):
        import resource

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(size), resource.RLIM_INFINITY))
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
