"""What the numbers of a run are called, in which unit they stand, and which direction is better."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache

from lpcompare.errors import Unavailable
from lpcompare.registry import METRICS

ERROR = "plane_error_pct"
"""The column of eq. 27, by which the report speaks of "the error"."""

RUNTIME = "runtime_s"


@dataclass(frozen=True)
class Heading:
    """A column of the report.

    Attributes
    ----------
    key : str
        Name in run.json and in the CSV.
    title : str
        For people.
    unit : str
        "s", "MiB", "points", or a unit of `lpcompare.types.Column`.
    better : str
        "lower", "higher", or "" where neither is, or nobody says: the column of a metric that is gone.
    alias : str
        The column that this one follows from; ranks and ratios do not count it.
    """

    key: str
    title: str
    unit: str = ""
    better: str = "lower"
    alias: str = ""

    @property
    def label(self) -> str:
        """Title and unit, as on an axis; a title that counts points has said so."""
        return f"{self.title} [{self.unit}]" if self.unit not in ("", "points") else self.title


MEASURED = {
    h.key: h
    for h in (
        Heading("n_output", "Points kept", "points", ""),
        Heading(RUNTIME, "Runtime", "s"),
        Heading("calibration_s", "Search for the setting that gives the count, not timed", "s"),
        Heading("peak_memory_mib", "Peak memory", "MiB"),
    )
}


def headings(keys: Iterable[str]) -> dict[str, Heading]:
    """A heading for every key: eq. 27 first, then the other metrics by name, as their files describe them."""
    known = MEASURED | _metric_headings()
    rest = sorted(set(keys) - set(MEASURED) - {ERROR})
    ordered = [key for key in (ERROR, *MEASURED, *rest) if key in set(keys)]
    return {key: known.get(key, Heading(key, key, better="")) for key in ordered}


def metric_keys(known: Mapping[str, Heading]) -> list[str]:
    """The keys that judge the points rather than the cost of finding them, each witness once: no aliases."""
    return [key for key, heading in known.items() if key not in MEASURED and not heading.alias]


@cache
def _metric_headings() -> dict[str, Heading]:
    found = {}
    for name in METRICS:
        try:
            declared = METRICS.module(name).COLUMNS
        except Unavailable:
            continue
        found |= {key: Heading(key, c.title, c.unit, c.better, c.alias) for key, c in declared.items()}
    return found
