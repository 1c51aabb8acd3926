"""What a run will do: its cases, in the order in which they are run."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import msgspec

from lpcompare.benchmark.perturbation import CLEAN, Perturbation
from lpcompare.checks import check_integer, check_number
from lpcompare.errors import InputError, UnknownName, printable

PROTOCOLS = ("equal-count", "as-printed")
REFERENCE = "lp_printed"

_MOST_CASES = 1_000_000
_LONGEST_S = 1e7
_LARGEST_SEED = 2**62


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

    @property
    def group(self) -> tuple[object, ...]:
        """What it has in common with the cases that it is compared with in one repeat or another."""
        return self.model, self.perturbation, self.reduction, self.seed


@dataclass(frozen=True)
class Plan:
    """Everything that decides what is computed, and what it is called; its defaults are those of a run.

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
        Improve every result that is a subset by swaps (`lpcompare.uniform.swaps`).
    time_limit_s : float
        Wall clock of one case, in seconds.
    memory_limit_mib : int
        Memory of one case, with all processes that it starts.
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
        named = replace(self, models=tuple(map(printable, self.models)))
        return msgspec.json.decode(msgspec.json.encode(named, enc_hook=repr))

    def check(self) -> None:
        """Refuse a plan that cannot be run.

        Raises
        ------
        InputError, UnknownName
        """
        for what in ("models", "variants", "reductions", "seeds", "perturbations"):
            names = getattr(self, what)
            what = "methods" if what == "variants" else what  # noqa: PLW2901
            if not names:
                raise InputError(f"The plan has no {what}; name at least one.")
            if len({str(name) for name in names}) < len(names):
                raise InputError(f"The plan names one of its {what} twice.")
        self._check_numbers()
        if self.protocol not in PROTOCOLS:
            raise UnknownName("protocol", self.protocol, PROTOCOLS)
        if self.protocol == "as-printed" and REFERENCE not in {v.method for v in self.variants}:
            raise InputError(f"The protocol as-printed takes its counts from {REFERENCE}; add that method.")
        if len(self) > _MOST_CASES:
            raise InputError(f"The plan has {len(self):,} cases; it may have {_MOST_CASES:,} at most.")

    def _check_numbers(self) -> None:
        for value in self.reductions:
            if not 0 <= value < 1:
                raise InputError(
                    f"The reduction is {value}; it is the share of points removed, from 0 to below 1."
                )
        for perturbation in self.perturbations:
            perturbation.check()
        for seed in self.seeds:
            check_integer("The seed", seed, 0, _LARGEST_SEED)
        for name in ("repeats", "threads", "jobs"):
            check_integer(f"The number of {name}", getattr(self, name), 1)
        if not check_number("The time limit in seconds", self.time_limit_s, 0, _LONGEST_S):
            raise InputError("The time limit in seconds is 0; give a number above 0.")
        check_integer("The memory limit in MiB", self.memory_limit_mib, 256)


def seed_entropy(seed: int, repeat: int, method: str, model: str) -> list[int]:
    """Entropy of a case's generator: ``numpy.random.SeedSequence(entropy)``.

    Method and model enter as the first 8 bytes of their names' SHA-256, so that no two methods draw the same
    numbers, and adding a method changes no other method's draw.
    """
    names = (hashlib.sha256(name.encode("utf-8", "surrogateescape")).digest()[:8] for name in (method, model))
    return [seed, repeat, *(int.from_bytes(name, "big") for name in names)]
