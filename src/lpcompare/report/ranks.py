"""Ranks of methods over models, whether they differ at all, and how far the metrics agree on them.

Friedman's test and Nemenyi's critical difference after Demsar, "Statistical comparisons of classifiers over
multiple data sets", JMLR 7 (2006). Repeats of one model are not independent models: a model counts once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from lpcompare.report.cells import ERROR, witnesses
from lpcompare.types import Column

SIGNIFICANCE = 0.05
_FEWEST_MODELS = 3
_PLACE = ["input", "reduction", "label"]


@dataclass(frozen=True, eq=False)
class Ranking:
    """Mean ranks of the methods over blocks.

    Attributes
    ----------
    ranks : Series
        Method -> mean rank, best first; 1 is best.
    n_blocks : int
        What was ranked over.
    left_out : tuple of str
        Methods without a value in every block.
    p_value : float
        Friedman's test that all methods are alike; NaN with fewer than three blocks or methods.
    critical_difference : float
        Mean ranks farther apart than this differ at 5 % (Nemenyi); NaN likewise.
    """

    ranks: pd.Series
    n_blocks: int
    left_out: tuple[str, ...]
    p_value: float = math.nan
    critical_difference: float = math.nan

    @property
    def decided(self) -> bool:
        """Friedman's test sees a difference at 5 %."""
        return self.p_value < SIGNIFICANCE

    @property
    def leaders(self) -> tuple[str, ...]:
        """The methods that share the best mean rank."""
        return tuple(self.ranks.index[self.ranks.eq(self.ranks.min())])

    @property
    def worse(self) -> list[str]:
        """The methods that differ from the first, where the test sees a difference."""
        limit = self.ranks.min() + self.critical_difference
        return list(self.ranks.index[self.ranks > limit]) if self.decided else []


def rank_over_models(table: pd.DataFrame) -> Ranking:
    """Rank the methods on each input by the geometric mean of eq. 27 over the reductions, and test."""
    scores = _scores(table).groupby(level="input", sort=False).agg(_typical)
    return _rank(scores, "lower", test=True)


def rank_over_cells(table: pd.DataFrame) -> Ranking:
    """Rank by eq. 27 on each input and reduction; cells of one input are related, so nothing is tested."""
    return _rank(_scores(table), "lower", test=False)


def rank_by_witnesses(table: pd.DataFrame, known: Mapping[str, Column]) -> dict[str, Ranking]:
    """`rank_over_cells` by each measure of its own: from one table turned once."""
    keys = witnesses(known)
    scores = table.set_index(_PLACE)[keys].unstack(sort=False)
    return {key: _rank(scores[key].dropna(how="all"), known[key].better, test=False) for key in keys}


def agreement(ranking: Ranking, other: Ranking) -> float:
    """Kendall's tau-b between two rankings over the methods that both hold; NaN with fewer than two."""
    both = pd.concat([ranking.ranks, other.ranks], axis=1, join="inner").to_numpy()
    if len(both) < 2 or (both == both[0]).all(axis=0).any():
        return math.nan
    order = np.sign(both[:, None] - both[None])  # written out: scipy.stats takes a second to import
    first, second = order[..., 0], order[..., 1]
    return float((first * second).sum() / math.sqrt(np.square(first).sum() * np.square(second).sum()))


def reversals(ranking: Ranking, other: Ranking) -> list[tuple[str, str]]:
    """Neighbours in the first ranking, better one first, that the second ranking orders the other way."""
    shared = [method for method in ranking.ranks.index if method in other.ranks]
    return [(a, b) for a, b in pairwise(shared) if other.ranks[a] > other.ranks[b]]


def agreement_table(table: pd.DataFrame, known: Mapping[str, Column]) -> pd.DataFrame:
    """What each measure makes of the methods, eq. 27 first; empty with fewer than two methods to rank.

    Returns
    -------
    DataFrame
        One row per measure that has a direction and is no alias: ``key``, ``ranking``, ``tau`` with eq. 27,
        and ``reversed_pairs`` of neighbours in eq. 27's ranking that this measure orders the other way.
    """
    first = rank_over_cells(table)
    rows = [
        {"key": k, "ranking": r, "tau": agreement(first, r), "reversed_pairs": reversals(first, r)}
        for k, r in rank_by_witnesses(table, known).items()
        if len(r.ranks) and len(first.ranks) > 1
    ]
    return pd.DataFrame(rows, columns=["key", "ranking", "tau", "reversed_pairs"])


def _scores(table: pd.DataFrame) -> pd.DataFrame:
    """Eq. 27: inputs and reductions by methods, in the order of the cells."""
    return table.set_index(_PLACE)[ERROR].unstack(sort=False).dropna(how="all")


def _typical(values: pd.Series) -> float:
    """Geometric mean, so that no reduction outweighs the others; arithmetic where a value is not positive.

    NaN where one is missing.
    """
    return math.exp(np.log(values).mean(skipna=False)) if (values > 0).all() else values.mean(skipna=False)


def _rank(scores: pd.DataFrame, better: str, *, test: bool) -> Ranking:
    complete = scores.dropna(axis=1) if len(scores) else scores.iloc[:, :0]
    ranks = complete.rank(axis=1, ascending=better != "higher").mean()
    tested = _test(complete.to_numpy()) if test else (math.nan, math.nan)
    left_out = tuple(scores.columns.difference(complete.columns, sort=False))
    return Ranking(ranks.sort_values(kind="stable"), len(scores), left_out, *tested)


def _test(scores: np.ndarray) -> tuple[float, float]:
    """Friedman's p and Nemenyi's critical difference of a table (blocks, methods)."""
    n_blocks, n_methods = scores.shape
    if n_blocks < _FEWEST_MODELS or n_methods < 3 or (scores == scores[:, :1]).all():
        return math.nan, math.nan
    from scipy.stats import friedmanchisquare, studentized_range

    p_value = float(friedmanchisquare(*scores.T).pvalue)
    quantile = float(studentized_range.ppf(1 - SIGNIFICANCE, n_methods, math.inf)) / math.sqrt(2)
    return p_value, quantile * math.sqrt(n_methods * (n_methods + 1) / (6 * n_blocks))
