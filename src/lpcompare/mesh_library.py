"""pymeshlab, imported in one place, so that a missing system library is one sentence everywhere."""

from __future__ import annotations

import re
from importlib import import_module
from types import ModuleType

from lpcompare.errors import Unavailable

_PACKAGES = {"libGL.so.1": "libgl1 (Debian, Ubuntu), mesa-libGL (Fedora) or libglvnd (Arch)"}


def pymeshlab() -> ModuleType:
    """The module pymeshlab.

    Raises
    ------
    Unavailable
        pymeshlab, or a system library that it loads, is not installed; the message says what to install.
    """
    try:
        return import_module("pymeshlab")
    except ImportError as error:
        raise Unavailable(_sentence(str(error))) from error


def _sentence(reason: str) -> str:
    library = re.search(r"lib[\w.+-]+\.so[.\d]*", reason)
    if library is None:
        return f"pymeshlab cannot be imported ({reason}); install it with: pip install pymeshlab."
    package = _PACKAGES.get(library[0], f"the package that holds {library[0]}")
    return f"pymeshlab needs the system library {library[0]}, which is not installed; install {package}."
