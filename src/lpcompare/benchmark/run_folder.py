"""A run's folder on disk: readable at every moment, whatever ends the run."""

from __future__ import annotations

import csv
import io
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from lpcompare.benchmark.record import SCHEMA_VERSION, Record
from lpcompare.benchmark.summary import summary_rows
from lpcompare.files import ANOTHER_FOLDER, CONTINUE, replace_text, writing

_NESTED = ("settings", "timings", "metrics", "info")


class RunFolder:
    """Writes run.json, records.jsonl, records.csv and clouds/.

    Every finished record is appended to records.jsonl and flushed to the disk before the next case starts;
    run.json is replaced whole at the start and at the end. `lpcompare.benchmark.record.load_run` reads both.

    Parameters
    ----------
    path : Path
        Created if need be.

    Raises
    ------
    InputError
        The folder cannot be made or written.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.clouds, self.scratch = path, path / "clouds", path / ".work"
        self._head: dict[str, Any] = {}
        with writing(path, ANOTHER_FOLDER):
            self.clouds.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(self.scratch, ignore_errors=True)
            self.scratch.mkdir()

    def begin(self, head: Mapping[str, Any], finished: Iterable[Record]) -> None:
        """Write plan, environment and inputs, and the records that an earlier start finished."""
        self._head = {"schema_version": SCHEMA_VERSION, **head}
        finished = list(finished)
        self._write_document(finished, complete=False)
        replace_text(self._lines, "".join(_line(record) for record in finished), CONTINUE)

    def append(self, record: Record) -> None:
        """Keep a finished record, on the disk when this returns."""
        with writing(self.path, CONTINUE), self._lines.open("a", encoding="utf-8") as file:
            file.write(_line(record))
            file.flush()
            os.fsync(file.fileno())

    def end(self, records: Iterable[Record], *, complete: bool) -> None:
        """Write run.json and the tables with every record; clear away what only a running run needs."""
        records = list(records)
        self._write_document(records, complete=complete)
        replace_text(self.path / "records.csv", _table([_flat(record) for record in records]), CONTINUE)
        replace_text(self.path / "summary.csv", _table(summary_rows(records)), CONTINUE)
        self._lines.unlink(missing_ok=True)
        shutil.rmtree(self.scratch, ignore_errors=True)

    def exchange(self) -> Path:
        """A new empty folder for the files of one child process."""
        with writing(self.path, CONTINUE):
            return Path(tempfile.mkdtemp(dir=self.scratch))

    @property
    def _lines(self) -> Path:
        return self.path / "records.jsonl"

    def _write_document(self, records: list[Record], *, complete: bool) -> None:
        document = self._head | {"complete": complete, "records": [r.to_dict() for r in records]}
        replace_text(self.path / "run.json", json.dumps(document, indent=1, allow_nan=False) + "\n", CONTINUE)


def _line(record: Record) -> str:
    return json.dumps(record.to_dict(), allow_nan=False) + "\n"


def _table(rows: list[dict[str, Any]]) -> str:
    """Rows as CSV; a column for every key that occurs."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _flat(record: Record) -> dict[str, Any]:
    """A record in one row: stage times as ``time_<stage>_s``, settings and info as JSON, metrics by name."""
    row = record.to_dict()
    flat = {name: value for name, value in row.items() if name not in _NESTED}
    flat |= {name: json.dumps(row[name], sort_keys=True) for name in ("settings", "info")}
    flat |= {f"time_{stage}_s": seconds for stage, seconds in row["timings"].items()}
    return flat | row["metrics"]
