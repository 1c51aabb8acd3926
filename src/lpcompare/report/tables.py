"""Numbers as people read them, and the tables of a run: for a terminal, as CSV, LaTeX and Markdown."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import pandas as pd

from lpcompare.benchmark.record import Run
from lpcompare.files import replace_text
from lpcompare.report.cells import (
    CELL,
    ERROR,
    REFERENCE,
    RUNTIME,
    cells,
    columns,
    perturbation_curves,
    ratios,
    stage_name,
)
from lpcompare.types import Column

NARROW = 80
"""Every printed table fits this many columns; a wider terminal is given longer names."""

_PAPER = "lp_printed"
_CLAIMED = ("noise", "outliers")
"""What the paper's abstract calls its method robust to, without a measurement."""

_SMALL = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
_LATEX = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%",
    "_": r"\_", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}", "<": r"\textless{}",
    ">": r"\textgreater{}", "–": "--", "\n": " ",
}  # fmt: skip
_CONTROL = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)?|.)|[\x00-\x1f\x7f-\x9f]+")
"""Escape sequences of terminals, and control characters."""


# --- numbers and names as text --------------------------------------------------------------------------


def number(value: float) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if not math.isfinite(value):
        return "n/a"
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if size >= 2:
        return f"{value:,.0f}"
    return f"{value:.{2 - size}f}" if size >= -5 else f"{value:.2e}"


def quantity(value: float, column: Column) -> str:
    """A value of a column; a time in ms below one second and in s above."""
    if column.unit == "points" and math.isfinite(value):
        return f"{value:,.0f}"
    if column.unit != "s" or not math.isfinite(value):
        return number(value)
    return f"{number(1000 * value)} ms" if value < 0.9995 else f"{number(value)} s"


def seconds(value: float) -> str:
    """A time with three digits and its unit."""
    return quantity(value, Column("s", ""))


def percent(share: float) -> str:
    """A share as a percentage: 0.7 is 70 %."""
    return f"{100 * share:.6g} %"


def listing(names: Sequence[str]) -> str:
    """Join names with commas and an "and"."""
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else "".join(names)


def count(n: int, noun: str) -> str:
    """A count with its noun: "one case", "14 methods"."""
    return f"{_SMALL[n] if 0 <= n < len(_SMALL) else f'{n:,}'} {noun}{'' if n == 1 else 's'}"


def plain(text: object) -> str:
    """Text on one line, without what would move a terminal's cursor or change its colours."""
    return _CONTROL.sub(lambda found: "" if found[0].startswith("\x1b") else " ", str(text)).strip()


def escape_latex(text: str) -> str:
    """Text that LaTeX sets as it is."""
    return re.sub("|".join(map(re.escape, _LATEX)), lambda found: _LATEX[found[0]], text)


def escape_markdown(text: object) -> str:
    """Text that Markdown and the HTML within it show as it is."""
    return re.sub(r"([\\`*_{}\[\]<>#|!~&])", r"\\\1", plain(text))


def escape_cell(text: object) -> object:
    """Text that no spreadsheet reads as a formula: an apostrophe goes before ``= + - @``."""
    if not isinstance(text, str):
        return text
    return f"'{plain(text)}" if re.match(r"\s*[=+\-@]", text) else plain(text)


# --- files ----------------------------------------------------------------------------------------------


def write_csv(run: Run, out: Path) -> Path:
    """Write the cells of a run to ``out``, and return its path.

    One row per input, method and reduction: ``model`` (the input), ``method`` (with its settings),
    ``reduction``, ``n_input``, ``target_count``, ``n_repeats``, ``n_ok``, ``status``, ``message``, ``subset``
    and ``needs_mesh`` (true, false or empty); per number its median over the repeats and ``<key>_low``,
    ``<key>_high``; ``time_<stage>_s``, the median seconds of a stage. An empty field is a missing value.
    Names do not change between versions; `records.csv` of a run holds the single repeats.
    """
    table = cells(run.frame)
    spans = [f"{key}{end}" for key in columns(table) for end in ("", "_low", "_high")]
    fixed = [
        *CELL,
        "n_input",
        "target_count",
        "n_repeats",
        "n_ok",
        "status",
        "message",
        "subset",
        "needs_mesh",
    ]
    table = table[[*fixed, *spans, *filter(stage_name, table)]]
    table = table.rename(columns={"input": "model", "label": "method"}).map(escape_cell)
    truths = {name: table[name].map({True: "true", False: "false"}) for name in ("subset", "needs_mesh")}
    replace_text(out, table.assign(**truths).to_csv(index=False, lineterminator="\n"))
    return out


def write_latex(run: Run, out: Path) -> Path:
    r"""Write one ``table`` environment per input of a run; the document needs ``\usepackage{booktabs}``."""
    texts = ["% \\usepackage{booktabs}"]
    for caption, table in _error_tables(run, escape_latex, r"\textbf{{{}}}".format):
        texts.append(
            table.style.hide(axis="index").to_latex(
                caption=caption, position_float="centering", hrules=True, multicol_align="c",
                column_format="l" + "r" * (table.shape[1] - 1),
            )
        )  # fmt: skip
    replace_text(out, "\n".join(texts))
    return out


