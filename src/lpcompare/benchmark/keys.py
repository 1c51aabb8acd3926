"""The key of a case: a digest of everything that decides its result."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import lpcompare
from lpcompare.registry import METHODS, METRICS

_SHARED = (
    "types.py",
    "mesh_library.py",
    "metrics/comparison.py",
    "geometry/*.py",
    "paper/*.py",
    "uniform/*.py",
)


def case_key(method: str, metrics: Iterable[str], facts: Mapping[str, Any]) -> str:
    """SHA-256 over the method's code, the metrics' code and the facts of the case.

    Parameters
    ----------
    method : str
    metrics : iterable of str
    facts : mapping
        JSON-ready: input digests, settings, count, seed, repeat, versions.
    """
    code = [method_digest(method), *(_digest([METRICS.source(name)]) for name in metrics)]
    return _digest([json.dumps([code, dict(facts)], sort_keys=True, default=repr).encode()])


@cache
def method_digest(name: str) -> str:
    """SHA-256 of the method's file, of the helpers beside it and of the steps that methods share."""
    home = METHODS.path(name).parent
    helpers = sorted(home.glob("_*.py"))
    root = Path(lpcompare.__file__).parent
    shared = sorted(path for pattern in _SHARED for path in root.glob(pattern))
    return _digest([METHODS.source(name), *(path.read_bytes() for path in (*helpers, *shared))])


def _digest(parts: Iterable[bytes]) -> str:
    state = hashlib.sha256()
    for part in parts:
        state.update(len(part).to_bytes(8, "big") + part)
    return state.hexdigest()
