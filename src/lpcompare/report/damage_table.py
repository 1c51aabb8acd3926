"""Errors against the amount of damage to the input: one table per model, reduction and kind of damage."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from statistics import median

from lpcompare.benchmark.record import Record
from lpcompare.report.alignment import WIDTH, align, cut, notes
from lpcompare.report.damage import Curves, gather_damage

_PAPER = "lp_printed"
_CLAIMED = ("noise", "outliers")
"""What the paper's abstract calls its method robust to, without a measurement."""


def format_damage(records: Iterable[Record]) -> list[str]:
    """Every table of the damaged inputs; errors are measured against the clean cloud."""
    records = list(records)
    tables = [
        _table(
            f"{d.model} with {d.kind}: {100 * d.reduction:g} % removed, eq. 27 error in % of the diagonal",
            d.curves,
            claimed=d.kind in _CLAIMED,
        )
        for d in gather_damage(records)
    ]
    return [
        *tables,
        *["\n".join(lines) for lines in [notes(r for r in records if r.perturbation != "none")] if lines],
    ]


def _table(title: str, curves: Curves, *, claimed: bool) -> str:
    levels = sorted({level for curve in curves.values() for level in curve})
    head = ("method", *(f"{level:g}" if level else "clean" for level in levels), "growth")
    ordered = sorted(curves.items(), key=lambda item: _rank(item[1].get(levels[-1], math.nan)))
    rows = [
        (cut(name), *(_cell(curve.get(level, math.nan)) for level in levels), _growth_cell(curve, levels[-1]))
        for name, curve in ordered
    ]
    lines = align([head, *rows])
    growths = {n: g for n, c in curves.items() if math.isfinite(g := growth(c, levels[-1]))}
    words = [*_extremes(growths, levels[-1]), *(_claim(curves, growths, levels[-1]) if claimed else [])]
    return "\n".join([title, lines[0], "-" * max(map(len, lines)), *lines[1:], *words])


def growth(curve: dict[float, float], level: float) -> float:
    """Error at a level over the error on the clean input; NaN where one is missing."""
    clean = curve.get(0.0, math.nan)
    return curve.get(level, math.nan) / clean if clean > 0 else math.nan


def _extremes(known: dict[str, float], level: float) -> list[str]:
    """Who suffers least and most at the largest level."""
    if len(known) < 2:
        return []
    least, most = min(known, key=known.__getitem__), max(known, key=known.__getitem__)
    text = (
        f"At {level:g} the error of {least} grows least ({known[least]:.2f} times the clean one), "
        f"that of {most} most ({known[most]:.2f} times)."
    )
    return textwrap.wrap(text, WIDTH)


def _claim(curves: Curves, known: dict[str, float], level: float) -> list[str]:
    """Whether the paper's method is robust, as its abstract says: less growth and error than most others.

    Growth alone would praise a method whose error is large before any damage.
    """
    others = [name for name in known if name != _PAPER]
    if _PAPER not in known or not others:
        return []
    own, usual = known[_PAPER], median(known[name] for name in others)
    error, errors = curves[_PAPER][level], median(curves[name][level] for name in others)
    text = (
        f"The paper calls its method robust: at {level:g} the error of {_PAPER} grows {own:.2f} times "
        f"(median of the other methods {usual:.2f}) and is {error:.4f} (median {errors:.4f}); the claim is "
        f"{'confirmed' if own < usual and error < errors else 'refuted'} here, as it takes both below."
    )
    return textwrap.wrap(text, WIDTH)


def _cell(error: float) -> str:
    return f"{error:.4f}" if math.isfinite(error) else "-"


def _growth_cell(curve: dict[float, float], level: float) -> str:
    value = growth(curve, level)
    return f"{value:.2f}x" if math.isfinite(value) else "-"


def _rank(error: float) -> float:
    return error if math.isfinite(error) else math.inf
