"""The page's two tables of ranks: methods over models, and what each measure makes of the methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lpcompare.report.cells import Cell, distinct
from lpcompare.report.columns import ERROR, Heading, metric_keys
from lpcompare.report.ranks import Ranking, agreement, rank_over_cells, rank_over_models, reversals


@dataclass(frozen=True)
class Agreement:
    """How one measure ranks the methods, beside eq. 27.

    Attributes
    ----------
    heading : Heading
    ranks : mapping of str to float
        Mean rank of each method.
    tau : float
        Kendall's tau-b with the ranking by eq. 27; NaN where it is not defined.
    reversed_pairs : list of (str, str)
        Neighbours in eq. 27's ranking that this measure orders the other way.
    """

    heading: Heading
    ranks: Mapping[str, float]
    tau: float
    reversed_pairs: list[tuple[str, str]]


def rank_table(cells: Sequence[Cell], known: Mapping[str, Heading]) -> Ranking | None:
    """The ranking by eq. 27 over the models; None with fewer than two models."""
    if ERROR not in known or len(distinct(cells, "model")) < 2:
        return None
    return rank_over_models(cells, known[ERROR])


def agreement_table(cells: Sequence[Cell], known: Mapping[str, Heading]) -> list[Agreement]:
    """Every measure that has a direction, eq. 27 first; empty with fewer than two methods to rank."""
    if ERROR not in known:
        return []
    first = rank_over_cells(cells, known[ERROR])
    keys = [key for key in metric_keys(known) if known[key].better]
    rankings = {key: rank_over_cells(cells, known[key]) for key in keys}
    if len(first.methods) < 2:
        return []
    return [
        Agreement(
            known[key],
            dict(zip(ranking.methods, ranking.mean_ranks, strict=True)),
            agreement(first, ranking),
            reversals(first, ranking),
        )
        for key, ranking in rankings.items()
        if ranking.methods
    ]
