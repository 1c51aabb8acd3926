"""The machine and the software that a run's numbers belong to."""

from __future__ import annotations

import os
import platform
import re
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

from lpcompare.errors import printable
from lpcompare.processes.children import Children, thread_environment
from lpcompare.registry import METHODS
from lpcompare.types import Traits

_ALWAYS = [
    "lpcompare",
    "numpy",
    "scipy",
    "scikit-learn",
    "cvxpy",
    "highspy",
    "numba",
    "pymeshlab",
    "fast-simplification",
]


def capture(methods: Iterable[str], threads: int) -> dict[str, Any]:
    """Machine, operating system, versions, threads, commit and command line, JSON-ready."""
    return {
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": _command(),
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "cores_allowed": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "memory_mib": physical_memory_mib(),
        "os": platform.platform(),
        "python": platform.python_version(),
        "packages": package_versions(methods),
        "threads": thread_environment(threads),
        "commit": _commit(),
    }


def package_versions(methods: Iterable[str]) -> dict[str, str]:
    """Version of each installed package that can touch a result of these methods."""
    wrapped = {library(METHODS.traits(name)).replace("_", "-") for name in methods}
    required = {module.replace("_", "-") for name in methods for module in METHODS.traits(name).requires}
    found = {name: _version(name) for name in sorted({*_ALWAYS, *wrapped, *required})}
    return {name: number for name, number in found.items() if number}


def library(traits: Traits) -> str:
    """The module that a method wraps: the first word of ``wraps``."""
    return re.split(r"\W", traits.wraps, maxsplit=1)[0]


def physical_memory_mib() -> int:
    """Memory of the machine in MiB."""
    return psutil.virtual_memory().total // 2**20


def _command() -> str:
    """The command line; a program that uses lpcompare has its own."""
    program = Path(sys.argv[0])
    name = "lpcompare" if program.stem in ("lpcompare", "__main__") else program.name
    return printable(" ".join([name, *sys.argv[1:]]))


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _cpu_model() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _commit() -> str:
    """The checkout's commit, with a plus where files differ from it; empty for an installed package."""
    root = Path(__file__).resolve().parents[3]
    if not (root / ".git").exists():
        return ""
    head, changes = _git(root, "rev-parse", "HEAD"), _git(root, "status", "--porcelain")
    return head + ("+" if head and changes else "")


def _git(root: Path, *words: str) -> str:
    """What git says; empty where there is none."""
    ending = Children().run(["git", *words], root, time_limit_s=10, memory_limit_mib=2048)
    return ending.answer.strip() if ending.code == 0 else ""
