"""Studies: TOML files that say what a run compares; the presets lie in the folder beside this file.

::

    title = "One sentence."
    models = ["bunny", "path/to/scan.ply"]
    methods = ["lp_density", "poisson_disk"]     # default: every installed one
    reductions = [0.7, 0.8, 0.9]
    seeds = [0, 1]
    repeats = 3
    metrics = ["plane_error"]                    # default: the quick ones
    protocol = "equal-count"                     # or "as-printed"
    refine = false
    time_limit_s = 300

    [settings.lp_density]                        # a list is a grid: one variant per value
    n_clusters = [10, 25]

    [perturbations]                              # beside the clean cloud
    noise = [0.1, 0.5]
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any

from lpcompare.benchmark.environment import physical_memory_mib
from lpcompare.benchmark.hints import fits, spell
from lpcompare.benchmark.perturbation import CLEAN, Perturbation
from lpcompare.benchmark.plan import Plan, Variant, check_names, choose_metrics, default_methods
from lpcompare.benchmark.settings import check_settings
from lpcompare.errors import InputError, UnknownName
from lpcompare.threads import thread_count

_FIELDS: dict[str, Any] = {
    "title": str,
    "models": list[str],
    "methods": list[str],
    "reductions": list[float],
    "seeds": list[int],
    "repeats": int,
    "metrics": list[str],
    "protocol": str,
    "refine": bool,
    "time_limit_s": float,
    "settings": Mapping[str, Any],
    "perturbations": Mapping[str, Any],
}
_TABLES: dict[str, Any] = {"settings": Mapping[str, Any], "perturbations": list[float]}
_DIRECT = ("title", "models", "reductions", "seeds", "repeats", "protocol", "refine", "time_limit_s")


def preset_names() -> tuple[str, ...]:
    """The studies that come with lpcompare."""
    folder = files("lpcompare.benchmark") / "presets"
    return tuple(sorted(Path(f.name).stem for f in folder.iterdir() if f.name.endswith(".toml")))


def read_study(name_or_path: str) -> dict[str, Any]:
    """The fields of a study: of a preset by name, or of a TOML file.

    Raises
    ------
    UnknownName
        Neither a preset nor a file, or a field that studies do not have.
    InputError
        The file cannot be read or a field has the wrong type.
    """
    study = _parse(name_or_path)
    for field, value in study.items():
        if field not in _FIELDS:
            raise UnknownName(f"field of study {name_or_path}", field, _FIELDS)
        if not fits(value, _FIELDS[field]):
            raise InputError(
                f"Study {name_or_path}: {field} is {value!r}; it must be {spell(_FIELDS[field])}."
            )
    for table, kind in _TABLES.items():
        for key, value in study.get(table, {}).items():
            if not fits(value, kind):
                raise InputError(
                    f"Study {name_or_path}: {table}.{key} is {value!r}; it must be {spell(kind)}."
                )
    return study


def build_plan(
    fields: Mapping[str, Any], *, memory_limit_mib: int | None, threads: int | None, jobs: int | None
) -> Plan:
    """The plan of a study's fields, checked; what is not said has the defaults of `Plan`.

    Parameters
    ----------
    fields : mapping
        As `read_study` gives them; ``models`` is needed.
    memory_limit_mib, threads, jobs : int, optional
        By default three quarters of the machine's memory and all processors, shared by the jobs; one job.

    Raises
    ------
    UnknownName, InputError
    """
    given: dict[str, Any] = {
        k: tuple(v) if isinstance(v, list) else v for k, v in fields.items() if k in _DIRECT
    }
    jobs = 1 if jobs is None else jobs
    share = max(1, jobs)
    memory = physical_memory_mib() * 3 // 4 // share if memory_limit_mib is None else memory_limit_mib
    plan = Plan(
        **given,
        variants=variants(fields.get("methods"), fields.get("settings", {})),
        metrics=choose_metrics(tuple(fields.get("metrics", ()))),
        perturbations=perturbations(fields.get("perturbations", {})),
        memory_limit_mib=memory,
        threads=max(1, thread_count() // share) if threads is None else threads,
        jobs=jobs,
    )
    plan.check()
    return plan


def variants(methods: list[str] | None, settings: Mapping[str, Mapping[str, Any]]) -> tuple[Variant, ...]:
    """Every method with every combination of its settings; a list of values is a grid.

    Raises
    ------
    UnknownName, InputError
        A method or setting that does not exist, or settings of a method that is not part of the study.
    """
    methods = list(methods or default_methods())
    check_names(tuple(methods), ())
    for method in settings:
        check_names((method,), ())
        if method not in methods:
            raise InputError(f"There are settings for {method}, which is not part of the study.")
    return tuple(variant for method in methods for variant in _grid(method, settings.get(method, {})))


def perturbations(levels: Mapping[str, list[float]]) -> tuple[Perturbation, ...]:
    """The clean cloud, and every kind at every level above 0.

    Raises
    ------
    UnknownName, InputError
    """
    damage = [Perturbation(kind, float(level)) for kind, steps in levels.items() for level in steps if level]
    for one in damage:
        one.check()
    return (CLEAN, *damage)


def _parse(name_or_path: str) -> dict[str, Any]:
    preset = files("lpcompare.benchmark") / "presets" / f"{name_or_path}.toml"
    source = preset if name_or_path in preset_names() else Path(name_or_path)
    if isinstance(source, Path) and not source.is_file():
        raise UnknownName("study", name_or_path, preset_names())
    try:
        return tomllib.loads(source.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"Study {name_or_path} cannot be read: {error}.") from error


def _grid(method: str, settings: Mapping[str, Any]) -> list[Variant]:
    """One variant per combination of the settings' values; a method without any is not imported."""
    lists = [value if isinstance(value, list) else [value] for value in settings.values()]
    combinations = [dict(zip(settings, point, strict=True)) for point in product(*lists)]
    for chosen in combinations:
        check_settings(method, chosen)
    return [Variant(method, chosen) for chosen in combinations]
