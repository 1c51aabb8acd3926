"""A table of measurements on disk that a stopped command takes up where it ended."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from lpcompare.errors import InputError

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
        return tuple(str(row[k]) for k in self.keys)

    def _append(self, row: Row) -> None:
        text = {name: _text(value) for name, value in row.items()}
        with self.path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(text), lineterminator="\n")
            if not self.rows:
                writer.writeheader()
            writer.writerow(text)
            file.flush()
            os.fsync(file.fileno())
        self.rows.append(text)
        self._done.add(self._key(text))

    def _read(self) -> list[dict[str, str]]:
        text = self.path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            self._rewrite(whole)
        rows = list(csv.DictReader(whole.splitlines()))
        if rows and not set(self.keys) <= rows[0].keys():
            raise InputError(f"{self.path} is not a table of this command; name another folder with --out.")
        return rows

    def _rewrite(self, text: str) -> None:
        """Drop a last line that was cut off in the middle."""
        beside = self.path.with_suffix(".partial")
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, self.path)


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
