"""A table of measurements on disk that a stopped command takes up where it ended."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from lpcompare.errors import InputError
from lpcompare.files import replace_text

Row = Mapping[str, Any]


class Table:
    """Rows of one experiment in a CSV file, one per key; each is on disk before the next is measured.

    Parameters
    ----------
    path : Path
        The CSV file; made with the first row.
    keys : tuple of str
        The columns that name a row; the others are measured.
    """

    def __init__(self, path: Path, keys: tuple[str, ...]) -> None:
        self.path = path
        self.keys = keys
        self.rows: list[dict[str, str]] = self._read() if path.exists() else []
        self._done = {self._key(row) for row in self.rows}

    def fill(self, cases: Iterable[Row], measure: Callable[[Row], Row]) -> Iterator[Row]:
        """Measure every case that has no row yet, and yield each case as it is finished."""
        for case in cases:
            if self._key(case) not in self._done:
                self._append({**case, **measure(case)})
            yield case

    def _key(self, row: Row) -> tuple[str, ...]:
        return tuple(text(row[k]) for k in self.keys)

    def _append(self, row: Row) -> None:
        cells = {name: text(value) for name, value in row.items()}
        with self.path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(cells), lineterminator="\n")
            if not self.rows:
                writer.writeheader()
            writer.writerow(cells)
            file.flush()
            os.fsync(file.fileno())
        self.rows.append(cells)
        self._done.add(self._key(cells))

    def _read(self) -> list[dict[str, str]]:
        found = self.path.read_text(encoding="utf-8")
        whole = found[: found.rfind("\n") + 1]
        if whole != found:
            replace_text(self.path, whole)  # without a last line that was cut off in the middle
        rows = list(csv.DictReader(whole.splitlines()))
        if rows and not set(self.keys) <= rows[0].keys():
            raise InputError(f"{self.path} is not a table of this command; name another folder with --out.")
        return rows


def text(value: object) -> str:
    """A value as it stands in a table: six digits of a number that is not whole."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
