"""Picking rows of a measured table, and the statistics that the page quotes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from reports.paper.table import text

from lpcompare.types import Vector

Rows = Sequence[Mapping[str, str]]


def where(rows: Rows, **wanted: Any) -> list[Mapping[str, str]]:
    """The rows whose columns have the values given."""
    return [r for r in rows if all(r[name] == text(value) for name, value in wanted.items())]


def values(rows: Rows, column: str, **wanted: Any) -> Vector:
    """One column of the rows that match, as numbers."""
    return np.array([float(r[column]) for r in where(rows, **wanted)])


def distinct(rows: Rows, column: str) -> list[str]:
    """The values of a column, in the order in which they first stand."""
    return list(dict.fromkeys(r[column] for r in rows))


def span(numbers: Iterable[float], form: str) -> str:
    """The least and the greatest of some numbers, once where they print alike."""
    low, high = (format(f(list(numbers)), form) for f in (min, max))
    return low if low == high else f"{low} to {high}"
