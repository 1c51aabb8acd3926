"""The errors of lpcompare, each also a builtin so that it can be caught without importing this module.

::

    LpcompareError
    ├── InputError (ValueError)          an argument, a cloud or a file that cannot be worked on
    │   └── NotApplicable                a method declines this input; the harness writes `skipped`
    ├── UnknownName (LookupError)        no method, metric, model or setting of that name
    ├── Unavailable (ImportError)        a package or system library is missing; the harness writes `skipped`
    ├── SolverError (RuntimeError)       the solver ended without a usable selection
    ├── MethodError (RuntimeError)       a method broke a promise: wrong count, no subset, a changed input
    └── ModelDataError (OSError)         a model could not be fetched, checked or read

`PointsLeftOut` is the one warning of its own.
A message names the thing, the value received, what is allowed and what to do.
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST_TEXT = 1000


def printable(text: str, limit: int = LONGEST_TEXT) -> str:
    """A text in one line: control characters and lone surrogates become spaces, what is too long is cut."""
    short = text if len(text) <= limit else f"{text[: limit - 2]}.."
    return short if short.isprintable() else "".join(c if c.isprintable() else " " for c in short)


class LpcompareError(Exception):
    """Base class of every error that lpcompare raises on purpose."""


class InputError(LpcompareError, ValueError):
    """An argument, a cloud or a file that cannot be worked on."""


class NotApplicable(InputError):  # noqa: N818 - it is a refusal with a reason, not a fault
    """A method declines this input for a stated reason, such as a missing mesh."""


_MANY = 15
"""Names that are all listed in a message, even where one is nearly the one given."""


class UnknownName(LpcompareError, LookupError):  # noqa: N818 - the tree of the design
    """A name that is not registered."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        known = sorted(known)
        near = get_close_matches(name, known, n=3)
        hint = f" Did you mean {' or '.join(map(repr, near))}?" if near else ""
        there_is = f" Known: {', '.join(known)}." if known else " There is none."
        listed = "" if near and len(known) > _MANY else there_is
        super().__init__(f"Unknown {kind} {name!r}.{hint}{listed}")


class Unavailable(LpcompareError, ImportError):  # noqa: N818 - the tree of the design
    """A package or a system library that is needed is not installed."""


class SolverError(LpcompareError, RuntimeError):
    """The solver ended without a usable selection."""


class MethodError(LpcompareError, RuntimeError):
    """A method returned what it must not return, or changed its input."""


class PointsLeftOut(UserWarning):
    """Points without finite coordinates do not count in what is returned."""


class ModelDataError(LpcompareError, OSError):
    """A model could not be fetched, checked or read."""
