"""How much the seed decides: the spread of each measure over the seeds of reports/seeds.

``python docs/make.py`` puts the table into docs/strengths.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from lpcompare.benchmark.record import Run
from lpcompare.report.tables import listing, markdown_table, percent

ERROR, OURS, RIVAL = "plane_error_pct", "lp_uniform", "poisson_disk"


def coefficients(frame: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Standard deviation over the seeds as a share of the mean, by method; the mean of the clouds' shares."""
    groups = frame[frame.status.eq("ok")].groupby(["method", "model", "reduction"])[keys]
    return (groups.std() / groups.mean()).groupby(level="method").mean()


def spread(run: Run, titles: Mapping[str, str]) -> Iterator[str]:
    """What chance decides, in sentences and in a table.

    Parameters
    ----------
    run : Run
        A study with several seeds.
    titles : mapping of str to str
        The measures, and what they are called.
    """
    frame = run.frame
    shares = coefficients(frame, list(titles)).sort_values(ERROR, kind="stable")
    clouds, seeds = (listing([str(v) for v in frame[key].unique()]) for key in ("model", "seed"))
    removed = listing([percent(r) for r in sorted(frame.reduction.unique())])
    most, least = shares.index[-1], shares.index[0]
    yield f"{len(shares)} methods that draw at random, on {clouds}; {removed} removed; seeds {seeds}."
    yield f"The seed changes the plane error of `{most}` most ({_share(shares.at[most, ERROR])}),"
    yield f"and that of `{least}` least ({_share(shares.at[least, ERROR])}). {_duel(frame)}"
    yield ""
    rows = [[f"`{m}`", *map(_share, shares.loc[m])] for m in shares.index]
    yield from markdown_table(["method", *titles.values()], rows)
    yield ""
    yield "Standard deviation over the seeds, as a share of the mean; mean over the clouds."


def _duel(frame: pd.DataFrame) -> str:
    """In how many of all pairs of seeds our method has the lower plane error."""
    errors = frame[frame.status.eq("ok")].set_index(["model", "reduction"])[["method", ERROR]]
    ours, theirs = (errors[errors.method.eq(m)][ERROR].rename(m).to_frame() for m in (OURS, RIVAL))
    pairs = ours.join(theirs).dropna()
    n_lower = int((pairs[OURS] < pairs[RIVAL]).sum())
    return (
        f"`{OURS}` has a lower plane error than `{RIVAL}` in {n_lower} of {len(pairs)} pairs of their seeds."
    )


def _share(value: float) -> str:
    return f"{100 * value:.1f} %"
