"""Dask clusters: one on this machine, or a running one by the address of its scheduler."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from lpcompare.errors import InputError, Unavailable
from lpcompare.processes.children import temporary_folder
from lpcompare.threads import thread_count

_DEATHS = 10
"""Workers that may die at a task before it is given up."""


@contextmanager
def local_client(n_workers: int) -> Iterator[Any]:
    """A client of a new cluster of so many processes on this machine, which ends with the block."""
    distributed = _distributed()
    from dask import config

    threads = str(max(1, thread_count() // n_workers))
    with (
        temporary_folder() as folder,
        config.set({"distributed.scheduler.allowed-failures": _DEATHS, "temporary-directory": str(folder)}),
        distributed.LocalCluster(
            n_workers=n_workers,
            threads_per_worker=1,
            memory_limit=0,
            preload=__name__,
            silence_logs=logging.ERROR,
            dashboard_address="127.0.0.1:0",
            env={"LPCOMPARE_THREADS": threads},
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def dask_setup(_: object) -> None:
    """Leave Ctrl-C, which a terminal sends to every process, to the first one; Dask calls this in a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def remote_client(address: str, timeout: str = "10s") -> Iterator[Any]:
    """A client of a running scheduler; raises `InputError` where it does not answer."""
    distributed = _distributed()
    try:
        client = distributed.Client(address, timeout=timeout)
    except (OSError, ValueError) as error:
        raise InputError(f"The scheduler {address} does not answer ({error}); check its address.") from error
    with client:
        yield client


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise Unavailable(
            "dask and distributed are not installed. Install them with: pip install 'lpcompare[large]'."
        ) from error
    return distributed
