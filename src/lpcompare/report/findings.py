"""What a run shows, in sentences that are computed from its numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import pandas as pd

from lpcompare.report.cells import ERROR, RUNTIME, clean, columns
from lpcompare.report.ranks import rank_by_witnesses, rank_over_cells, rank_over_models
from lpcompare.report.tables import count, listing, number, percent, seconds

_MISS = 0.01
"""A count is missed when it differs from the one asked for by more than this share."""

_LONGEST_LIST = 3
_TROUBLES = {"failed": "failed", "timeout": "ran out of time", "skipped": "did not apply or could not run"}


def summarize(table: pd.DataFrame) -> list[str]:
    """Sentences about a run.

    Parameters
    ----------
    table : DataFrame
        `lpcompare.report.cells.cells` of the run.

    Returns
    -------
    list of str
        What was run and what did not end well; then at most four findings, the most important one first.
        Plain text; names of models and methods are not escaped.
    """
    if table.empty:
        return ["The run holds no case: nothing was compared."]
    good = clean(table)
    good = good[good.n_ok > 0]
    scope = " ".join([_scope(table), *_misses(good), *_troubles(table)])
    if good.empty:
        return [f"{scope} No case ended with a result."]
    return [scope, *_error(good), *_under_conditions(good), *_speed(good), *_other_measures(good)]


def _scope(table: pd.DataFrame) -> str:
    plain = clean(table)
    names = plain.input.unique()
    where = (
        f"{names[0]} ({plain.n_input.iloc[0]:,} points)" if len(names) == 1 else count(len(names), "model")
    )
    rates = listing([percent(r) for r in sorted(plain.reduction.unique())])
    total, ended = int(table.n_repeats.sum()), int(table.n_ok.sum())
    left = table.input.nunique() - len(names)
    perturbed = f"; those of {count(left, 'perturbed input')} are not in what follows" if left else ""
    methods = count(plain.label.nunique(), "method").capitalize()
    return (
        f"{methods} on {where} with {rates} of the points removed: "
        f"{count(total, 'case')}, {'all' if ended == total else f'{ended:,}'} with a result{perturbed}."
    )


def _misses(good: pd.DataFrame) -> Iterator[str]:
    """Methods that returned another count than the one they were asked for."""
    off = good.n_output / good.target_count - 1
    worst = off.loc[off.abs().groupby(good.label, sort=False).idxmax().dropna()].set_axis(good.label.unique())
    worst = worst[worst.abs() > _MISS].sort_values(key=abs, ascending=False)
    told = [f"{m} (up to {100 * abs(s):.3g} % {'more' if s > 0 else 'fewer'})" for m, s in worst.items()]
    if told:
        yield f"Not at equal counts: {_first(told)}."


def _troubles(table: pd.DataFrame) -> Iterator[str]:
    """How many cases were skipped, failed or timed out, and of which methods."""
    for status, text in _TROUBLES.items():
        hit = table[table.status.str.contains(status)]
        found = [re.search(rf"(\d+) {status}", told) for told in hit.status]
        n = sum(int(f[1]) if f else n for f, n in zip(found, hit.n_repeats, strict=True))
        if n:
            yield f"{count(n, 'case').capitalize()} {text}: {_first(list(hit.label.unique()))}."


def _error(good: pd.DataFrame) -> Iterator[str]:
    """Who has the lowest plane error, where, by how much, and whether the repeats can tell."""
    contests = _contests(good)
    if contests.empty:
        return
    best = _most_frequent(contests.winner)
    won = contests[contests.winner.eq(best)]
    if contests.runner.isna().all() and len(won) == len(contests):
        yield f"{best} has a plane error of {_range(contests.error)} % of the diagonal."
        return
    others = contests[contests.winner.ne(best)]
    where = "elsewhere" if contests.input.nunique() > 1 else _places(others, contests)
    tail = f"; {where} it is that of {_first(list(others.winner.unique()))}" if len(others) else ""
    span = f"{_range(won.error)} % of the diagonal"
    yield f"{best} has the lowest plane error {_places(won, contests)}, {span}{_lead(won)}{tail}."


def _contests(good: pd.DataFrame) -> pd.DataFrame:
    """One row per input and reduction: who has the lowest error, who is next, and by how much."""
    rows = []
    for (name, reduction), group in good.dropna(subset=[ERROR]).groupby(["input", "reduction"], sort=False):
        ranked = group.sort_values(ERROR, kind="stable")
        first = ranked.iloc[0]
        row = {"input": name, "reduction": reduction, "winner": first.label, "error": first[ERROR]}
        row |= {"mesh": first.needs_mesh is True, "moved": first.subset is False, "runner": None}
        if len(ranked) > 1 and first[ERROR] > 0:
            second = ranked.iloc[1]
            met = first[f"{ERROR}_high"] >= second[f"{ERROR}_low"]
            row |= {"runner": second.label, "ratio": second[ERROR] / first[ERROR], "met": met}
        rows.append(row)
    names = ["input", "reduction", "winner", "error", "mesh", "moved", "runner", "ratio", "met"]
    return pd.DataFrame(rows, columns=names)


def _places(won: pd.DataFrame, contests: pd.DataFrame) -> str:
    """Where: the reductions on a single model, else the share of the model-reduction pairs."""
    n, total = len(won), len(contests)
    if contests.input.nunique() > 1:
        return f"in {f'all {n}' if n == total else f'{n} of {total}'} pairs of model and reduction"
    if n == total > 1:
        return "at both reductions" if total == 2 else f"at all {count(total, 'reduction')}"
    return f"at {listing([percent(r) for r in won.reduction])}"


def _lead(won: pd.DataFrame) -> str:
    """How far ahead of the next method, as a range of ratios."""
    rivals = won.dropna(subset=["runner"])
    if rivals.empty:
        return ""
    runners = list(rivals.runner.unique())
    who = listing(runners) if len(runners) <= 2 else "the next method"
    span = _range(rivals.ratio)
    much = "as much, to three digits" if span == number(1) else f"{span} times as much"
    met = int(rivals.met.sum())
    overlap = (
        f" (the repeats of the first two overlap in {count(met, 'case')}: not told apart there)"
        if met
        else ""
    )
    return f"; {who} {'have' if len(runners) == 2 else 'has'} {much}{overlap}"


def _under_conditions(good: pd.DataFrame) -> Iterator[str]:
    """The best of those without a mesh, or of those that keep original points, where others lead."""
    contests = _contests(good)
    mesh, moved = contests.mesh.any(), contests.moved.any()
    if not (mesh or moved):
        return
    which = {
        (True, False): "that were given points and no mesh",
        (False, True): "whose result is a subset of the original points",
        (True, True): "that were given no mesh and keep original points",
    }[bool(mesh), bool(moved)]
    kept = good[(good.needs_mesh.ne(True) | (not mesh)) & (good.subset.eq(True) | (not moved))]
    tables = _contests(kept)
    if len(tables):
        best = _most_frequent(tables.winner)
        won = tables[tables.winner.eq(best)]
        yield f"Of the methods {which}, {best} has the lowest error {_places(won, tables)}{_lead(won)}."


def _speed(good: pd.DataFrame) -> Iterator[str]:
    """The fastest method, and what the one with the lowest error takes."""
    times, contests = good.dropna(subset=[RUNTIME]).groupby("label", sort=False)[RUNTIME], _contests(good)
    spans = times.agg(["min", "max"])
    if len(spans) < 2 or contests.empty:
        return
    texts = {m: _between(seconds(low), seconds(high)) for m, low, high in spans.itertuples()}
    fastest, leader = spans["max"].idxmin(), _most_frequent(contests.winner)
    slower = f"; {leader} takes {texts[leader]}" if leader != fastest and leader in texts else ""
    yield f"{fastest} is the fastest ({texts[fastest]}){slower}."


def _other_measures(good: pd.DataFrame) -> Iterator[str]:
    """Whether ranks over the models differ by more than chance; which measures put another method first."""
    told = [*_ranks(good), *_dissent(good)]
    if told:
        text = "; ".join(told)
        yield f"{text[0].upper()}{text[1:]}."


def _ranks(good: pd.DataFrame) -> Iterator[str]:
    ranking = rank_over_models(good)
    if ranking.decided:
        yield (
            f"over {count(ranking.n_blocks, 'model')}, the mean rank of {ranking.leaders[0]} is the best and "
            f"significantly better than that of {len(ranking.worse)} of the {len(ranking.ranks) - 1} others "
            "(5 %)"
        )


def _dissent(good: pd.DataFrame) -> Iterator[str]:
    """The measures by which a method is first that is not the first by plane error."""
    known, first = columns(good), rank_over_cells(good).leaders
    leaders = {k: r.leaders for k, r in rank_by_witnesses(good, known).items() if k != ERROR}
    against = {key: who for key, who in leaders.items() if who and first and first[0] not in who}
    if len(first) != 1 or not against:
        return
    alone = pd.Series([who[0] for who in against.values() if len(who) == 1], dtype=str)
    if len(against) == 1:
        (key, who), *_ = against.items()
        be = "is" if len(who) == 1 else "are"
        yield f'by one other measure, "{known[key].title}", {_first(who)} {be} first'
    else:
        often = f", most often {_most_frequent(alone)}" if len(alone) else ""
        yield f"by {len(against)} of {len(leaders)} other measures another method is first{often}"


def _most_frequent(names: pd.Series) -> str:
    """The name that occurs most often, the first of those that do."""
    return str(names.value_counts(sort=False).idxmax())


def _range(values: pd.Series) -> str:
    return _between(number(values.min()), number(values.max()))


def _between(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def _first(texts: Sequence[str]) -> str:
    """The first of a list, and how many more there are."""
    if len(texts) <= _LONGEST_LIST:
        return listing(texts)
    return f"{', '.join(texts[:_LONGEST_LIST])} and {count(len(texts) - _LONGEST_LIST, 'other')}"
