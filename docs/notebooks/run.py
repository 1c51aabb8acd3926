"""Run notebooks and keep their outputs: ``python docs/notebooks/run.py [FILE...]``, by default all of this folder."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat
from jupyter_client import KernelManager
from nbclient import NotebookClient


def run_notebook(path: Path) -> nbformat.NotebookNode:
    """The notebook with the outputs of today, from a kernel of this interpreter."""
    book = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as sockets:
        manager = KernelManager(transport="ipc", ip=f"{sockets}/kernel")
        manager.kernel_spec.argv[0] = sys.executable
        return NotebookClient(book, km=manager, timeout=300, record_timing=False).execute()


def main() -> None:
    """Run and write every notebook."""
    given = [Path(name) for name in sys.argv[1:]]
    for path in given or sorted(Path(__file__).parent.glob("*.ipynb")):
        nbformat.write(run_notebook(path), path)


if __name__ == "__main__":
    main()
