"""Errors against the amount of damage to the input, per model, reduction and kind of damage."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from statistics import fmean
from typing import Any

from lpcompare.benchmark.record import Record
from lpcompare.report.cells import method_name

Curves = dict[str, dict[float, float]]

LEVELS = {
    "noise": "Noise: standard deviation, in mean spacings",
    "outliers": "Outliers: points added, as a share of the cloud",
    "uneven": "Uneven: share of points gone at the thin end",
    "missing": "Missing: share of points cut out as one ball",
}
"""What the level of each kind says."""


@dataclass(frozen=True)
class Damage:
    """One kind of damage to one model at one reduction.

    Attributes
    ----------
    model : str
    reduction : float
    kind : str
    curves : dict
        Method -> level -> mean eq. 27 error over seeds and repeats, in % of the diagonal; level 0 is clean,
        NaN has no result.
    """

    model: str
    reduction: float
    kind: str
    curves: Curves

    @property
    def errors(self) -> list[float]:
        """Every error that there is."""
        return [error for curve in self.curves.values() for error in curve.values() if math.isfinite(error)]


def gather_damage(records: Iterable[Record]) -> list[Damage]:
    """Every kind of damage of a run, in the order of its records; errors are against the clean cloud."""
    records = list(records)
    kinds = dict.fromkeys(r.perturbation for r in records if r.perturbation != "none")
    shapes = dict.fromkeys((r.model, r.reduction) for r in records)
    every = (Damage(*shape, kind, damage_curves(records, *shape, kind)) for shape in shapes for kind in kinds)
    return [damage for damage in every if damage.errors]


def damage_curves(records: Iterable[Record], model: str, reduction: float, kind: str) -> Curves:
    """The curves of one model, reduction and kind of damage."""
    values: dict[str, dict[float, list[float]]] = {}
    for r in records:
        if (r.model, r.reduction) == (model, reduction) and r.perturbation in ("none", kind):
            error = r.metrics.get("plane_error_pct", math.nan) if r.status == "ok" else math.nan
            values.setdefault(method_name(r), {}).setdefault(r.perturbation_level, []).append(error)
    return {
        method: {level: fmean(errors) for level, errors in sorted(levels.items())}
        for method, levels in values.items()
    }


def collect_damage(records: Iterable[Record]) -> dict[str, Any]:
    """What the page shows of the damaged inputs.

    Returns
    -------
    dict
        JSON-ready: ``panels``, whose curves are lists of [level, error] where there is a result, and the
        ``models``, ``reductions`` and ``kinds`` with their captions to choose from, none where nothing was
        damaged; ``blind``, the methods that saw no outlier: added points belong to no face of the mesh that
        they work on.
    """
    records = list(records)
    panels = [_panel(damage) for damage in gather_damage(records)]
    blind = [method_name(r) for r in records if r.needs_mesh and r.perturbation == "outliers"]
    return {
        "panels": panels,
        "models": list(dict.fromkeys(panel["model"] for panel in panels)),
        "reductions": sorted({panel["reduction"] for panel in panels}),
        "kinds": {panel["kind"]: LEVELS[panel["kind"]] for panel in panels},
        "blind": list(dict.fromkeys(blind)),
    }


def _panel(damage: Damage) -> dict[str, Any]:
    known = {m: [p for p in c.items() if math.isfinite(p[1])] for m, c in damage.curves.items()}
    return asdict(damage) | {"curves": {method: points for method, points in known.items() if points}}
