r"""The tables of a run in LaTeX; the document needs ``\usepackage{booktabs}``."""

from __future__ import annotations

import re
from pathlib import Path

from lpcompare.benchmark.record import Run
from lpcompare.files import replace_text
from lpcompare.report.cells import gather_cells
from lpcompare.report.error_table import ErrorTable, caption, error_tables

_SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#", "%": r"\%",
    "_": r"\_", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}",
    "<": r"\textless{}", ">": r"\textgreater{}",
    "–": "--", "\n": " ",
}  # fmt: skip


def write_latex(run: Run, out: Path) -> Path:
    """Write one ``table`` environment per model of a run to ``out``, and return its path."""
    tables = [_table(table) for table in error_tables(gather_cells(run.records))]
    replace_text(out, "% \\usepackage{booktabs}\n" + "\n".join(tables))
    return out


def escape(text: str) -> str:
    """Text that LaTeX sets as it is."""
    return re.sub("|".join(map(re.escape, _SPECIAL)), lambda found: _SPECIAL[found[0]], text)


def _table(table: ErrorTable) -> str:
    n = len(table.reductions)
    spans = " & ".join(rf"\multicolumn{{2}}{{c}}{{{escape(r)} removed}}" for r in table.reductions)
    rules = " ".join(rf"\cmidrule(lr){{{2 + 2 * i}-{3 + 2 * i}}}" for i in range(n))
    body = "\n".join(_row(table, method, entries) for method, entries in table.rows)
    return "\n".join(
        (
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{escape(caption(table))}}}",
            rf"\begin{{tabular}}{{l{'rr' * n}}}",
            r"\toprule",
            rf"& {spans} \\",
            rules,
            rf"Method{' & error & runtime' * n} \\",
            r"\midrule",
            body,
            r"\bottomrule",
            r"\end{tabular}",
            r"\end{table}",
            "",
        )
    )


def _row(table: ErrorTable, method: str, entries: tuple[tuple[str, str], ...]) -> str:
    cells = [escape(method)]
    for column, (error, runtime) in enumerate(entries):
        text = escape(error)
        cells += [rf"\textbf{{{text}}}" if (method, column) in table.lowest else text, escape(runtime)]
    return " & ".join(cells) + r" \\"
