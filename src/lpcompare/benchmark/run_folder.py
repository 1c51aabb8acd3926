"""A run's folder on disk: one writer at a time, readable at every moment, whatever ends the run.

Layout::

    run.json        plan, environment, inputs; at the end also the records, in the order of the plan
    records.jsonl   while the run is going on: one finished record per line
    records.csv     the rows of `Run.frame`, written at the end
    clouds/         <input>.npz (points, faces) and one .npz per result (points, indices, plane_errors)
    .lock           held by the process that writes the folder
    .work/          what child processes write; removed at the end, and at the next start
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from lpcompare.benchmark.record import SCHEMA_VERSION, Record, frame_of, line_of
from lpcompare.errors import InputError, printable
from lpcompare.files import ANOTHER_FOLDER, CONTINUE, replace_text, writing
from lpcompare.io.arrays import digest, save_cloud
from lpcompare.types import PointCloud


@dataclass(frozen=True)
class Input:
    """A cloud on disk that methods are given.

    Attributes
    ----------
    path : Path
        The .npz.
    make : callable
        Makes the cloud, again where a method has changed the file.
    model : str
    n_points : int
    sha256 : str
        Of all that a method can see.
    left_out : str
        What its file has that no method sees.
    """

    path: Path
    make: Callable[[], PointCloud]
    model: str
    n_points: int
    sha256: str
    left_out: str = ""

    def write(self) -> None:
        """Write the file again."""
        save_cloud(self.path, self.make())

    def facts(self) -> dict[str, Any]:
        """What run.json says of it."""
        file = f"clouds/{self.path.name}"
        facts = {"file": file, "model": self.model, "n_points": self.n_points, "sha256": self.sha256}
        return facts | ({"left_out": self.left_out} if self.left_out else {})


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """Keep other processes from writing the run of a folder meanwhile.

    Parameters
    ----------
    folder : Path
        Created if need be.

    Raises
    ------
    InputError
        The folder cannot be written, or another process is writing it.
    """
    from filelock import FileLock, Timeout

    with writing(folder, ANOTHER_FOLDER):
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / ".lock", blocking=False)
        try:
            lock.acquire()
        except Timeout as error:
            raise InputError(
                f"{folder} is being written by another lpcompare; "
                "wait until it has ended, or name another folder with --out."
            ) from error
    try:
        yield
    finally:
        lock.release()


class RunFolder:
    """Writes the files of a run.

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
        self._lines = path / "records.jsonl"
        self._head: dict[str, Any] = {}
        with writing(path, ANOTHER_FOLDER):
            self.clouds.mkdir(parents=True, exist_ok=True)
            shutil.rmtree(self.scratch, ignore_errors=True)
            self.scratch.mkdir()

    def write_input(self, name: str, make: Callable[[], PointCloud]) -> Input:
        """Write the cloud that one group of cases is given."""
        cloud = make()
        path, title, lost = self.clouds / f"{name}.npz", printable(cloud.name), ", ".join(cloud.beside)
        given = Input(path, make, title, len(cloud), digest(cloud), printable(lost))
        save_cloud(given.path, cloud)
        return given

    def begin(self, head: Mapping[str, Any], finished: Iterable[Record]) -> None:
        """Write plan, environment and inputs, and the records that an earlier start finished."""
        self._head = {"schema_version": SCHEMA_VERSION, **head}
        replace_text(self._lines, b"".join(map(line_of, finished)).decode(), CONTINUE)
        self._write_document([], complete=False)

    def append(self, record: Record) -> None:
        """Keep a finished record, on the disk when this returns."""
        with writing(self.path, CONTINUE), self._lines.open("ab") as file:
            file.write(line_of(record))
            file.flush()
            os.fsync(file.fileno())

    def keep_result(self, result: Path, record: Record, name: str) -> Record:
        """Move the file of a result to its place, and return the record that names it."""
        with writing(self.clouds, CONTINUE):
            self.clouds.mkdir(exist_ok=True)
            os.replace(result, self.clouds / f"{name}.npz")
        return replace(record, cloud=f"clouds/{name}.npz")

    def check_room(self, n_bytes: int) -> None:
        """Refuse to go on where this process cannot write either what a child could not; raises `InputError`."""
        probe = self.scratch / "room"
        with writing(self.scratch, CONTINUE):
            try:
                probe.write_bytes(bytes(n_bytes))
            finally:
                probe.unlink(missing_ok=True)

    def has_result(self, record: Record) -> bool:
        """Whether the file that a record names is there, and undamaged."""
        path = self.path / record.cloud
        if not record.cloud:
            return True
        return path.is_file() and file_digest(path) == record.cloud_sha256

    def end(self, records: Iterable[Record], *, complete: bool) -> None:
        """Write run.json and the table with every record; clear away what only a running run needs."""
        records = list(records)
        self._write_document(records, complete=complete)
        replace_text(self.path / "records.csv", _table(records), CONTINUE)
        self._lines.unlink(missing_ok=True)
        shutil.rmtree(self.scratch, ignore_errors=True)

    def exchange(self) -> Path:
        """A new empty folder for the files of one child process."""
        with writing(self.path, CONTINUE):
            self.scratch.mkdir(exist_ok=True)
            return Path(tempfile.mkdtemp(dir=self.scratch)).resolve()

    def _write_document(self, records: list[Record], *, complete: bool) -> None:
        document = msgspec.json.encode(self._head | {"complete": complete, "records": records})
        text = msgspec.json.format(document, indent=1).decode()
        replace_text(self.path / "run.json", text + "\n", CONTINUE)


def file_name(text: str) -> str:
    """``text`` as part of a file's name, of at most 80 bytes."""
    name = re.sub(r"[^\w.=-]+", "-", text).strip("-.") or "cloud"
    short = name.encode()[:68].decode(errors="ignore")
    return name if len(name.encode()) <= 80 else f"{short}-{hashlib.sha256(name.encode()).hexdigest()[:10]}"


def file_digest(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _table(records: list[Record]) -> str:
    """The records as CSV: nested values as JSON, and no cell that a spreadsheet takes for a formula."""
    frame = frame_of(records).drop(columns=["input", "label"])
    for name in ("settings", "info"):
        frame[name] = [msgspec.json.encode(value, order="deterministic").decode() for value in frame[name]]
    texts = frame.select_dtypes(["object", "str"]).columns
    frame[texts] = frame[texts].apply(lambda column: column.str.replace(r"^(?=[=+@-])", "'", regex=True))
    return frame.to_csv(index=False, lineterminator="\n")
