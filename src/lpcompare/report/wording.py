"""Numbers as people read them: three digits, the unit that fits, lists with an "and"."""

from __future__ import annotations

import math
from collections.abc import Sequence

from lpcompare.report.columns import Heading

_SMALL = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def number(value: float) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if not math.isfinite(value):
        return "n/a"
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if size >= 2:
        return f"{value:,.0f}"
    return f"{value:.{2 - size}f}" if size >= -5 else f"{value:.2e}"


def seconds(value: float) -> str:
    """A time with three digits, in ms below one second and in s above."""
    if not math.isfinite(value):
        return "n/a"
    return f"{number(1000 * value)} ms" if value < 0.9995 else f"{number(value)} s"


def tau(value: float) -> str:
    """A correlation with two decimals and a true minus sign."""
    return f"{value:.2f}".replace("-0.00", "0.00").replace("-", "−") if math.isfinite(value) else "n/a"


def percent(share: float) -> str:
    """A share as a percentage: 0.7 is 70 %."""
    return f"{100 * share:.6g} %"


def quantity(value: float, heading: Heading) -> str:
    """A value of a column, with its unit where the number alone does not say it."""
    if heading.unit == "s":
        return seconds(value)
    if heading.unit == "points":
        return f"{value:,.0f}" if math.isfinite(value) else "n/a"
    return number(value)


def listing(names: Sequence[str]) -> str:
    """Join names with commas and an "and"."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def count(n: int, noun: str) -> str:
    """A count with its noun: "one case", "14 methods"."""
    spelled = _SMALL[n] if 0 <= n < len(_SMALL) else f"{n:,}"
    return f"{spelled} {noun}{'' if n == 1 else 's'}"
