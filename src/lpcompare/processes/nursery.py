"""The process that prepared children are forked from: it has imported once what each of them needs.

`lpcompare.processes.children` runs it as a program, on Linux. For each order it forks a guard
(`lpcompare.processes.guard`), and the guard forks the child. It ends when the process that started it is gone.
"""

import gc
import json
import os
import random
import select
import signal
import socket
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from typing import Any, NoReturn

from lpcompare.processes import guard

_LOOK_S = 0.2
_MESSAGE_BYTES = 2**16


def main() -> None:
    """Prepare the module that the second argument names with the third; fork a guard for each order."""
    guard.prctl(guard.PR_SET_PDEATHSIG, signal.SIGKILL)  # the end of ``orders`` is looked at later
    orders = socket.socket(fileno=int(sys.argv[1]))
    module = import_module(sys.argv[2])
    with suppress(Exception):  # a child meets the same, and has a row for it
        module.prepare(*json.loads(sys.argv[3]))
    gc.collect()
    gc.freeze()
    guard.prctl(guard.PR_SET_PDEATHSIG, 0)
    guard.prctl(guard.PR_SET_CHILD_SUBREAPER, 1)
    guards: set[int] = set()
    while True:
        ready = select.select([orders], [], [], _LOOK_S if guards else None)[0]
        _bury(guards)
        if ready:
            message, files, *_ = socket.recv_fds(orders, _MESSAGE_BYTES, 1)
            if not message:
                return
            pid = os.fork()
            if not pid:
                orders.close()
                _guard(json.loads(message), socket.socket(fileno=files[0]), module)
            os.close(files[0])
            guards.add(pid)


def _bury(guards: set[int]) -> None:
    """Take note of guards that have ended; end what those that were killed have left to this process."""
    for pid in tuple(guards):
        if os.waitpid(pid, os.WNOHANG)[0]:
            guards.discard(pid)
    if any(pid not in guards for pid in guard.children(os.getpid())):
        guard.end_processes(
            lambda: [
                pid
                for left in guard.children(os.getpid())
                if left not in guards
                for pid in (left, *guard.descendants(left))
            ]
        )


def _guard(order: dict[str, Any], parent: socket.socket, module: Any) -> NoReturn:
    """Become a guard: say who this is, and watch a child that runs the module's ``main``."""

    def work() -> None:
        parent.close()
        os.environ["TMPDIR"] = tempfile.tempdir = order["folder"]
        random.seed()
        sys.modules["numpy"].random.seed()
        module.main(*order["arguments"])

    parent.sendall(b"%d\n" % os.getpid())
    guard.guard(order, lambda: parent.recv(1), parent.sendall, work)


if __name__ == "__main__":
    main()
