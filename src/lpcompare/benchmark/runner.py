"""A plan, run: every case in its own child process, every record on disk before the next case starts."""

from __future__ import annotations

import shutil
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Lock, Semaphore
from typing import Any, Protocol

from lpcompare.benchmark.case import WORKER, Answer, Request, run_case
from lpcompare.benchmark.environment import capture, package_versions
from lpcompare.benchmark.perturbation import CLEAN, Perturbation, keep_points, perturb
from lpcompare.benchmark.plan import REFERENCE, Case, Plan, seed_entropy
from lpcompare.benchmark.record import Record, Run, load_run
from lpcompare.benchmark.resume import case_key, earlier_run, reusable
from lpcompare.benchmark.run_folder import Input, RunFolder, file_name, sole_writer
from lpcompare.benchmark.study import build_plan, check_study
from lpcompare.checks import check_points, left_out, target_from_reduction, valid_rows
from lpcompare.errors import InputError
from lpcompare.interplay import read_object
from lpcompare.processes.children import Children, remove_left_folders, temporary_folder
from lpcompare.registry import METHODS
from lpcompare.types import PointCloud


class Listener(Protocol):
    """Told of each case before it starts (no record) and after it has ended, or was taken over."""

    def __call__(self, case: Case, record: Record | None, *, reused: bool = False) -> None:
        """Take note."""


def silent(case: Case, record: Record | None, *, reused: bool = False) -> None:
    """Take no note."""


def run(
    models: Sequence[Any],
    methods: Sequence[str] | None = None,
    *,
    out: str | Path | None = None,
    resume: bool = False,
    listener: Listener = silent,
    memory_limit_mib: int | None = None,
    threads: int | None = None,
    jobs: int = Plan.jobs,
    **study: Any,
) -> Run:
    """Compare methods on the same clouds at equal counts, each case in a process of its own.

    Parameters
    ----------
    models : sequence of str, PointCloud, array_like of shape (n, 3), or objects that `simplify` takes
        Names that `lpcompare.models` lists, files, or clouds in model units; a cloud without a name
        is called ``cloud``.
    methods : sequence of str, optional
        Registered methods, or "all" for every one installed. Default: those of the study `default`.
    out : str or Path, optional
        Folder of the run. Default: a temporary one, which lives as long as the run that is returned.
    resume : bool
        Continue the run in ``out``; finished cases are kept.
    listener : callable, optional
        Called with (case, None) before and (case, record, reused=...) after each case.
    memory_limit_mib : int, optional
        Memory of a case in MiB. Default: three quarters of the machine's.
    threads : int, optional
        Threads of a case. Default: all processors.
    jobs : int
        Cases at the same time; above 1 the runtimes are unreliable.
    **study
        Fields of `lpcompare.benchmark.study.Study`: ``reductions`` (shares to remove, 0.7, 0.8 and 0.9 by
        default), ``seeds``, ``repeats`` (interleaved over the methods), ``metrics`` (slow ones beside the
        quick ones, or ``all``), ``settings`` (per method; a list of values is a grid), ``perturbations``
        (levels of ``noise``, ``outliers``, ``uneven``, ``missing`` beside the clean cloud), ``protocol``
        (``equal-count``, or ``as-printed``: all are asked for the count that the paper's method reached),
        ``refine`` (improve subsets by swaps), ``time_limit_s`` (of a case, 300 by default), ``title``.

    Returns
    -------
    Run
        Its ``frame`` has one row per case and repeat.

    Raises
    ------
    UnknownName
        There is no such model, method, metric or setting.
    InputError
        A cloud, a number or a setting cannot be worked on, or the folder cannot be written.
    ModelDataError
        A model could not be fetched or read.

    Notes
    -----
    A method that fails, hangs or ends its process costs its own row: see ``status`` and ``message``.

    Examples
    --------
    >>> done = run(["cube"], ["random_sample", "farthest_point"], reductions=[0.9])
    >>> done.frame.groupby("label").n_output.median().to_dict()
    {'farthest_point': 960.0, 'random_sample': 960.0}
    """
    clouds = load_models(models)
    fields: dict[str, Any] = {"models": list(clouds), **study} | ({"methods": methods} if methods else {})
    plain = {name: value.tolist() if hasattr(value, "tolist") else value for name, value in fields.items()}
    checked = check_study(plain, "run")
    plan = build_plan(checked, memory_limit_mib=memory_limit_mib, threads=threads, jobs=jobs)
    if out is not None:
        return run_plan(plan, clouds, Path(out), resume=resume, listener=listener)
    life = ExitStack()
    done = run_plan(plan, clouds, life.enter_context(temporary_folder()) / "run", listener=listener)
    weakref.finalize(done, life.close)
    return done


