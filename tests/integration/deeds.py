"""What misbehaving methods do: the body of each, its status, and how its message begins.

A body may use ``points``, ``target_count``, ``rng`` and the names of `HEAD`; ``honest()`` is a good result.
``CALIBRATIONS`` are the bodies of functions ``calibrate`` instead, before an honest call.
"""

from textwrap import indent

HEAD = '''
"""Misbehaves."""
import ctypes, gc, json, mmap, os, random, resource, shutil, signal, subprocess, sys, threading, time, warnings
from pathlib import Path
import numpy as np
from lpcompare.errors import InputError, NotApplicable, SolverError, Unavailable
from lpcompare.types import Simplification, Traits

TRAITS = Traits(wraps="numpy", moves_points={moves})


def honest(points, target_count, info=None, timings=None):
    rows = np.arange(target_count)
    return Simplification(points[rows].copy(), {rows}, timings or {{}}, info or {{}})


class Odd:
    def __str__(self):
        raise RuntimeError("no text")
    __repr__ = items = __iter__ = __len__ = __float__ = __getitem__ = __str__

    def __reduce__(self):
        return os.system, ("touch pickled",)


class OddError(Exception):
    def __str__(self):
        raise RuntimeError("no text")


def fork_daemon():
    if not os.fork():
        os.setsid()
        if not os.fork():
            time.sleep(600)
        os._exit(0)
'''

_KEEP = "\nreturn honest(points, target_count)"

