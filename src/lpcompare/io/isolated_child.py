"""Read or copy one file and say how it went; run as a program by `isolated`.

The last line of standard output is {"error": "" or the error's class, "reason": its text}.
"""

from __future__ import annotations

import json
import sys
from importlib import import_module
from pathlib import Path

import numpy as np

from lpcompare.io.isolated import packed

_MEMORY_BYTES = 16 * 2**30


def main(family: str, action: str, source: str, result: str, *rows: str) -> None:
    """Call ``action`` of a file of this folder."""
    _limit_memory()
    module = import_module(f"lpcompare.io.{family}")
    try:
        if action == "read":
            np.savez(result, allow_pickle=False, **packed(module.read(Path(source))))
        else:
            module.keep_rows(Path(source), Path(result), np.load(rows[0]))
        verdict = {"error": "", "reason": ""}
    except BaseException as error:  # a Rust panic is no Exception
        verdict = {"error": type(error).__name__, "reason": _reason(error)}
    sys.stdout.write("\n" + json.dumps(verdict))


def _reason(error: BaseException) -> str:
    """The error's text; of one word alone, such as the number of an unknown kind, also its class."""
    text = str(error)
    return text if " " in text else f"{type(error).__name__} {text}".strip()


def _limit_memory() -> None:
    """A damaged count must not take the machine's memory; systems without such limits go without."""
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))


if __name__ == "__main__":
    main(*sys.argv[1:])
