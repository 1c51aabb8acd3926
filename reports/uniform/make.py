"""Make the study of `lp_uniform` and `lp_placed`: thin every model, measure, and write a table and frontier.png.

Run it from the root of the repository::

    python reports/uniform/make.py --models FOLDER [--set development] [--methods lp_uniform ...] [--sweep]

FOLDER holds the files that models.toml names. Results of rivals are kept in reports/local/uniform and not made
again; those of our own methods are made each time. Random choices have fixed seeds.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import runpy
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

import lpcompare as lp

mpl.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
KEPT = HERE.parent / "local" / "uniform"
METRICS = ["plane_error", "surface_distance", "pivoted_distance", "hausdorff", "mean_distance"]
METRICS += ["normal_deviation", "mls_distance"]
OURS = {"lp_uniform": {}, "lp_placed": {}}
RIVALS = ["poisson_disk", "quadric_collapse", "quadric_decimation"]


@dataclass(frozen=True)
class Variant:
    """A method with settings, under the label that tables show."""

    method: str
    settings: dict[str, Any]

    @property
    def label(self) -> str:
        """Method and settings as one word each."""
        words = " ".join(
            f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in self.settings.items()
        )
        return f"{self.method} {words}".strip()


def study() -> dict[str, Any]:
    """What models.toml says."""
    return tomllib.loads((HERE / "models.toml").read_text(encoding="utf-8"))


def load(entry: dict[str, Any], folder: Path) -> lp.PointCloud:
    """A model of the study, cut or thinned as its entry says."""
    if entry.get("simulated"):
        return lp.PointCloud(street(entry["simulated"]), name=entry["name"])
    cloud = lp.read(folder / entry["file"], drop_invalid=True)
    cloud = replace(cloud, name=entry["name"])
    rng = np.random.default_rng(entry.get("seed", 0))
    if "ball" in entry:
        center = cloud.points[rng.integers(len(cloud))]
        squares = ((cloud.points - center) ** 2).sum(axis=1)
        return cloud.take(np.sort(np.argsort(squares, kind="stable")[: entry["ball"]]))
    if "sample" in entry:
        return cloud.take(np.sort(rng.choice(len(cloud), entry["sample"], replace=False)))
    return cloud


def street(seed: int, n_beams: int = 64, n_steps: int = 1000) -> np.ndarray:
    """A frame of a turning laser scanner between facades, cars and poles: density falls with distance."""
    rng = np.random.default_rng(seed)
    rise, turn = np.meshgrid(
        np.radians(np.linspace(-24.8, 2.0, n_beams)), np.linspace(0, 2 * np.pi, n_steps, endpoint=False)
    )
    flat = np.cos(rise)
    rays = np.stack([flat * np.cos(turn), flat * np.sin(turn), np.sin(rise)], axis=-1).reshape(-1, 3)
    eye = np.array([0.0, 0.0, 1.73])
    reach = np.where(rays[:, 2] < -1e-3, -eye[2] / np.minimum(rays[:, 2], -1e-9), np.inf)
    for low, high in boxes(rng):
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (low - eye) / rays, (high - eye) / rays
        enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        reach = np.where((enter <= leave) & (enter > 0), np.minimum(reach, enter), reach)
    seen = reach < 80
    return eye + rays[seen] * (reach[seen] + rng.normal(0, 0.015, seen.sum()))[:, None]


def boxes(rng: np.random.Generator) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Two corners of each car, facade and pole of `street`."""
    for side in (-1, 1):
        x = -60.0
        while x < 60:
            width, front = rng.uniform(6, 18), rng.uniform(12, 15)
            y = sorted((side * front, side * 25.0))
            yield np.array([x, y[0], 0.0]), np.array([x + width, y[1], rng.uniform(5, 12)])
            x += width + rng.uniform(0, 6)
    sizes = [(4.4, 1.8, 1.5)] * 14 + [(0.3, 0.3, 6.0)] * 12
    for length, width, height in sizes:
        x, y = rng.uniform(-30, 30, 2)
        if np.hypot(x, y) > 5:
            yield np.array([x, y, 0.0]), np.array([x + length, y + width, height])