def write_markdown(run: Run, out: Path) -> Path:
    """Write one Markdown table per input of a run to ``out``, and return its path."""
    tables = [
        f"{caption}\n\n"
        + "\n".join(markdown_table([": ".join(filter(None, key)) for key in table], table.values))
        for caption, table in _error_tables(run, escape_markdown, "**{}**".format)
    ]
    replace_text(out, "\n\n".join(tables or ["The run holds no case."]) + "\n")
    return out


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]], align: str = "---:") -> Iterator[str]:
    """Lines of a table, its texts escaped already."""
    for line in (head, ["---", *[align] * (len(head) - 1)], *rows):
        yield f"| {' | '.join(line)} |"


def _error_tables(
    run: Run, escape: Callable[[str], str], bold: Callable[[str], str]
) -> Iterator[tuple[str, pd.DataFrame]]:
    """Caption and table of each input: methods by reductions, the error with its range, and the runtime."""
    for name, table in cells(run.frame).groupby("input", sort=False):
        lowest = table.groupby("reduction")[ERROR].transform("min")
        texts = [escape(_error_text(cell)) for _, cell in table.iterrows()]
        errors = [bold(t) if e == low else t for t, e, low in zip(texts, table[ERROR], lowest, strict=True)]
        runtimes = [seconds(s) if n else "" for s, n in zip(table[RUNTIME], table.n_ok, strict=True)]
        wide = table.assign(error=errors, runtime=runtimes).pivot(
            index="label", columns="reduction", values=["error", "runtime"]
        )
        wide = wide.fillna({key: "not run" if key[0] == "error" else "" for key in wide})
        wide = wide.swaplevel(axis=1).sort_index(axis=1)
        order = table.sort_values(["reduction", ERROR], ascending=[False, True], kind="stable").label.unique()
        heads = [("", "Method"), *((f"{escape(percent(r))} removed", what) for r, what in wide)]
        rows = wide.loc[order].rename(lambda method: escape(plain(method))).reset_index()
        yield _caption(str(name), table, escape), rows.set_axis(pd.MultiIndex.from_tuples(heads), axis=1)


def _caption(name: str, table: pd.DataFrame, escape: Callable[[str], str]) -> str:
    """What the table shows; the range is named where one is printed."""
    ranged = " and range of the repeats" if table[f"{ERROR}_low"].lt(table[f"{ERROR}_high"]).any() else ""
    return escape(
        f"Plane error (eq. 27, 8 neighbours, % of the bounding-box diagonal, median{ranged}) and runtime "
        f"(median) on {plain(name)}, {table.n_input.iloc[0]:,} points, by the share of points removed."
    )


def _error_text(cell: pd.Series) -> str:
    if not cell.n_ok:
        return cell.status
    if math.isnan(cell[ERROR]):
        return "no error measured"
    middle, low, high = (number(cell[f"{ERROR}{end}"]) for end in ("", "_low", "_high"))
    return middle if low == high else f"{middle} ({low}–{high})"


# --- the terminal ---------------------------------------------------------------------------------------