def load_models(
    models: Sequence[Any],
    *,
    strict: bool = False,
    tell: Callable[[str], object] = lambda sentence: None,
) -> dict[str, PointCloud]:
    """Every model of a plan, by the name under which the plan asks for it.

    Parameters
    ----------
    models : sequence of str, or of clouds as `run` takes them
    strict : bool
        Refuse a file with points that have no finite coordinates, instead of leaving these points out.
    tell : callable
        Called with a sentence for each file that has such points.

    Raises
    ------
    UnknownName, InputError, ModelDataError
        A model does not exist, cannot be read, or is not a cloud of finite points.
    """
    clouds: dict[str, PointCloud] = {}
    for model in models:
        name, cloud = _named(model)
        bad = ~valid_rows(cloud.points) if isinstance(model, str) and cloud.points.ndim == 2 else None
        if bad is not None and bad.any() and not bad.all() and not strict:
            n_bad = int(bad.sum())
            tell(left_out(n_bad, len(cloud), name))
            cloud = keep_points(cloud, ~bad)
            cloud = replace(cloud, beside=(*cloud.beside, f"{n_bad:,} points without coordinates"))
        if name in clouds:
            raise InputError(f"The model {name!r} is named twice.")
        clouds[name] = replace(cloud, points=check_points(cloud.points, name))
    titles = [file_name(cloud.name) for cloud in clouds.values()]
    for title in titles:
        if titles.count(title) > 1:
            raise InputError(f"Two models are called {title!r}; rename one of them.")
    return clouds


def _named(model: Any) -> tuple[str, PointCloud]:
    if isinstance(model, str):
        from lpcompare.models import load_model

        return model, load_model(model)
    cloud = read_object(model)
    cloud = replace(cloud, name=cloud.name or "cloud")
    return cloud.name, cloud


