"""The graph of tasks: functions that leave one file each; run here, one after the other, or by Dask."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

from lpcompare.errors import InputError, LpcompareError
from lpcompare.progress import Callback
from lpcompare.tiles.job import Job

_RETRIES = 3


@dataclass(frozen=True)
class Task:
    """A step for one block or tile.

    Attributes
    ----------
    function : callable
        Called with the job and the number. It writes ``output``, whole or not at all, and always the same.
    number : int
        Of the block or tile.
    output : Path
        The task is done when it exists.
    after : tuple of Path
        Outputs of tasks of the same stage that must exist before.
    """

    function: Callable[[Job, int], None]
    number: int
    output: Path
    after: tuple[Path, ...] = ()


@dataclass
class Executor:
    """Runs stages, in this process or on the workers of a Dask client.

    Attributes
    ----------
    client : distributed.Client, optional
        The workers must see the spill folder and the inputs under the same paths.
    callback : callable, optional
        Called with (stage, done, total).
    n_run : dict of str to int
        Tasks that ran, by stage; the others had been done before.
    """

    client: Any = None
    callback: Callback | None = None
    n_run: dict[str, int] = field(default_factory=dict)

    def run(self, stage: str, job: Job, tasks: Sequence[Task]) -> None:
        """Run the tasks whose outputs are missing, in any order that respects ``after``."""
        missing = _ordered([task for task in tasks if not task.output.exists()])
        self.n_run[stage] = len(missing)
        done = len(tasks) - len(missing)
        finished = self._on_workers(job, missing) if self.client is not None else _here(job, missing)
        for _ in finished:
            done += 1
            if self.callback:
                self.callback(stage, done, len(tasks))

    def _on_workers(self, job: Job, tasks: Sequence[Task]) -> Iterable[None]:
        from distributed import CancelledError, KilledWorker, as_completed

        futures: dict[Path, Any] = {}
        for task in tasks:
            before = [futures[path] for path in task.after if path in futures]
            futures[task.output] = self.client.submit(_run, job, task, before, pure=False, retries=_RETRIES)
        try:
            for future in as_completed(list(futures.values())):
                fault = future.result()
                if fault is not None:
                    raise fault
                yield
        except KilledWorker as error:
            raise InputError(
                "A task ended its workers again and again; give them more memory or more --tiles."
            ) from error
        except (CancelledError, OSError) as error:
            raise InputError("The Dask scheduler is lost; start it again.") from error
        finally:
            self.client.cancel(list(futures.values()), force=True)


def _ordered(tasks: Sequence[Task]) -> list[Task]:
    """The tasks, each after those that it waits for."""
    by_output = {task.output: task for task in tasks}
    graph = {task.output: [path for path in task.after if path in by_output] for task in tasks}
    return [by_output[path] for path in TopologicalSorter(graph).static_order()]


def _here(job: Job, tasks: Iterable[Task]) -> Iterable[None]:
    for task in tasks:
        task.function(job, task.number)
        yield


def _run(job: Job, task: Task, before: Sequence[object]) -> LpcompareError | None:
    """Run on a worker; an error with a sentence for people is returned, because trying again would not help."""
    try:
        if not task.output.exists():
            task.function(job, task.number)
    except LpcompareError as error:
        return error
    return None
