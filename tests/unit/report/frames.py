"""Tables of cells for the tests, from a few numbers."""

from pathlib import Path

from lpcompare.benchmark.record import Record, Run
from lpcompare.report.cells import cells


def run_of(records, environment=None, plan=None, inputs=None):
    """A run that was never on disk."""
    return Run(Path("run"), plan or {}, environment or {}, inputs or {}, tuple(records), True)


def record(method="f", reduction=0.9, repeat=0, status="ok", error=2.0, model="m", metrics=None, **known):
    """A record of 10 of 100 points; without numbers where it is not ok."""
    good = {"runtime_s": 1.0, "n_output": 10, "metrics": {"plane_error_pct": error, **(metrics or {})}}
    known = {**(good if status == "ok" else {"message": "why"}), **known}
    return Record(
        model, method, reduction, 100, 10, 0, repeat, status, variant=known.pop("variant", method), **known
    )


def table_of(*records):
    """The cells of these records."""
    return cells(run_of(records).frame)
