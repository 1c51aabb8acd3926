"""What the Tab key offers in a shell: names with their summaries; where none fits, the shell offers files."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import typer

Offers = list[tuple[str, str]]
KINDS = ("methods", "models", "metrics")


def methods(incomplete: str) -> Offers:
    """Every method."""
    from lpcompare.registry import METHODS

    return _fitting(METHODS, incomplete, METHODS.summary)


def methods_or_all(incomplete: str) -> Offers:
    """Every method, and the word for all of them."""
    return _fitting(["all"], incomplete, lambda _: "every method that is installed") + methods(incomplete)


def metrics(incomplete: str) -> Offers:
    """Every metric."""
    from lpcompare.registry import METRICS

    return _fitting(METRICS, incomplete, METRICS.summary)


def slow_metrics(incomplete: str) -> Offers:
    """The metrics that run only on request, and the word for all of them."""
    from lpcompare.registry import METRICS

    slow = [offer for offer in metrics(incomplete) if offer[0] not in METRICS.quick]
    return _fitting(["all"], incomplete, lambda _: "every metric") + slow


def models(incomplete: str) -> Offers:
    """Every model of the catalogue."""
    from lpcompare.models import model_names, model_summary

    return _fitting(model_names(), incomplete, model_summary)


def things(incomplete: str) -> Offers:
    """What `lpcompare list` can explain."""
    kinds = _fitting(KINDS, incomplete, lambda _: "list them")
    return kinds + methods(incomplete) + models(incomplete) + metrics(incomplete)


def studies(incomplete: str) -> Offers:
    """The studies that come with lpcompare."""
    from lpcompare.benchmark.study import preset_names

    return _fitting(preset_names(), incomplete)


def protocols(incomplete: str) -> Offers:
    """The protocols of a run."""
    from lpcompare.benchmark.plan import PROTOCOLS

    return _fitting(PROTOCOLS, incomplete)


def statistics(incomplete: str) -> Offers:
    """What --max-error can bound."""
    from lpcompare.max_error import STATISTICS

    return _fitting(STATISTICS, incomplete)


def settings(ctx: typer.Context, incomplete: str) -> Offers:
    """NAME=DEFAULT of the chosen method."""
    return _assignments(ctx.params.get("method") or "lp_uniform", "", incomplete)


def method_settings(incomplete: str) -> Offers:
    """METHOD.NAME=DEFAULT; without a dot yet, the methods."""
    method, dot, _ = incomplete.partition(".")
    if dot:
        return _assignments(method, f"{method}.", incomplete)
    return [(f"{name}.", text) for name, text in methods(incomplete)]


def _assignments(method: str, prefix: str, incomplete: str) -> Offers:
    """The settings of a method with their defaults, as --set takes them."""
    from lpcompare.registry import METHODS

    if method not in METHODS or METHODS.missing(method):
        return []
    words = (f"{prefix}{name}={_value(default)}" for name, default in METHODS.settings(method).items())
    return _fitting(words, incomplete)


def _value(default: object) -> str:
    if isinstance(default, bool):
        return str(default).lower()
    return "" if default is None else str(default)


def _fitting(names: Iterable[str], incomplete: str, text: Callable[[str], str] = lambda _: "") -> Offers:
    return [(name, text(name)) for name in names if name.startswith(incomplete)]