BODIES = {
    # what it returns
    "returns_none": ("return None", "failed", "The method returned a NoneType"),
    "returns_an_array": ("return points[:target_count]", "failed", "The method returned a ndarray"),
    "returns_a_generator": ("yield points", "failed", "The method returned a generator"),
    "returns_a_class": ("return Simplification", "failed", "The method returned a type"),
    "returns_float32": (
        "return Simplification(points[:target_count].astype('f4'), np.arange(target_count))",
        "failed",
        "The points are float32",
    ),
    "returns_objects": (
        "return Simplification(points[:target_count].astype(object), np.arange(target_count))",
        "failed",
        "The points are object",
    ),
    "returns_complex": (
        "return Simplification(points[:target_count] + 0j, np.arange(target_count))",
        "failed",
        "The points are complex128",
    ),
    "returns_lists": (
        "return Simplification(points[:target_count].tolist(), np.arange(target_count))",
        "failed",
        "The points have shape",
    ),
    "returns_two_columns": (
        "return Simplification(points[:target_count, :2], np.arange(target_count))",
        "failed",
        "The points have shape",
    ),
    "returns_no_points": ("return Simplification(points[:0], np.arange(0))", "failed", "The method returned no"),
    "returns_more": ("return honest(points, target_count + 1)", "failed", "The method returned 101 points"),
    "returns_fewer": ("return honest(points, target_count - 9)", "failed", "The method returned 91 points"),
    "returns_all_twice": (
        "return Simplification(np.vstack([points, points]))",
        "failed",
        "The method returned 1000 points, more",
    ),
    "returns_infinity": (
        "return Simplification(np.full((target_count, 3), np.inf), np.arange(target_count))",
        "failed",
        "100 of the 100 points",
    ),
    "names_no_rows": (
        "return Simplification(points[:target_count].copy())",
        "failed",
        "The method names no rows",
    ),
    "names_rows_beyond": (
        "return Simplification(points[:target_count], np.arange(target_count) + 450)",
        "failed",
        "The indices are not ascending",
    ),
    "names_rows_below": (
        "return Simplification(points[:target_count], np.arange(target_count) - 5)",
        "failed",
        "The indices are not ascending",
    ),
    "names_rows_backwards": (
        "r = np.arange(target_count)[::-1]; return Simplification(points[r], r)",
        "failed",
        "The indices are not ascending",
    ),
    "names_rows_as_floats": (
        "return Simplification(points[:target_count], np.arange(target_count) * 1.0)",
        "failed",
        "The indices are float64",
    ),
    "names_rows_as_text": (
        "return Simplification(points[:target_count], np.array(['a'] * target_count))",
        "failed",
        "The indices are <U1",
    ),
    # what it does to its input, to the files of the run, to its process
    "changes_its_points": ("points *= 2" + _KEEP, "failed", "The method changed its input."),
    "overwrites_the_inputs": (
        "for p in Path('../../clouds').glob('ball.npz'): p.write_bytes(b'junk')" + _KEEP,
        "ok",
        "",
    ),
    "exchanges_the_inputs": (
        "for p in Path('../../clouds').glob('ball.npz'): np.savez(p, points=np.eye(3))" + _KEEP,
        "ok",
        "",
    ),
    "deletes_the_inputs": (
        "for p in Path('../../clouds').glob('ball.npz'): p.unlink()" + _KEEP,
        "ok",
        "",
    ),
    "deletes_the_inputs_again_and_again": (
        "for _ in range(300):\n"
        "    for p in Path('../../clouds').glob('ball.npz'): p.unlink(missing_ok=True)\n"
        "    time.sleep(0.01)" + _KEEP,
        "ok",
        "",
    ),
    "deletes_its_folder": ("shutil.rmtree(os.getcwd())" + _KEEP, "ok", ""),
    "deletes_the_records": ("Path('../../records.jsonl').unlink()" + _KEEP, "ok", ""),
    "litters": (
        "for n in range(300): Path(f'{n}.py').write_text('x')\nPath('json.py').write_text('1/0')" + _KEEP,
        "ok",
        "",
    ),
    "goes_elsewhere": ("os.chdir('/'); os.environ.clear()" + _KEEP, "ok", ""),
    "forbids_all_files": (
        "resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)); signal.signal(signal.SIGXFSZ, signal.SIG_IGN)" + _KEEP,
        "failed",
        "The process could not write its result",
    ),
    "closes_everything": ("os.closerange(0, 256)" + _KEEP, "failed", "The process ended with exit code"),
    "writes_into_everything": (
        "for n in range(3, 30):\n    try: os.write(n, b'\\x00{\"token\": 1}\\n{\"half')\n    except OSError: pass"
        + _KEEP,
        "ok",
        "",
    ),
    "forges_an_answer": (
        "for n in range(3, 30):\n"
        "    try: os.write(n, b'\\n{\"token\":\"x\",\"finished\":true,\"record\":{\"model\":\"ball\"}}\\n')\n"
        "    except OSError: pass\nos._exit(0)",
        "failed",
        "The process ended with exit code 0 and no result in the call",
    ),
    "replaces_the_clock": ("time.perf_counter = lambda: float('nan'); gc.disable()" + _KEEP, "ok", ""),
    "turns_warnings_into_errors": ("warnings.simplefilter('error'); np.seterr(all='raise')" + _KEEP, "ok", ""),
    "leaves_no_recursion": ("sys.setrecursionlimit(60)" + _KEEP, "any", ""),
    "removes_the_streams": ("sys.stdout = sys.stderr = None" + _KEEP, "ok", ""),
    "prints_without_end": (
        "sys.stdout.write('x' * 10**7); os.write(2, b'y' * 10**7)" + _KEEP,
        "ok",
        "",
    ),
    # what it raises
    "raises_a_huge_text": ("raise ValueError('x' * 30_000_000)", "failed", "ValueError: xxx"),
    "raises_surrogates": ("raise ValueError('bad \\ud800 text')", "failed", "ValueError: bad   text"),
    "raises_terminal_codes": ("raise ValueError('\\x1b[2J\\x07gone\\nnext')", "failed", "ValueError:  [2J gone"),
    "raises_without_text": ("raise OddError", "failed", "OddError: no text."),
    "raises_an_exit": ("sys.exit(0)", "failed", "SystemExit: 0."),
    "raises_an_interrupt": ("raise KeyboardInterrupt", "failed", "KeyboardInterrupt: ."),
    "raises_a_base": ("raise BaseException('odd')", "failed", "BaseException: odd."),
    "raises_a_group": (
        "raise ExceptionGroup('many', [ValueError(str(n)) for n in range(1000)])",
        "failed",
        "ExceptionGroup: many",
    ),
    "raises_a_memory_error": ("raise MemoryError", "failed", "Out of memory"),
    "recurses": ("f = lambda: f()\nf()", "failed", "RecursionError"),
    "misses_a_package": ("import nosuchpackage", "failed", "ModuleNotFoundError"),
    "declines_oddly": ("raise NotApplicable('\\ud800' * 5000)", "skipped", "   "),
    "is_not_available": ("raise Unavailable('not today')", "skipped", "not today"),
    "has_no_solution": ("raise SolverError('no bound')", "failed", "no bound"),
    # what it says beside the points
    "times_nan": ("return honest(points, target_count, timings={'a': float('nan'), 'b': float('inf')})", "ok", ""),
    "times_text": ("return honest(points, target_count, timings={'a': 'soon'})", "failed", "ValueError"),
    "times_nothing": ("return honest(points, target_count, timings=3)", "failed", "AttributeError"),
    "times_oddly": ("return honest(points, target_count, timings=Odd())", "failed", "RuntimeError"),
    "names_stages_oddly": (
        "return honest(points, target_count, timings={'\\ud800\\n': 1.0, 'x' * 10**6: 2.0, 3: 4.0})",
        "ok",
        "",
    ),
    "tells_objects": ("return honest(points, target_count, info={'a': Odd(), 'b': [Odd()], 'c': 1})", "ok", ""),
    "tells_nan": ("return honest(points, target_count, info={'a': float('nan'), 'b': -np.float32('inf')})", "ok", ""),
    "tells_too_much": (
        "return honest(points, target_count, info={str(n): 'x' * 10**4 for n in range(10**4)})",
        "ok",
        "",
    ),
    "tells_huge_numbers": ("return honest(points, target_count, info={'a': 10**5000, 'b': 2**64})", "ok", ""),
    "tells_surrogates": ("return honest(points, target_count, info={'\\udfff': '\\ud800\\x00'})", "ok", ""),
    "tells_pickles": (
        "return honest(points, target_count, info={'labels': np.array([Odd()] * len(points), dtype=object)})",
        "ok",
        "",
    ),
    # how it ends, or does not
    "exits_with_74": ("os._exit(74)", "failed", "The process ended with exit code 74 and no result in the call"),
    "exits_with_0": ("os._exit(0)", "failed", "The process ended with exit code 0 and no result in the call"),
    "kills_itself": ("os.kill(os.getpid(), signal.SIGKILL)", "failed", "The process was killed from outside"),
    "ends_by_a_signal": (
        "signal.signal(signal.SIGUSR1, signal.SIG_DFL); os.kill(os.getpid(), signal.SIGUSR1)",
        "failed",
        "The process crashed with SIGUSR1",
    ),
    "kills_its_guard": (
        "os.kill(os.getppid(), signal.SIGKILL); time.sleep(60)",
        "failed",
        "The process that watches the case was killed",
    ),
    "stops_itself": ("os.kill(os.getpid(), signal.SIGSTOP)", "timeout", "Killed in the call"),
    "holds_the_lock_of_python": (
        "import re\nre.match(r'(a*)*b', 'a' * 64)",
        "timeout",
        "Killed in the call",
    ),
    "leaves_threads": (
        "threading.Thread(target=time.sleep, args=(600,)).start()\n"
        "import atexit; atexit.register(time.sleep, 600)" + _KEEP,
        "ok",
        "",
    ),
    "leaves_a_daemon": ("fork_daemon()" + _KEEP, "ok", ""),
    "leaves_many_processes": (
        "for n in range(100): subprocess.Popen(['sleep', '600'], start_new_session=True)" + _KEEP,
        "ok",
        "",
    ),
    "goes_on_twice": ("os.fork()" + _KEEP, "any", ""),
    "shares_too_much": (
        "m = mmap.mmap(-1, 1200 << 20)\nfor n in range(0, 1200 << 20, 4096): m[n] = 1\ntime.sleep(60)",
        "failed",
        "Out of memory (limit 1000 MiB) in the call",
    ),
    "spreads_too_much": (
        "for n in range(4):\n    if not os.fork(): break\nb = b'x' * (400 << 20)\ntime.sleep(60)",
        "failed",
        "Out of memory (limit 1000 MiB) in the call",
    ),
}  # fmt: skip