def align(rows: Sequence[Sequence[str]], left: Sequence[int] = (0,), width: int = NARROW) -> list[str]:
    """A head, a rule and rows as lines of ``width`` at most; the first column is cut to make them fit.

    Parameters
    ----------
    rows : sequence of sequence of str
        The head first.
    left : sequence of int
        Columns flush left; the others stand right.
    width : int
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    widths[0] = max(8, min(widths[0], width - sum(widths[1:]) - 2 * len(widths[1:])))
    lines = [
        "  ".join(
            c.ljust(w) if i in left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))
        )
        for row in ([_cut(first, widths[0]), *others] for first, *others in rows)
    ]
    return [lines[0].rstrip(), "-" * max(len(line.rstrip()) for line in lines), *map(str.rstrip, lines[1:])]


def format_run(run: Run, width: int = NARROW) -> str:
    """Every table of a run, with a line on how to read them."""
    frame, table = run.frame, cells(run.frame)
    table = table.assign(ratio=ratios(table, REFERENCE, [ERROR])[ERROR])
    plain_inputs = table[table.perturbation.eq("none")].groupby(["input", "reduction"], sort=False)
    parts = [_cell_table(group, width) for _, group in plain_inputs]
    parts += _perturbation_tables(perturbation_curves(frame), width)
    parts += ["\n".join(lines) for lines in [_notes(table[table.perturbation.ne("none")], width)] if lines]
    return "\n\n".join([*parts, _legend(run, width)])


def _cell_table(table: pd.DataFrame, width: int) -> str:
    """One input and reduction: the lowest error first."""
    first, asked = table.iloc[0], table.target_count.unique()
    target = f"{asked[0]:,}" if len(asked) == 1 else "as many as the paper's method kept"
    title = f"{plain(first.input)}: {percent(first.reduction)} removed, "
    title += f"{target} of {first.n_input:,} points asked"
    head = ("method", "points", "kept as", "mesh", "plane error", "ratio", "runtime")
    rows = [_row(cell) for _, cell in table.sort_values(ERROR, kind="stable").iterrows()]
    lines = align([head, *rows], (0, 2, 3), width)
    return "\n".join([*textwrap.wrap(title, width), *lines, *_notes(table, width)])


def _row(cell: pd.Series) -> tuple[str, ...]:
    low, high = cell.n_output_low, cell.n_output_high
    counts = "-" if math.isnan(low) else f"{low:,.0f}" if low == high else f"{low:,.0f}..{high:,.0f}"
    return (
        plain(cell.label),
        counts,
        {True: "subset", False: "moved"}.get(cell.subset, "-"),
        {True: "needed", False: "no"}.get(cell.needs_mesh, "-"),
        _number(cell[ERROR], ".4f") if cell.n_ok else cell.status,
        _number(cell.ratio, ".2f"),
        seconds(cell[RUNTIME]) if cell.n_ok else "-",
    )


def _perturbation_tables(curves: pd.DataFrame, width: int) -> Iterator[str]:
    """One table per model, reduction and kind: the error by level, and how much it grows."""
    for (model, reduction, kind), group in curves.groupby(level=[0, 1, 2], sort=False) if len(curves) else ():
        table = group.droplevel([0, 1, 2]).dropna(axis=1, how="all")
        level = float(table.columns[-1])
        growth = table[level] / table[0.0].where(table[0.0] > 0) if 0.0 in table else table[level] * math.nan
        head = ("method", *(f"{k:g}" if k else "clean" for k in table), "growth")
        rows = [
            (plain(name), *(_number(e, ".4f") for e in table.loc[name]), _number(growth[name], ".2f") + "x")
            for name in table.sort_values(level, kind="stable").index
        ]
        title = f"{plain(model)} with {kind}: {percent(reduction)} removed, plane error in % of the diagonal"
        words = [_extremes(growth.dropna(), level)]
        if kind in _CLAIMED:
            words.append(_claim(table[level], growth.dropna(), level))
        told = [line for text in words for line in textwrap.wrap(text, width)]
        yield "\n".join([*textwrap.wrap(title, width), *align([head, *rows], (0,), width), *told])


def _extremes(growth: pd.Series, level: float) -> str:
    """Who suffers least and most at the largest level."""
    if len(growth) < 2:
        return ""
    least, most = growth.idxmin(), growth.idxmax()
    return (
        f"At {level:g} the error of {least} grows least ({growth[least]:.2f} times the clean one), "
        f"that of {most} most ({growth[most]:.2f} times)."
    )


def _claim(errors: pd.Series, growth: pd.Series, level: float) -> str:
    """Whether the paper's method is robust, as its abstract says: less growth and error than most others.

    Growth alone would praise a method whose error is large before any perturbation.
    """
    others = growth.index.drop(_PAPER, errors="ignore")
    if _PAPER not in growth or others.empty:
        return ""
    own, usual = growth[_PAPER], growth[others].median()
    error, usual_error = errors[_PAPER], errors[others].median()
    claim = "confirmed" if own < usual and error < usual_error else "refuted"
    return (
        f"The paper calls its method robust: at {level:g} the error of {_PAPER} grows {own:.2f} times "
        f"(median of the other methods {usual:.2f}) and is {error:.4f} (median {usual_error:.4f}); "
        f"the claim is {claim} here, as it takes both below."
    )


def _notes(table: pd.DataFrame, width: int) -> list[str]:
    """What the cases have to say, each sentence once."""
    some = [c for _, c in table.iterrows() if c.message]
    told = dict.fromkeys(
        f"{plain(c.label)}: {f'{c.status}. ' if c.n_ok else ''}{plain(c.message)}" for c in some
    )
    indents = {"initial_indent": "  ", "subsequent_indent": "    "}
    return [line for note in told for line in textwrap.wrap(note, width - 2, **indents)]


def _legend(run: Run, width: int) -> str:
    repeats, threads = run.plan.get("repeats", 1), run.plan.get("threads", "?")
    text = (
        "plane error (eq. 27): mean distance of the original points to the plane through their 8 nearest "
        "kept points, in % of the bounding-box diagonal; ratio: that error over MeshLab's Poisson disk at "
        f"the same count; runtime: median of {repeats} on {threads} thread{'s' * (threads != 1)}, the call "
        "alone."
    )
    if run.plan.get("jobs", 1) > 1:
        text += " Several cases ran at once: do not compare the runtimes."
    return "\n".join(textwrap.wrap(text, width))


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "-"


def _cut(name: str, width: int) -> str:
    """A name that fits a column; a longer one ends in two dots."""
    return name if len(name) <= width else f"{name[: width - 2]}.."