def run_plan(
    plan: Plan,
    models: Mapping[str, PointCloud],
    folder: Path,
    *,
    resume: bool = False,
    listener: Listener = silent,
    meanwhile: Callable[[], object] = lambda: None,
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
    meanwhile : callable
        Work of this process before the first case, done while the process that the cases are forked from
        starts.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        The folder cannot be written, now or later, or another process is writing it, or it holds a run that
        ``resume`` does not allow to continue; or a method refuses the settings that were chosen for it.
    """
    remove_left_folders()
    with sole_writer(folder), Children() as children:
        earlier = earlier_run(folder, plan, models, resume=resume)
        children.prepare(
            WORKER, sorted({v.method for v in plan.variants}), plan.metrics, threads=plan.threads
        )
        runner = _Runner(plan, models, RunFolder(folder), earlier, children)
        complete = False
        try:
            if not runner.has_all:
                children.start()
                meanwhile()
            runner.run(listener)
            complete = True
        finally:
            runner.end(complete=complete)
        n_damaged = earlier.n_damaged if earlier else 0
        return replace(load_run(folder), n_damaged=n_damaged)


class _Runner:
    """The state of a run: inputs on disk, counts that the reference method reached, finished records."""

    def __init__(
        self,
        plan: Plan,
        models: Mapping[str, PointCloud],
        store: RunFolder,
        earlier: Run | None,
        children: Children,
    ) -> None:
        self.plan, self.models, self.store, self.earlier = plan, models, store, earlier
        self.reusable = reusable(earlier, plan) if earlier else {}
        self.inputs: dict[tuple[object, ...], Input] = {}
        self.reached: dict[tuple[object, ...], int] = {}
        self.done: dict[int, Record] = {}
        self.lock, self.alone, self.places = Lock(), Lock(), Semaphore(plan.jobs)
        self.children = children
        self.cases = list(plan.cases())
        self.versions = {v.method: package_versions([v.method]) for v in plan.variants}
        for case in self.cases:
            self._clean(case)
            self._input(case)
        self._try_settings()
        store.begin(self._head(), earlier.records if earlier else ())

    def _try_settings(self) -> None:
        """Have every variant with settings tried in a child process, before the first case."""
        for variant in (v for v in self.plan.variants if v.settings and not METHODS.missing(v.method)):
            case = next(case for case in self.cases if case.variant == variant)
            blank = self._blank(case)
            if blank.key in self.reusable:
                continue
            with self._exchange() as folder:
                answer = self._answer(case, self._request(case, blank, None, trial=True), folder)
            if answer.trouble == "settings":
                raise InputError(f"{variant.label}: {answer.record.message}")

    @property
    def has_all(self) -> bool:
        """Whether an earlier start has finished every case."""
        return all(self._blank(case).key in self.reusable for case in self.cases)

    def run(self, listener: Listener) -> None:
        """Run the cases in order; with several jobs, that many at a time."""
        for group in self._groups():
            if self.plan.jobs == 1:
                for number in group:
                    self._step(number, listener)
            else:
                self._run_together(group, listener)

    def _run_together(self, group: list[int], listener: Listener) -> None:
        pool = ThreadPoolExecutor(self.plan.jobs)
        try:
            list(pool.map(lambda number: self._step(number, listener), group))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            self.children.stop()
            raise
        finally:
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
        if self.plan.protocol == "as-printed" and self.plan.jobs > 1:
            yield [n for n in numbers if self.cases[n].variant.method == REFERENCE]
            yield [n for n in numbers if self.cases[n].variant.method != REFERENCE]
        else:
            yield list(numbers)

    def _step(self, number: int, listener: Listener) -> None:
        """One case: taken over from an earlier start, or run now and put on disk."""
        case = self.cases[number]
        listener(case, None)
        blank = self._blank(case)
        kept = self.reusable.get(blank.key)
        if kept is not None and not self.store.has_result(kept):
            kept = None
        record = kept or self._compute(case, blank)
        with self.lock:
            self.done[number] = record  # before the disk: an interrupt between the two must not lose it
            if kept is None:
                self.store.append(record)
            if case.variant.method == REFERENCE and record.n_output:
                self.reached.setdefault(case.group, record.n_output)
            listener(case, record, reused=kept is not None)

    def _blank(self, case: Case) -> Record:
        """The record of a case before it is run."""
        given = self._input(case)
        asked = target_from_reduction(len(self.models[case.model]), case.reduction)
        if self.plan.protocol == "as-printed" and case.variant.method != REFERENCE:
            asked = self.reached.get(case.group, asked)
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
        conditions = [self.plan.metrics, self.plan.refine, self.plan.threads]
        clouds = [self._input(case).sha256, self._clean(case).sha256]
        key = case_key(record, [*clouds, *conditions, self.versions[record.method]], self.plan.metrics)
        return replace(record, key=key)

    def _compute(self, case: Case, blank: Record) -> Record:
        missing = METHODS.missing(blank.method)
        if missing:
            return replace(blank, status="skipped", message=missing)
        if blank.target_count > blank.n_input:
            sentence = f"{blank.target_count} points asked of an input of {blank.n_input}."
            return replace(blank, status="skipped", message=sentence)
        with self._exchange() as folder:
            result = folder / "result.npz" if case.repeat == 0 else None
            answer = self._answer(case, self._request(case, blank, result), folder)
            record = answer.record
            if answer.trouble == "output":
                self.store.check_room(12 * record.n_input + 32 * (record.n_output or 0))
            if result is None or not result.exists() or not record.cloud_sha256:
                return record
            return self.store.keep_result(result, record, _cloud_name(case, record))

    @contextmanager
    def _exchange(self) -> Iterator[Path]:
        """A folder for one child process."""
        folder = self.store.exchange()
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _answer(self, case: Case, request: Request, folder: Path) -> Answer:
        """Run a request, once more and alone where another case has changed the clouds on the disk."""
        with self.places:
            answer = self._run_case(request, folder)
        if answer.trouble == "input":
            with self._all_places():
                self._clean(case).write()
                self._input(case).write()
                answer = self._run_case(request, folder)
        return answer

    @contextmanager
    def _all_places(self) -> Iterator[None]:
        """A time in which no other case runs."""
        with self.alone:
            for _ in range(self.plan.jobs):
                self.places.acquire()
        try:
            yield
        finally:
            self.places.release(self.plan.jobs)

    def _run_case(self, request: Request, folder: Path) -> Answer:
        return run_case(
            self.children,
            request,
            folder,
            time_limit_s=self.plan.time_limit_s,
            memory_limit_mib=self.plan.memory_limit_mib,
            threads=self.plan.threads,
        )

    def _request(self, case: Case, blank: Record, result: Path | None, *, trial: bool = False) -> Request:
        given, clean = self._input(case), self._clean(case)
        return Request(
            record=blank,
            input=str(given.path.resolve()),
            input_sha256=given.sha256,
            clean=str(clean.path.resolve()) if clean is not given else "",
            clean_sha256=clean.sha256,
            output=str(result) if result else "",
            settings=case.variant.settings,
            entropy=seed_entropy(case.seed, case.repeat, blank.method, given.model),
            metrics=list(self.plan.metrics),
            refine=self.plan.refine,
            trial=trial,
        )

    def _clean(self, case: Case) -> Input:
        """The cloud that a case's result is measured against."""
        return self._written(case.model, CLEAN, 0)

    def _input(self, case: Case) -> Input:
        """The cloud that a case is given; perturbed ones are made once per seed."""
        clean = case.perturbation == CLEAN
        return self._written(case.model, case.perturbation, 0 if clean else case.seed)

    def _written(self, model: str, perturbation: Perturbation, seed: int) -> Input:
        key = (model, perturbation, seed)
        if key not in self.inputs:
            cloud = self.models[model]
            suffix = "" if perturbation == CLEAN else f"~{perturbation.kind}-{perturbation.level:g}-s{seed}"
            name = file_name(cloud.name) + suffix
            self.inputs[key] = self.store.write_input(name, lambda: perturb(cloud, perturbation, seed))
        return self.inputs[key]

    def _head(self) -> dict[str, object]:
        inputs = dict(self.earlier.inputs) if self.earlier else {}
        inputs |= {given.path.stem: given.facts() for given in self.inputs.values()}
        environment = capture([v.method for v in self.plan.variants], self.plan.threads)
        return {"plan": self.plan.to_dict(), "environment": environment, "inputs": inputs}


def _cloud_name(case: Case, record: Record) -> str:
    parts = [record.model, case.perturbation.label, record.variant, f"{case.reduction:g}", f"s{case.seed}"]
    return "~".join(file_name(part) for part in parts if part)
