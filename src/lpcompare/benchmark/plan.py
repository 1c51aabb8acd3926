"""What a run will do: its cases, in the order in which they are run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from lpcompare.benchmark.perturbation import CLEAN, Perturbation
from lpcompare.errors import InputError, UnknownName
from lpcompare.registry import METHODS, METRICS

PROTOCOLS = ("equal-count", "as-printed")
REFERENCE = "lp_printed"


@dataclass(frozen=True)
class Variant:
    """A method with the settings that differ from its defaults."""

    method: str
    settings: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def label(self) -> str:
        """The method's name, with the settings that were chosen."""
        chosen = " ".join(f"{k}={v}" for k, v in self.settings.items())
        return f"{self.method} {chosen}".rstrip()


@dataclass(frozen=True)
class Case:
    """One cell of the plan, run once in its own process."""

    model: str
    perturbation: Perturbation
    variant: Variant
    reduction: float
    seed: int
    repeat: int


@dataclass(frozen=True)
class Plan:
    """Everything that decides what is computed, and what it is called.

    Attributes
    ----------
    models : tuple of str
        Names or files.
    variants : tuple of Variant
    reductions : tuple of float
        Shares removed, each from 0 to below 1.
    seeds : tuple of int
    repeats : int
        Runs of each case, interleaved over the methods.
    metrics : tuple of str
    perturbations : tuple of Perturbation
    protocol : str
        ``equal-count``: every method is asked for floor((1 - R) n) points. ``as-printed``: the paper's method
        is, and all others are asked for as many points as it returned.
    refine : bool
        Run the exchange of `lpcompare.uniform` on every result that is a subset.
    time_limit_s : float
        Wall clock of one case, in seconds.
    memory_limit_mib : int
        Memory of one case.
    threads : int
        Threads of every library in a case.
    jobs : int
        Cases at the same time; above 1 the timings are unreliable.
    title : str
        What the study says of itself; empty without one.
    """

    models: tuple[str, ...]
    variants: tuple[Variant, ...]
    reductions: tuple[float, ...] = (0.7, 0.8, 0.9)
    seeds: tuple[int, ...] = (0,)
    repeats: int = 1
    metrics: tuple[str, ...] = ("plane_error",)
    perturbations: tuple[Perturbation, ...] = (CLEAN,)
    protocol: str = "equal-count"
    refine: bool = False
    time_limit_s: float = 300.0
    memory_limit_mib: int = 8192
    threads: int = 1
    jobs: int = 1
    title: str = ""

    def cases(self) -> Iterator[Case]:
        """Every case, round robin over the methods, so that drift of the machine meets all alike."""
        for repeat in range(self.repeats):
            for seed in self.seeds:
                for model in self.models:
                    for perturbation in self.perturbations:
                        for reduction in self.reductions:
                            for variant in self._ordered_variants():
                                yield Case(model, perturbation, variant, reduction, seed, repeat)

    def _ordered_variants(self) -> list[Variant]:
        """Under ``as-printed`` the paper's method goes first: it sets the count of all others."""
        leads = self.protocol == "as-printed"
        return sorted(self.variants, key=lambda v: not (leads and v.method == REFERENCE))

    def __len__(self) -> int:
        shapes = len(self.models) * len(self.perturbations) * len(self.reductions)
        return self.repeats * len(self.seeds) * shapes * len(self.variants)

    def to_dict(self) -> dict[str, Any]:
        """The plan as JSON-ready values."""
        return asdict(self)

    def check(self) -> None:
        """Refuse a plan that cannot be run.

        Raises
        ------
        InputError, UnknownName
        """
        self._check_names()
        self._check_numbers()
        if self.protocol not in PROTOCOLS:
            raise UnknownName("protocol", self.protocol, PROTOCOLS)
        if self.protocol == "as-printed" and REFERENCE not in {v.method for v in self.variants}:
            raise InputError(f"The protocol as-printed takes its counts from {REFERENCE}; add that method.")

    def _check_numbers(self) -> None:
        for value in self.reductions:
            if not 0 <= value < 1:
                raise InputError(
                    f"The reduction is {value}; it is the share of points removed, from 0 to below 1."
                )
        for what, number in (("repeats", self.repeats), ("threads", self.threads), ("jobs", self.jobs)):
            if number < 1:
                raise InputError(f"The number of {what} is {number}; it must be at least 1.")
        for perturbation in self.perturbations:
            perturbation.check()
        for seed in self.seeds:
            if seed < 0:
                raise InputError(f"The seed is {seed}; it must be 0 or more.")
        if not self.time_limit_s > 0:
            raise InputError(f"The time limit is {self.time_limit_s} s; it must be above 0.")
        if self.memory_limit_mib < 256:
            raise InputError(f"The memory limit is {self.memory_limit_mib} MiB; it must be at least 256.")

    def _check_names(self) -> None:
        for what, names in (
            ("models", self.models),
            ("methods", self.variants),
            ("reductions", self.reductions),
            ("seeds", self.seeds),
            ("perturbations", self.perturbations),
        ):
            if not names:
                raise InputError(f"The plan has no {what}; name at least one.")
            if len({str(name) for name in names}) < len(names):
                raise InputError(f"The plan names one of its {what} twice.")


def target_count(n_points: int, reduction: float) -> int:
    """Points to keep: floor((1 - R) n), at least 1; the product is rounded at its ninth digit before."""
    return max(1, math.floor(round((1 - reduction) * n_points, 9)))


def check_names(methods: tuple[str, ...], metrics: tuple[str, ...]) -> None:
    """Refuse methods and metrics that do not exist; raises `UnknownName`."""
    for registry, names in ((METHODS, methods), (METRICS, metrics)):
        for name in names:
            if name not in registry:
                raise UnknownName(registry.kind, name, registry)


def default_methods() -> tuple[str, ...]:
    """Every method that this installation of lpcompare can run, optional ones where their extra is there."""
    return tuple(name for name in METHODS if not METHODS.missing(name))


def choose_metrics(asked: tuple[str, ...]) -> tuple[str, ...]:
    """The quick metrics, and beside them those asked for; ``all`` asks for every one."""
    if "all" in asked:
        return METRICS.names()
    quick = (name for name in METRICS if getattr(METRICS.module(name), "COST", "quick") != "slow")
    check_names((), asked)
    return tuple(sorted({*quick, *asked}))
