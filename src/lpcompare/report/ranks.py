"""Ranks of methods over models, whether they differ at all, and how far the metrics agree on them.

Friedman's test and Nemenyi's critical difference after Demsar, "Statistical comparisons of classifiers over
multiple data sets", JMLR 7 (2006). Repeats of one model are not independent models: a model counts once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import friedmanchisquare, kendalltau, rankdata, studentized_range

from lpcompare.report.cells import Cell, distinct
from lpcompare.report.columns import Heading

SIGNIFICANCE = 0.05
_FEWEST_MODELS = 3


@dataclass(frozen=True)
class Ranking:
    """Mean ranks of the methods over blocks.

    Attributes
    ----------
    methods : tuple of str
        Best first.
    mean_ranks : tuple of float
        1 is best.
    blocks : tuple of str
        What was ranked over.
    left_out : tuple of str
        Methods without a value in every block.
    p_value : float
        Friedman's test that all methods are alike; NaN with fewer than three blocks or methods.
    critical_difference : float
        Mean ranks farther apart than this differ at 5 % (Nemenyi); NaN likewise.
    """

    methods: tuple[str, ...]
    mean_ranks: tuple[float, ...]
    blocks: tuple[str, ...]
    left_out: tuple[str, ...]
    p_value: float = math.nan
    critical_difference: float = math.nan

    @property
    def decided(self) -> bool:
        """Friedman's test sees a difference at 5 %."""
        return self.p_value < SIGNIFICANCE


def rank_over_models(cells: Sequence[Cell], heading: Heading) -> Ranking:
    """Rank the methods on each model by the geometric mean of a column over the reductions, and test."""
    scores: dict[str, dict[str, float]] = {}
    reductions = distinct(cells, "reduction")
    for model in distinct(cells, "model"):
        for method in distinct(cells, "method"):
            values = [c.value(heading.key) for c in cells if (c.model, c.method) == (model, method)]
            if len(values) == len(reductions) and np.isfinite(values).all():
                scores.setdefault(model, {})[method] = _typical(values)
    return _rank(scores, distinct(cells, "method"), heading, test=True)


def rank_over_cells(cells: Sequence[Cell], heading: Heading) -> Ranking:
    """Rank the methods on each model and reduction; cells of one model are related, so nothing is tested."""
    scores: dict[str, dict[str, float]] = {}
    for cell in cells:
        if heading.key in cell.values:
            block = f"{cell.model} {cell.reduction:g}"
            scores.setdefault(block, {})[cell.method] = cell.value(heading.key)
    return _rank(scores, distinct(cells, "method"), heading, test=False)


def agreement(ranking: Ranking, other: Ranking) -> float:
    """Kendall's tau-b between two rankings over the methods that both hold; NaN with fewer than two."""
    shared = [method for method in ranking.methods if method in other.methods]
    if len(shared) < 2:
        return math.nan
    ranks = [dict(zip(r.methods, r.mean_ranks, strict=True)) for r in (ranking, other)]
    columns = [[r[method] for method in shared] for r in ranks]
    if any(len(set(column)) == 1 for column in columns):
        return math.nan
    return float(kendalltau(*columns)[0])  # pyright: ignore[reportArgumentType]


def reversals(ranking: Ranking, other: Ranking) -> list[tuple[str, str]]:
    """Neighbours in the first ranking, better one first, that the second ranking orders the other way."""
    rank = dict(zip(other.methods, other.mean_ranks, strict=True))
    shared = [method for method in ranking.methods if method in rank]
    return [(a, b) for a, b in pairwise(shared) if rank[a] > rank[b]]


def _typical(values: Sequence[float]) -> float:
    """Geometric mean, so that no reduction outweighs the others; arithmetic where a value is not positive."""
    array = np.asarray(values)
    return float(np.exp(np.log(array).mean())) if (array > 0).all() else float(array.mean())


def _rank(
    scores: Mapping[str, Mapping[str, float]], methods: Sequence[str], heading: Heading, *, test: bool
) -> Ranking:
    complete = [m for m in methods if scores and all(m in block for block in scores.values())]
    left_out = tuple(m for m in methods if m not in complete)
    if not complete:
        return Ranking((), (), tuple(scores), left_out)
    sign = -1.0 if heading.better == "higher" else 1.0
    table = np.array([[sign * block[m] for m in complete] for block in scores.values()])
    means = rankdata(table, axis=1).mean(axis=0)
    order = np.argsort(means, kind="stable")
    p_value, difference = _test(table) if test else (math.nan, math.nan)
    return Ranking(
        methods=tuple(complete[i] for i in order),
        mean_ranks=tuple(float(means[i]) for i in order),
        blocks=tuple(scores),
        left_out=left_out,
        p_value=p_value,
        critical_difference=difference,
    )


def _test(table: np.ndarray) -> tuple[float, float]:
    """Friedman's p and Nemenyi's critical difference of a table (blocks, methods)."""
    n_blocks, n_methods = table.shape
    if n_blocks < _FEWEST_MODELS or n_methods < 3 or (table == table[:, :1]).all():
        return math.nan, math.nan
    p_value = float(friedmanchisquare(*table.T).pvalue)
    quantile = float(studentized_range.ppf(1 - SIGNIFICANCE, n_methods, math.inf)) / math.sqrt(2)
    return p_value, quantile * math.sqrt(n_methods * (n_methods + 1) / (6 * n_blocks))
