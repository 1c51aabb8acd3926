"""What a run shows, in sentences that are computed from its numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lpcompare.report.cells import Cell, clean_cells, distinct, pareto_front
from lpcompare.report.columns import ERROR, RUNTIME, headings, metric_keys
from lpcompare.report.ranks import Ranking, rank_over_cells, rank_over_models
from lpcompare.report.wording import count, listing, number, percent, seconds

_MISS = 0.01
"""A count is missed when it differs from the one asked for by more than this share."""

_LONGEST_LIST = 4


def summarize(cells: Sequence[Cell]) -> list[str]:
    """Sentences about a run, the most important one first.

    Parameters
    ----------
    cells : sequence of Cell
        Every cell of the run.

    Returns
    -------
    list of str
        Plain text; names of models and methods are not escaped.
    """
    if not cells:
        return ["The run holds no case: nothing was compared."]
    good = [cell for cell in clean_cells(cells) if cell.ok]
    if not good:
        return [_scope(cells), "No case ended with a result.", *_troubles(cells)]
    return [_scope(cells), *_error(good), *_under_conditions(good), *_speed(good), *_front(good),
            *_other_metrics(good), *_ranks(good), *_misses(good), *_troubles(cells)]  # fmt: skip


def _scope(cells: Sequence[Cell]) -> str:
    clean = clean_cells(cells)
    models, methods, reductions = (distinct(clean, k) for k in ("model", "method", "reduction"))
    sizes = {cell.model: cell.n_input for cell in clean}
    where = f"{models[0]} ({sizes[models[0]]:,} points)" if len(models) == 1 else count(len(models), "model")
    rates = listing([percent(r) for r in sorted(reductions)])
    total = sum(sum(cell.statuses.values()) for cell in cells)
    ended = sum(cell.statuses.get("ok", 0) for cell in cells)
    return (
        f"{count(len(methods), 'method').capitalize()} on {where} with {rates} of the points removed: "
        f"{count(total, 'case')}, {'all' if ended == total else f'{ended:,}'} with a result{_damaged(cells)}."
    )


def _damaged(cells: Sequence[Cell]) -> str:
    """That the cases of damaged inputs are not in what follows, where there are clean ones beside them."""
    n = len(distinct(cells, "model")) - len(distinct(clean_cells(cells), "model"))
    return f"; those of {count(n, 'damaged input')} are not in what follows" if n else ""


def _error(good: Sequence[Cell]) -> Iterator[str]:
    """Who has the lowest eq. 27 error, where, by how much, and whether the repeats can tell."""
    tables = _contests(good)
    winners = [ranked[0].method for ranked in tables]
    if not tables:
        return
    if len(set(winners)) == max(map(len, tables)) == 1:
        span = _range([ranked[0].value(ERROR) for ranked in tables])
        yield f"{winners[0]} has an error (eq. 27) of {span} % of the diagonal."
        return
    for winner in sorted(set(winners), key=lambda w: -winners.count(w))[:_LONGEST_LIST]:
        won = [ranked for ranked in tables if ranked[0].method == winner]
        span = _range([ranked[0].value(ERROR) for ranked in won])
        where = _places(won, tables)
        yield f"{winner} has the lowest error (eq. 27) {where}, {span} % of the diagonal{_lead(won)}."


def _contests(good: Sequence[Cell]) -> list[list[Cell]]:
    """The cells of every model and reduction that have an error, lowest first."""
    groups: dict[tuple[str, float], list[Cell]] = {}
    for cell in good:
        if ERROR in cell.values:
            groups.setdefault((cell.model, cell.reduction), []).append(cell)
    return [sorted(group, key=lambda c: c.value(ERROR)) for group in groups.values()]


def _places(won: list[list[Cell]], tables: list[list[Cell]]) -> str:
    """Where: the reductions on a single model, else the share of the model-reduction pairs."""
    if len({ranked[0].model for ranked in tables}) > 1:
        share = f"all {len(won)}" if len(won) == len(tables) else f"{len(won)} of {len(tables)}"
        return f"in {share} pairs of model and reduction"
    if len(won) == len(tables) > 1:
        return "at both reductions" if len(tables) == 2 else f"at all {count(len(tables), 'reduction')}"
    return f"at {listing([percent(ranked[0].reduction) for ranked in won])}"


def _lead(won: list[list[Cell]]) -> str:
    """How far ahead of the next method, as a range of ratios."""
    rivals = [ranked for ranked in won if len(ranked) > 1 and ranked[0].value(ERROR) > 0]
    if not rivals:
        return ""
    ratios = [ranked[1].value(ERROR) / ranked[0].value(ERROR) for ranked in rivals]
    runners = list(dict.fromkeys(ranked[1].method for ranked in rivals))
    who = listing(runners) if len(runners) <= 2 else "the next method"
    return f"; {who} {_has(runners)} {_times(ratios)}{_overlap(rivals)}"


def _has(names: Sequence[str]) -> str:
    return "have" if len(names) == 2 else "has"


def _times(ratios: list[float]) -> str:
    span = _range(ratios)
    return "as much, to three digits" if span == number(1) else f"{span} times as much"


def _range(ratios: list[float]) -> str:
    low, high = number(min(ratios)), number(max(ratios))
    return low if low == high else f"{low} to {high}"


def _overlap(rivals: list[list[Cell]]) -> str:
    """Where the spans of first and second meet, the repeats do not tell them apart."""
    met = [r for r in rivals if r[0].values[ERROR].high >= r[1].values[ERROR].low]
    if not met:
        return ""
    return f" (the repeats of the first two overlap in {count(len(met), 'case')}: not told apart there)"


def _under_conditions(good: Sequence[Cell]) -> Iterator[str]:
    """The best of those without a mesh, and of those that keep original points, where others lead."""
    winners = [ranked[0] for ranked in _contests(good)]
    if any(cell.needs_mesh for cell in winners):
        yield from _best_of([c for c in good if not c.needs_mesh], "that were given points and no mesh")
    if any(cell.subset is False for cell in winners):
        yield from _best_of([c for c in good if c.subset], "whose result is a subset of the original points")


def _best_of(cells: Sequence[Cell], which: str) -> Iterator[str]:
    tables = _contests(cells)
    winners = [ranked[0].method for ranked in tables]
    if winners:
        best = max(dict.fromkeys(winners), key=winners.count)
        won = [ranked for ranked in tables if ranked[0].method == best]
        yield f"Of the methods {which}, {best} has the lowest error {_places(won, tables)}{_lead(won)}."


def _speed(good: Sequence[Cell]) -> Iterator[str]:
    """The fastest method, and what the one with the lowest error takes."""
    times = _spans(good, RUNTIME)
    tables = _contests(good)
    if len(times) < 2 or not tables:
        return
    fastest = min(times, key=lambda method: max(times[method]))
    leaders = [ranked[0].method for ranked in tables]
    leader = max(dict.fromkeys(leaders), key=leaders.count)
    text = f"{fastest} is the fastest ({_time_range(times[fastest])})"
    if leader != fastest and leader in times:
        text += f"; {leader} takes {_time_range(times[leader])}"
    yield text + "."


def _spans(good: Sequence[Cell], key: str) -> dict[str, list[float]]:
    spans: dict[str, list[float]] = {}
    for cell in good:
        if key in cell.values:
            spans.setdefault(cell.method, []).append(cell.value(key))
    return spans


def _time_range(values: list[float]) -> str:
    low, high = seconds(min(values)), seconds(max(values))
    return low if low == high else f"{low} to {high}"


def _front(good: Sequence[Cell]) -> Iterator[str]:
    """On one model: the methods that no other beats in both error and time, at every reduction."""
    if len(distinct(good, "model")) > 1 or len(distinct(good, "method")) < 3:
        return
    fronts = [
        {c.method for c in pareto_front([c for c in good if c.reduction == r], RUNTIME, ERROR)}
        for r in distinct(good, "reduction")
    ]
    always = [m for m in distinct(good, "method") if all(m in front for front in fronts)]
    if always:
        yield f"No method is both faster and more accurate than {listing(always)}, at any reduction here."


def _other_metrics(good: Sequence[Cell]) -> Iterator[str]:
    """The metrics whose best method is another one than that of eq. 27."""
    known = headings({key for cell in good for key in cell.values})
    if ERROR not in known or len(distinct(good, "method")) < 2:
        return
    first = _leaders(rank_over_cells(good, known[ERROR]))
    judged = [key for key in metric_keys(known) if known[key].better]
    titles = _short_titles([known[key].title for key in judged])
    dissent: dict[tuple[str, ...], list[str]] = {}
    for key, title in zip(judged, titles, strict=True):
        leaders = _leaders(rank_over_cells(good, known[key]))
        if leaders and first and first[0] not in leaders:
            dissent.setdefault(leaders, []).append(title)
    told = _most_told(sorted(dissent.items(), key=lambda d: -len(d[1])))
    if told:
        yield f"Other measures put another method first: {listing(told)}."


def _most_told(dissent: Sequence[tuple[tuple[str, ...], list[str]]]) -> list[str]:
    """The leaders of most measures each, and how many measures are left to others."""
    told = [f"{_names(leaders)} ({_titles(titles)})" for leaders, titles in dissent]
    if len(told) <= _LONGEST_LIST:
        return told
    rest = sum(len(titles) for _, titles in dissent[_LONGEST_LIST - 1 :])
    return [*told[: _LONGEST_LIST - 1], f"others ({count(rest, 'measure')})"]


def _leaders(ranking: Ranking) -> tuple[str, ...]:
    """The methods that share the best mean rank."""
    return tuple(
        m for m, r in zip(ranking.methods, ranking.mean_ranks, strict=True) if r == min(ranking.mean_ranks)
    )


def _names(leaders: Sequence[str]) -> str:
    return listing(leaders) if len(leaders) <= 2 else f"{count(len(leaders), 'method')} alike"


def _short_titles(titles: Sequence[str]) -> list[str]:
    """Each title up to its first comma or colon, whole where that would leave two the same."""
    short = [re.split(r"[,:]", title)[0] for title in titles]
    return [s if short.count(s) == 1 else title for s, title in zip(short, titles, strict=True)]


def _titles(titles: Sequence[str]) -> str:
    return "; ".join(titles) if len(titles) <= 2 else count(len(titles), "measure")


def _ranks(good: Sequence[Cell]) -> Iterator[str]:
    """Whether the ranks over the models differ by more than chance."""
    known = headings({key for cell in good for key in cell.values})
    if ERROR not in known or len(distinct(good, "model")) < 3:
        return
    ranking = rank_over_models(good, known[ERROR])
    if not ranking.decided:
        return
    limit = ranking.mean_ranks[0] + ranking.critical_difference
    worse = [m for m, r in zip(ranking.methods, ranking.mean_ranks, strict=True) if r > limit]
    beats = (
        f"significantly better than {listing(worse)}" if worse else "not significantly better than any other"
    )
    where = f"Over {count(len(ranking.blocks), 'model')}"
    yield f"{where}, {ranking.methods[0]} has the best mean rank and is {beats} (5 %)."


def _misses(good: Sequence[Cell]) -> Iterator[str]:
    """Methods that returned another count than the one they were asked for."""
    off: dict[str, float] = {}
    for cell in good:
        share = cell.value("n_output") / cell.target_count - 1
        if abs(share) > max(_MISS, abs(off.get(cell.method, 0.0))):
            off[cell.method] = share
    if off:
        told = [f"{m} (up to {100 * abs(s):.3g} % {'more' if s > 0 else 'fewer'})" for m, s in off.items()]
        yield f"Another count than the one asked for was returned by {listing(told)}: not at equal counts."


def _troubles(cells: Sequence[Cell]) -> Iterator[str]:
    """How many cases were skipped, failed or timed out, and of which methods."""
    words = {"failed": "failed", "timeout": "ran out of time", "skipped": "did not apply or could not run"}
    for status, text in words.items():
        hit = [cell for cell in cells if cell.statuses.get(status)]
        if hit:
            n = sum(cell.statuses[status] for cell in hit)
            yield f"{count(n, 'case').capitalize()} {text}: {listing(distinct(hit, 'method'))}."
