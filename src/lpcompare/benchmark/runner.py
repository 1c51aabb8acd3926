"""A plan, run: every case in its own child process, every record on disk before the next case starts."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Lock
from typing import Protocol

from lpcompare.benchmark.case import Children
from lpcompare.benchmark.environment import capture, package_versions
from lpcompare.benchmark.inputs import Input, file_name, write_input
from lpcompare.benchmark.keys import case_key
from lpcompare.benchmark.lock import sole_writer
from lpcompare.benchmark.perturbation import CLEAN, perturb
from lpcompare.benchmark.plan import REFERENCE, Case, Plan, target_count
from lpcompare.benchmark.record import Record, Run, load_run
from lpcompare.benchmark.resume import earlier_run, reusable
from lpcompare.benchmark.run_folder import RunFolder
from lpcompare.registry import METHODS
from lpcompare.types import PointCloud


class Listener(Protocol):
    """Told of each case before it starts (no record) and after it has ended, or was taken over."""

    def __call__(self, case: Case, record: Record | None, *, reused: bool = False) -> None:
        """Take note."""
        ...


def silent(case: Case, record: Record | None, *, reused: bool = False) -> None:
    """Take no note."""


def run_plan(
    plan: Plan,
    models: Mapping[str, PointCloud],
    folder: Path,
    *,
    resume: bool = False,
    listener: Listener = silent,
) -> Run:
    """Run every case of a plan and keep the run in a folder.

    Parameters
    ----------
    plan : Plan
        Already checked.
    models : mapping of str to PointCloud
        The clouds of ``plan.models``, by the plan's names.
    folder : Path
        Where run.json, records.csv and clouds/ go.
    resume : bool
        Take over the records of an earlier start in this folder whose keys are the same, and keep those of
        cases that this plan does not name.
    listener : Listener

    Returns
    -------
    Run

    Raises
    ------
    InputError
        The folder cannot be written, now or later, or another process is writing it, or it holds a run that
        ``resume`` does not allow to continue.
    """
    with sole_writer(folder):
        earlier = earlier_run(folder, plan, models, resume=resume)
        runner = _Runner(plan, models, RunFolder(folder), earlier)
        complete = False
        try:
            runner.run(listener)
            complete = True
        finally:
            runner.end(complete=complete)
        return load_run(folder)


class _Runner:
    """The state of a run: inputs on disk, counts that the reference method reached, finished records."""

    def __init__(
        self, plan: Plan, models: Mapping[str, PointCloud], store: RunFolder, earlier: Run | None
    ) -> None:
        self.plan, self.models, self.store, self.earlier = plan, models, store, earlier
        self.reusable = reusable(earlier, plan) if earlier else {}
        self.clean = {name: write_input(store.clouds, cloud) for name, cloud in models.items()}
        self.inputs: dict[tuple[object, ...], Input] = {}
        self.reached: dict[tuple[object, ...], int] = {}
        self.done: dict[int, Record] = {}
        self.lock = Lock()
        self.cases = list(plan.cases())
        self.versions = {v.method: package_versions([v.method]) for v in plan.variants}
        for case in self.cases:
            self._input(case)
        self.children = Children()
        store.begin(self._head(), earlier.records if earlier else ())

    def run(self, listener: Listener) -> None:
        """Run the cases in order; with several jobs, that many at a time."""
        if self.plan.jobs == 1:
            for number in range(len(self.cases)):
                self._step(number, listener)
            return
        for group in self._groups():
            pool = ThreadPoolExecutor(self.plan.jobs)
            try:
                list(pool.map(lambda number: self._step(number, listener), group))
            finally:
                pool.shutdown(wait=False, cancel_futures=True)
                self.children.stop()
                pool.shutdown(wait=True)

    def end(self, *, complete: bool) -> None:
        """Write what there is: the records of the plan, then what an earlier start finished beside them."""
        records = [self.done[n] for n in sorted(self.done)]
        cases = {record.case_id for record in records}
        earlier = self.earlier.records if self.earlier else ()
        records += [record for record in earlier if record.case_id not in cases]
        self.store.end(records, complete=complete)

    def _groups(self) -> Iterator[list[int]]:
        """Under as-printed the reference's cases come before those that take their counts from it."""
        numbers = range(len(self.cases))
        if self.plan.protocol == "as-printed":
            yield [n for n in numbers if self.cases[n].variant.method == REFERENCE]
            yield [n for n in numbers if self.cases[n].variant.method != REFERENCE]
        else:
            yield list(numbers)

    def _step(self, number: int, listener: Listener) -> None:
        """One case: taken over from an earlier start, or run now and put on disk."""
        case = self.cases[number]
        listener(case, None)
        blank = self._blank(case)
        kept = self._kept(blank)
        record = kept or self._compute(case, blank)
        with self.lock:
            self.done[number] = record  # before the disk: an interrupt between the two must not lose it
            if kept is None:
                self.store.append(record)
            if case.variant.method == REFERENCE and record.n_output:
                self.reached.setdefault(_group(case), record.n_output)
            listener(case, record, reused=kept is not None)

    def _kept(self, blank: Record) -> Record | None:
        """The record of an earlier start, if its cloud is still there."""
        kept = self.reusable.get(blank.key)
        lost = kept is not None and kept.cloud and not (self.store.path / kept.cloud).exists()
        return None if lost else kept

    def _blank(self, case: Case) -> Record:
        """The record of a case before it is run."""
        given = self._input(case)
        asked = target_count(self.clean[case.model].n_points, case.reduction)
        if self.plan.protocol == "as-printed" and case.variant.method != REFERENCE:
            asked = self.reached.get(_group(case), asked)
        record = Record(
            model=given.model,
            method=case.variant.method,
            variant=case.variant.label,
            reduction=case.reduction,
            n_input=given.n_points,
            target_count=asked,
            seed=case.seed,
            repeat=case.repeat,
            status="failed",
            perturbation=case.perturbation.kind,
            perturbation_level=case.perturbation.level,
            settings=case.variant.settings,
        )
        return replace(record, key=self._key(case, record))

    def _key(self, case: Case, record: Record) -> str:
        facts = {
            "input": self._input(case).sha256,
            "clean": self.clean[case.model].sha256,
            "model": record.model,
            "settings": dict(record.settings),
            "reduction": record.reduction,
            "target_count": record.target_count,
            "seed": record.seed,
            "repeat": record.repeat,
            "metrics": self.plan.metrics,
            "refine": self.plan.refine,
            "threads": self.plan.threads,
            "packages": self.versions[record.method],
        }
        return case_key(record.method, self.plan.metrics, facts)

    def _compute(self, case: Case, blank: Record) -> Record:
        missing = METHODS.missing(blank.method)
        if missing:
            return replace(blank, status="skipped", message=missing)
        if blank.target_count > blank.n_input:
            asked, given = blank.target_count, blank.n_input
            return replace(blank, status="skipped", message=f"{asked} points asked of an input of {given}.")
        folder = self.store.exchange()
        try:
            return self._from_child(case, blank, folder)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _from_child(self, case: Case, blank: Record, folder: Path) -> Record:
        result = folder / "result.npz" if case.repeat == 0 else None
        request = {
            "parent": os.getpid(),
            "input": str(self._input(case).path.resolve()),
            "clean": str(self.clean[case.model].path.resolve()),
            "output": str(result.resolve()) if result else "",
            "method": blank.method,
            "settings": dict(blank.settings),
            "target_count": blank.target_count,
            "entropy": seed_entropy(blank.seed, blank.repeat, blank.method, blank.model),
            "metrics": list(self.plan.metrics),
            "refine": self.plan.refine,
            "time_limit_s": self.plan.time_limit_s,
            "memory_limit_mib": self.plan.memory_limit_mib,
            "threads": self.plan.threads,
        }
        record = Record.from_dict(blank.to_dict() | self.children.run(request, folder.resolve()))
        if result is None or not result.exists():
            return record
        kept = self.store.clouds / f"{_cloud_name(case, record)}.npz"
        os.replace(result, kept)
        return replace(record, cloud=f"clouds/{kept.name}")

    def _input(self, case: Case) -> Input:
        """The cloud that a case is given; damaged ones are made once per seed."""
        if case.perturbation == CLEAN:
            return self.clean[case.model]
        key = (case.model, case.perturbation, case.seed)
        if key not in self.inputs:
            damaged = perturb(self.models[case.model], case.perturbation, case.seed)
            self.inputs[key] = write_input(self.store.clouds, damaged, case.perturbation, case.seed)
        return self.inputs[key]

    def _head(self) -> dict[str, object]:
        methods = [variant.method for variant in self.plan.variants]
        inputs = dict(self.earlier.inputs) if self.earlier else {}
        inputs |= {
            given.path.stem: {
                "file": f"clouds/{given.path.name}",
                "model": given.model,
                "n_points": given.n_points,
                "sha256": given.sha256,
            }
            for given in (*self.clean.values(), *self.inputs.values())
        }
        environment = capture(methods, self.plan.threads)
        return {"plan": self.plan.to_dict(), "environment": environment, "inputs": inputs}


def seed_entropy(seed: int, repeat: int, method: str, model: str) -> list[int]:
    """Entropy of a case's generator: ``numpy.random.SeedSequence(entropy)``.

    Method and model enter as the first 8 bytes of their names' SHA-256, so that no two methods draw the same
    numbers, and adding a method changes no other method's draw.
    """
    names = (hashlib.sha256(name.encode()).digest()[:8] for name in (method, model))
    return [seed, repeat, *(int.from_bytes(name, "big") for name in names)]


def _group(case: Case) -> tuple[object, ...]:
    return case.model, case.perturbation, case.reduction, case.seed


def _cloud_name(case: Case, record: Record) -> str:
    parts = [record.model, case.perturbation.label, record.variant, f"{case.reduction:g}", f"s{case.seed}"]
    return "~".join(file_name(part) for part in parts if part)
