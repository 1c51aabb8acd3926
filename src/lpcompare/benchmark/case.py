"""One case, run by a child process: what it is asked, what it answers, and its end told in a sentence."""

from __future__ import annotations

import signal
import uuid
from dataclasses import replace
from pathlib import Path

import msgspec

from lpcompare.benchmark.record import Facts, Record
from lpcompare.files import CONTINUE, writing
from lpcompare.processes.children import Children, Ending

WORKER = "lpcompare.benchmark.worker"
"""The module whose ``main`` runs a case in a child process."""

_FROM_OUTSIDE = {
    signal.SIGINT,
    signal.SIGTERM,
    getattr(signal, "SIGKILL", None),
    getattr(signal, "SIGHUP", None),
}


class Request(msgspec.Struct, frozen=True):
    """What `lpcompare.benchmark.worker` is asked to do.

    Attributes
    ----------
    record : Record
        The case, not yet run.
    input, input_sha256 : str
        File of the cloud that the method is given, and the cloud's digest: a method may have changed it.
    output : str
        File for the result; empty where it is not kept.
    settings : mapping
        What was chosen of the method's settings.
    entropy : int or list of int
        Of the method's generator.
    clean, clean_sha256 : str
        The same of the cloud that the result is measured against; empty where that is the input.
    metrics : list of str
    refine : bool
        Improve a subset by swaps.
    trial : bool
        Only try whether the settings can be used: on a small cloud, then on the input.
    """

    record: Record
    input: str
    input_sha256: str
    output: str
    settings: Facts
    entropy: int | list[int]
    clean: str = ""
    clean_sha256: str = ""
    metrics: list[str] = []
    refine: bool = False
    trial: bool = False
    token: str = msgspec.field(default_factory=lambda: uuid.uuid4().hex)


class Answer(msgspec.Struct, frozen=True):
    """What the child process says, again and again; the last one counts.

    Attributes
    ----------
    token : str
        The request's: a line without it was not written by the worker.
    record : Record
        The case as far as it is known.
    stage : str
        What is being done.
    finished : bool
        True in the last answer.
    trouble : str
        ``input`` where a cloud on disk is not the right one, ``output`` where the result was not written,
        ``settings`` where the method refuses what was chosen.
    """

    token: str
    record: Record
    stage: str = "the start"
    finished: bool = False
    trouble: str = ""


def run_case(
    children: Children,
    request: Request,
    folder: Path,
    *,
    time_limit_s: float,
    memory_limit_mib: int,
    threads: int,
) -> Answer:
    """Run one case in a child process.

    Parameters
    ----------
    children : Children
    request : Request
    folder : Path
        An empty folder: the process's current one, for all that it writes.
    time_limit_s, memory_limit_mib, threads
        Limits of the process and all that it starts.

    Returns
    -------
    Answer
        Its record has a status and a message, however the process ended.

    Raises
    ------
    Stopped
        ``children.stop`` was called meanwhile.
    InputError
        The request cannot be written.
    """
    with writing(folder, CONTINUE):
        (folder / "request.json").write_bytes(msgspec.json.encode(request))
    limits = {"time_limit_s": time_limit_s, "memory_limit_mib": memory_limit_mib}
    ending = children.call(WORKER, str(folder), folder=folder, threads=threads, **limits)
    answer = _last_answer(ending, request)
    if answer.finished:
        tail = _tail(ending) if answer.record.status == "failed" else ""
        return _with_message(answer, answer.record.status, answer.record.message + tail)
    if ending.limit == "time":
        sentence = f"Killed in {answer.stage} after {time_limit_s:g} s, the time limit."
        return _with_message(answer, "timeout", sentence)
    sentence = f"{_end(ending, memory_limit_mib)} in {answer.stage}."
    answer = _with_message(answer, "failed", sentence + _tail(ending))
    if ending.limit == "guard" or -(ending.code or 0) in _FROM_OUTSIDE:  # another start may have a result
        answer = msgspec.structs.replace(answer, record=replace(answer.record, key=""))
    return answer


def _last_answer(ending: Ending, request: Request) -> Answer:
    """The last line that the worker wrote; other lines, also forged ones, are left out."""
    for line in reversed(ending.answer.split("\n")):
        try:
            answer = msgspec.json.decode(line, type=Answer)
        except (ValueError, RecursionError):
            continue
        same = answer.record.case_id == request.record.case_id and answer.record.key == request.record.key
        if answer.token == request.token and same:
            return answer
    return Answer(request.token, request.record)


def _with_message(answer: Answer, status: str, message: str) -> Answer:
    record = replace(answer.record, status=status, message=message)
    return msgspec.structs.replace(answer, record=record)


def _end(ending: Ending, memory_limit_mib: int) -> str:
    """How a process ended that left no result."""
    if ending.limit == "guard":
        return "The process that watches the case was killed"
    if ending.limit == "memory" or "bad_alloc" in ending.errors or "MemoryError" in ending.errors:
        return f"Out of memory (limit {memory_limit_mib} MiB)"
    code = ending.code or 0
    if code >= 0:
        return f"The process ended with exit code {code} and no result"
    if -code == signal.SIGKILL:
        return "The process was killed from outside (SIGKILL; often the system was out of memory)"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return f"The process crashed with {name}"


def _tail(ending: Ending) -> str:
    lines = ending.last_lines()
    return f" Last output: {lines}" if lines else ""