def measured(cloud: lp.PointCloud, reduction: float, variant: Variant) -> dict[str, Any]:
    """One row of the table; a rival's is read where it has been made before."""
    digest = hashlib.sha256(cloud.points.tobytes()).hexdigest()[:16]
    path = KEPT / f"{digest}-{reduction}-{variant.label.replace(' ', '-')}.json"
    if variant.method in RIVALS and path.exists():
        return json.loads(path.read_text(encoding="utf-8"))
    n_keep = round(len(cloud) * (1 - reduction))
    result = lp.simplify(cloud, target_count=n_keep, method=variant.method, **variant.settings)
    info = {k: result.info[k] for k in ("n_clusters", "n_certified", "largest_residual") if k in result.info}
    row = {"model": cloud.name, "reduction": reduction, "method": variant.label, "status": "ok"}
    row |= {"n_input": len(cloud), "n_output": len(result), "info": json.dumps(info)}
    row |= lp.evaluate(cloud, result, metrics=METRICS)
    if variant.method in RIVALS:
        KEPT.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(row), encoding="utf-8")
    return row


def rows(
    entries: list[dict[str, Any]], folder: Path, variants: list[Variant], reductions: list[float]
) -> Iterator[dict[str, Any]]:
    """Every case of the study; methods that need a mesh run where there is one."""
    for entry in entries:
        cloud = load(entry, folder)
        for reduction in reductions:
            for variant in variants:
                if not variant.method.startswith("quadric") or cloud.faces is not None:
                    yield measured(cloud, reduction, variant)


def sweep() -> list[Variant]:
    """The settings of the frontier."""
    return [
        *(Variant("lp_uniform", {"emphasis": word}) for word in ("error", "coverage")),
        *(Variant("lp_uniform", {"n_rounds": rounds}) for rounds in (0, 2, 4, 16)),
        *(Variant("lp_uniform", {"density_tolerance": z}) for z in (0.01, 0.03, 0.1, 1e9)),
        Variant("lp_uniform", {"emphasis": "error", "n_rounds": 16, "density_tolerance": 1e9}),
    ]


def write_rows(path: Path, found: list[dict[str, Any]]) -> None:
    """Write a CSV of all columns."""
    columns = list(dict.fromkeys(key for row in found for key in row))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(found)


def draw_frontier(path: Path) -> None:
    """Plane error against four other measures, each setting of the sweep a point, the default marked."""
    tables = runpy.run_path(str(HERE / "ratios.py"))
    cases = tables["read"](path)
    labels = list(dict.fromkeys(label for rows in cases.values() for label in rows))
    keys = ("surface_distance_pct", "hausdorff_pct", "normal_deviation_deg", "mean_distance_pct")
    figure, axes = plt.subplots(1, 4, figsize=(14, 4.6), layout="constrained")
    for number, label in enumerate(labels, 1):
        found = list(tables["ratios"](cases, label).values())
        means = {k: float(np.exp(np.mean([np.log(r[k]) for r in found]))) for k in tables["COLUMNS"]}
        color = "C1" if label in OURS or label in RIVALS else "C0"
        for axis, key in zip(axes, keys, strict=True):
            axis.plot(means[key], means["plane_error_pct"], "o", color=color, label=f"{number}: {label}")
            axis.annotate(
                str(number),
                (means[key], means["plane_error_pct"]),
                xytext=(4, 2),
                textcoords="offset points",
                fontsize=8,
            )
            axis.set_xlabel(tables["COLUMNS"][key])
    axes[0].set_ylabel("plane error (eq. 27)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    figure.suptitle(
        "Multiples of Poisson disk sampling at equal counts, geometric means; lower left is better"
    )
    figure.savefig(HERE / "frontier.png", dpi=110)
    plt.close(figure)


def main() -> None:
    """Make what the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", type=Path, required=True)
    parser.add_argument("--set", default="all", help="development, kept-apart, small or all")
    parser.add_argument("--methods", nargs="*", default=[*OURS, *RIVALS])
    parser.add_argument("--reductions", nargs="*", type=float, default=study()["reductions"])
    parser.add_argument("--sweep", action="store_true", help="the settings of the frontier, on the small set")
    parser.add_argument("--out", type=Path, default=KEPT, help="folder of the tables")
    given = parser.parse_args()
    wanted = "small" if given.sweep else given.set
    entries = [
        e for e in study()["models"] if e["set"] == wanted or (wanted == "all" and e["set"] != "small")
    ]
    variants = [Variant(m, {}) for m in given.methods] + (sweep() if given.sweep else [])
    found = []
    given.out.mkdir(parents=True, exist_ok=True)
    target = given.out / ("sweep.csv" if given.sweep else "records.csv")
    for row in rows(entries, given.models, variants, given.reductions):
        found.append(row)
        print(row["model"], row["reduction"], row["method"], f"{row['plane_error_pct']:.4f}", flush=True)
        write_rows(target, found)
    if given.sweep:
        draw_frontier(target)


if __name__ == "__main__":
    main()