CALIBRATIONS = {
    "calibrates_nan": ("return {'cell': float('nan')}", "ok", ""),
    "calibrates_objects": ("return {'cell': [1, 2], 'other': np.float32(3)}", "ok", ""),
    "calibrates_nothing": ("return None", "failed", "TypeError"),
    "calibrates_oddly": ("return {'cell': Odd()}", "failed", "RuntimeError"),
    "calibrates_by_an_exit": ("os._exit(0)", "failed", "The process ended with exit code 0 and no result"),
    "calibrates_a_daemon": ("fork_daemon(); return {'cell': 1.0}", "ok", ""),
    "calibrates_a_changed_input": ("points += 1; return {}", "failed", "The method changed its input."),
}

DEEDS = {**BODIES, **CALIBRATIONS}

_GUARD = "if len(points) != 500:\n    raise NotApplicable('the warm-up goes in peace')\n"


def source(name):
    """The file of a method."""
    body = _GUARD + DEEDS[name][0]
    head = HEAD.strip().format(moves="False", rows="rows")
    arguments = "(points, target_count, *, rng"
    if name in BODIES:
        return f"{head}\n\ndef {name}{arguments}):\n{indent(body, '    ')}\n"
    call = f"def {name}{arguments}, cell: float = 0.0):\n    return honest(points, target_count)\n"
    return f"{head}\n\ndef calibrate{arguments}):\n{indent(body, '    ')}\n\n\n{call}"
