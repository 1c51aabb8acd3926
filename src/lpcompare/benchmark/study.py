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
from collections.abc import Iterable, Mapping
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any, TypedDict

import msgspec

from lpcompare.benchmark.environment import physical_memory_mib
from lpcompare.benchmark.perturbation import CLEAN, Perturbation
from lpcompare.benchmark.plan import Plan, Variant
from lpcompare.errors import InputError, UnknownName
from lpcompare.registry import METHODS, METRICS
from lpcompare.threads import thread_count

_LARGEST_FILE = 2**20


class Study(TypedDict, total=False):
    """The fields of a study; those that are not given have the defaults of `Plan`."""

    title: str
    models: list[str]
    methods: list[str]
    reductions: list[float]
    seeds: list[int]
    repeats: int
    metrics: list[str]
    protocol: str
    refine: bool
    time_limit_s: float
    settings: dict[str, dict[str, Any]]
    perturbations: dict[str, list[float]]


_DIRECT = ("title", "models", "reductions", "seeds", "repeats", "protocol", "refine", "time_limit_s")


def preset_names() -> tuple[str, ...]:
    """The studies that come with lpcompare."""
    folder = files("lpcompare.benchmark") / "presets"
    return tuple(sorted(Path(f.name).stem for f in folder.iterdir() if f.name.endswith(".toml")))


def read_study(name_or_path: str) -> Study:
    """The fields of a study: of a preset by name, or of a TOML file.

    Raises
    ------
    UnknownName
        Neither a preset nor a file, or a field that studies do not have.
    InputError
        The file cannot be read or a field has the wrong type.
    """
    preset = files("lpcompare.benchmark") / "presets" / f"{name_or_path}.toml"
    source = preset if name_or_path in preset_names() else Path(name_or_path)
    if isinstance(source, Path) and not source.is_file():
        raise UnknownName("study", name_or_path, preset_names())
    try:
        if isinstance(source, Path) and source.stat().st_size > _LARGEST_FILE:
            raise ValueError("it is larger than 1 MiB")
        fields = tomllib.loads(source.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise InputError(f"Study {name_or_path} cannot be read: it is no text in UTF-8.") from error
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"Study {name_or_path} cannot be read: {error}.") from error
    return check_study(fields, f"study {name_or_path}")


def check_study(fields: Mapping[str, Any], what: str) -> Study:
    """The fields of a study, each of the right type.

    Raises
    ------
    UnknownName
        A field that studies do not have.
    InputError
        A field has the wrong type.
    """
    for field in fields:
        if field not in Study.__annotations__:
            raise UnknownName(f"field of {what}", field, Study.__annotations__)
    try:
        return msgspec.convert(fields, Study)
    except (msgspec.ValidationError, RecursionError) as error:
        raise InputError(f"{what}: {str(error).replace('$.', '')}.") from error


def build_plan(
    fields: Study, *, memory_limit_mib: int | None = None, threads: int | None = None, jobs: int = Plan.jobs
) -> Plan:
    """The plan of a study's fields, checked; what is not said has the defaults of `Plan`.

    Parameters
    ----------
    fields : Study
        As `read_study` gives them; ``models`` is needed.
    memory_limit_mib, threads : int, optional
        By default three quarters of the machine's memory and all processors, shared by the jobs.
    jobs : int
        Cases at the same time.

    Raises
    ------
    UnknownName, InputError
    """
    chosen: dict[str, Any] = {"models": [], **fields}
    given: dict[str, Any] = {
        k: tuple(v) if isinstance(v, list) else v for k, v in chosen.items() if k in _DIRECT
    }
    share = max(1, jobs)
    memory = physical_memory_mib() * 3 // 4 // share if memory_limit_mib is None else memory_limit_mib
    plan = Plan(
        **given,
        variants=variants(fields.get("methods"), fields.get("settings", {})),
        metrics=choose_metrics(fields.get("metrics", ())),
        perturbations=perturbations(fields.get("perturbations", {})),
        memory_limit_mib=memory,
        threads=max(1, thread_count() // share) if threads is None else threads,
        jobs=jobs,
    )
    plan.check()
    return plan


def choose_methods(asked: Iterable[str] | None) -> tuple[str, ...]:
    """The methods asked for; by default those of the default study, for ``all`` every one that can run here."""
    asked = tuple(asked or ())
    if "all" in asked:
        return tuple(name for name in METHODS if not METHODS.missing(name))
    return asked or tuple(read_study("default").get("methods", ()))


def choose_metrics(asked: Iterable[str]) -> tuple[str, ...]:
    """The quick metrics, and beside them those asked for; ``all`` asks for every one."""
    asked = set(asked)
    if "all" in asked:
        return METRICS.names()
    METRICS.check_names(asked)
    return tuple(sorted({*METRICS.quick, *asked}))


def variants(methods: Iterable[str] | None, settings: Mapping[str, Mapping[str, Any]]) -> tuple[Variant, ...]:
    """Every method with every combination of its settings; a list of values is a grid.

    Raises
    ------
    UnknownName, InputError
        A method or setting that does not exist, or settings of a method that is not part of the study.
    """
    methods = choose_methods(methods)
    METHODS.check_names((*methods, *settings))
    for method in settings:
        if method not in methods:
            raise InputError(f"There are settings for {method}, which is not part of the study.")
    return tuple(variant for method in methods for variant in _grid(method, settings.get(method, {})))


def perturbations(levels: Mapping[str, list[float]]) -> tuple[Perturbation, ...]:
    """The clean cloud, and every kind at every level above 0.

    Raises
    ------
    UnknownName, InputError
    """
    every = [Perturbation(kind, float(level)) for kind, steps in levels.items() for level in steps if level]
    for one in every:
        one.check()
    return (CLEAN, *every)


def _grid(method: str, settings: Mapping[str, Any]) -> list[Variant]:
    """One variant per combination of the settings' values; a method without any is not imported."""
    lists = [value if isinstance(value, list) else [value] for value in settings.values()]
    combinations = [dict(zip(settings, point, strict=True)) for point in product(*lists)]
    for chosen in combinations:
        METHODS.check_settings(method, chosen)
    return [Variant(method, chosen) for chosen in combinations]
