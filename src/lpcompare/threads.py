"""How many threads lpcompare may use, and the one loop that uses them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import Event, Lock, Thread
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

Progress = Callable[[int, int], None]
"""Called with (done, total)."""

BLOCK = 4096
"""Rows of a block of `for_blocks`."""


def thread_count() -> int:
    """Threads to use: ``LPCOMPARE_THREADS`` if it is set, else the processors this process may run on."""
    wanted = os.environ.get("LPCOMPARE_THREADS", "")
    if wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def map_in_threads(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    on_done: Progress | None = None,
    cancelled: Event | None = None,
) -> list[Result]:
    """Apply ``function`` to every item in parallel; the results keep the order of the items.

    Parameters
    ----------
    function : callable
        Called once per item, from any thread.
    items : iterable
    on_done : callable, optional
        Called in the calling thread with (items done, items).
    cancelled : threading.Event, optional
        Set when the loop is given up, for items that watch it. They then run outside the calling thread even
        if there is one thread only, because Ctrl-C reaches the calling thread alone.

    Returns
    -------
    list
        One result per item.

    Raises
    ------
    Exception
        What ``function`` raised first, or ``KeyboardInterrupt``. Items that have not begun are dropped and
        those that run are waited for, so that no thread is left behind.
    """
    items = list(items)
    if cancelled is None:
        return _with_helpers(function, items, on_done)
    with ThreadPoolExecutor(max(1, min(thread_count(), len(items)))) as pool:
        futures = [pool.submit(function, item) for item in items]
        try:
            for done, future in enumerate(as_completed(futures), 1):
                future.result()
                if on_done:
                    on_done(done, len(items))
        except BaseException:
            cancelled.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return [future.result() for future in futures]


def for_blocks(
    n_rows: int, work: Callable[[slice], None], progress: Progress | None = None, size: int = BLOCK
) -> None:
    """Call ``work`` for one block of rows after the other, in parallel; the blocks are always the same."""
    map_in_threads(work, [slice(i, min(i + size, n_rows)) for i in range(0, n_rows, size)], progress)


def _with_helpers(
    function: Callable[[Item], Result], items: list[Item], on_done: Progress | None
) -> list[Result]:
    """`map_in_threads` where the calling thread works too: each thread takes the next item that is left."""
    results: dict[int, Result] = {}
    numbers, errors, lock = iter(range(len(items))), list[BaseException](), Lock()

    def work(progress: Progress | None = None) -> None:
        while not errors:
            with lock:
                number = next(numbers, None)
            if number is None:
                return
            results[number] = function(items[number])
            if progress:
                progress(len(results), len(items))

    def help_on() -> None:
        try:
            work()
        except BaseException as error:
            errors.append(error)

    helpers: list[Thread] = []
    try:
        for _ in range(min(thread_count(), len(items)) - 1):
            helper = Thread(target=help_on)
            helper.start()
            helpers.append(helper)
        work(on_done)
        _wait_for(helpers)
    except BaseException as error:
        errors.append(error)
        _wait_for(helpers)
    if errors:
        raise errors[0]
    if on_done and items:
        on_done(len(items), len(items))
    return [results[number] for number in range(len(items))]


def _wait_for(threads: list[Thread]) -> None:
    for thread in threads:
        thread.join()
