"""run.json: what is written is read again, older and foreign files are met with a sentence."""

import csv
import io
import json
import math

import pytest

from lpcompare.benchmark.record import SCHEMA_VERSION, Record, line_of, load_run
from lpcompare.benchmark.run_folder import RunFolder
from lpcompare.errors import InputError


def record(**fields):
    base = {
        "model": "ball", "method": "x", "variant": "x", "reduction": 0.5, "n_input": 10, "target_count": 5,
        "seed": 0, "repeat": 0, "status": "ok", "metrics": {"plane_error_pct": 0.1}, "key": "k0",
    }  # fmt: skip
    return Record(**(base | fields))


HEAD = {"plan": {"repeats": 1}, "environment": {"python": "3"}, "inputs": {}}


@pytest.fixture
def store(tmp_path):
    store = RunFolder(tmp_path / "run")
    store.begin(HEAD, [])
    return store


def test_records_come_back_as_they_were_written(store):
    rows = [record(), record(repeat=1, status="failed", message='a "b" c', key="k1", settings={"k": [1, 2]})]
    for row in rows:
        store.append(row)
    assert load_run(store.path).records == tuple(rows), "while running"
    assert not load_run(store.path).complete
    store.end(rows, complete=True)
    assert load_run(store.path / "run.json").records == tuple(rows), "after the end"
    assert load_run(store.path).complete


def test_nan_is_null_in_the_file_and_nan_again_in_memory(store):
    store.end([record(metrics={"a": math.nan, "b": 1.0})], complete=True)
    assert "NaN" not in (store.path / "run.json").read_text()
    (back,) = load_run(store.path).records
    assert math.isnan(back.metrics["a"])
    assert back.metrics["b"] == 1.0


def test_tables_have_a_column_for_every_number(store):
    store.end(
        [record(timings={"solve": 0.5}), record(metrics={"hausdorff_pct": 2.0}, key="k1")], complete=True
    )
    head, first, _ = (store.path / "records.csv").read_text().splitlines()
    row = dict(zip(head.split(","), first.split(","), strict=True))
    assert row["time_solve_s"] == "0.5"
    assert row["plane_error_pct"] == "0.1"
    assert row["hausdorff_pct"] == ""


def test_no_cell_of_the_table_is_a_formula(store):
    store.end([record(method="=1+1", message="@SUM(A1)", settings={"=": 1})], complete=True)
    (row,) = csv.DictReader(io.StringIO((store.path / "records.csv").read_text()))
    assert (row["method"], row["message"], row["settings"]) == ("'=1+1", "'@SUM(A1)", '{"=":1}')


def test_the_frame_has_a_row_per_record_and_a_column_per_metric_and_stage(store):
    rows = [
        record(timings={"solve": 0.5}, variant="m k=2", refined=True, info={"n": 3}),
        record(repeat=1, status="failed", metrics={}, perturbation="noise", perturbation_level=0.5),
    ]
    store.end(rows, complete=True)
    frame = load_run(store.path).frame
    assert list(frame.label) == ["m k=2 + swaps", "x"]
    assert list(frame.input) == ["ball", "ball + noise 0.5"]
    assert frame.time_solve_s[0] == 0.5
    assert frame.plane_error_pct[0] == 0.1
    assert math.isnan(frame.plane_error_pct[1])
    assert frame["info"][0] == {"n": 3}
    assert frame.groupby("status").size().to_dict() == {"ok": 1, "failed": 1}


def test_the_frame_of_no_records_has_every_column_and_type(store):
    store.end([], complete=True)
    empty = load_run(store.path).frame
    store.end([record(timings={}, metrics={})], complete=True)
    assert list(empty.dtypes.items()) == list(load_run(store.path).frame.dtypes.items())
    assert empty.empty


def test_the_first_versions_rows_load_without_the_fields_that_came_later(store):
    old = {
        "schema_version": 1,
        "plan": {},
        "environment": {},
        "records": [
            {"model": "b", "method": "m", "reduction": 0.5, "n_input": 4, "target_count": 2, "seed": 0,
             "repeat": 0, "status": "ok", "unknown_field": 3}
        ],
    }  # fmt: skip
    (store.path / "run.json").write_text(json.dumps(old))
    run = load_run(store.path)
    assert run.complete
    assert run.records[0].variant == "m"
    assert run.records[0].perturbation == "none"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a readable run"),
        ('{"schema_version": 1, "plan', "not a readable run"),
        ("[1, 2]", "got `array`"),
        ('{"a": 1}', "schema_version"),
        ('{"schema_version": 1}', "field `plan`"),
        ("[" * 100_000, "not a readable run"),
        ('{"schema_version": 2, "plan": ' + "[" * 100_000, "not a readable run"),
        (json.dumps({"schema_version": SCHEMA_VERSION + 1}), "Update lpcompare"),
        (
            json.dumps({"schema_version": 2, **HEAD, "records": [], "inputs": {"a": {"file": "../b.npz"}}}),
            "not a readable run",
        ),
    ],
)
def test_truncated_and_foreign_files_are_met_with_a_sentence(store, text, words):
    (store.path / "run.json").write_text(text)
    with pytest.raises(InputError, match=words):
        load_run(store.path)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("status", "great"),
        ("seed", "0"),
        ("seed", -1),
        ("seed", 2**70),
        ("reduction", None),
        ("metrics", 1),
        ("timings", {"a": "b"}),
        ("cloud", "../../secret.npz"),
        ("cloud", "/etc/passwd"),
        ("cloud", "clouds/../../x.npz"),
    ],
)
def test_a_record_with_a_wrong_field_is_left_out_and_counted(store, field, value):
    rows = [record().to_dict(), record(repeat=1).to_dict() | {field: value}, 3, {"model": "x"}]
    document = {"schema_version": SCHEMA_VERSION, **HEAD, "records": rows}
    (store.path / "run.json").write_text(json.dumps(document))
    run = load_run(store.path)
    assert run.records == (record(),)
    assert run.n_damaged == 3


def test_a_folder_without_a_run_is_met_with_a_sentence(tmp_path):
    with pytest.raises(InputError, match=r"holds no run\.json"):
        load_run(tmp_path)


def test_binary_rubbish_is_met_with_a_sentence(store):
    (store.path / "run.json").write_bytes(b"\x80\x81\x00")
    with pytest.raises(InputError, match="not a readable run"):
        load_run(store.path)


def _damages(line):
    """A line of records.jsonl, damaged in every way that disks know."""
    yield from (line[:5], line[:-2], b"\x00" * 40, b"\xff\n\xfe", b"{}", b"[" * 5000, b'{"model": "b"', b" ")
    for place in range(0, len(line) - 1, 7):
        yield line[:place] + bytes([line[place] ^ 1]) + line[place + 1 :]


def test_damaged_lines_are_left_out_and_the_others_read(store):
    whole = [record(repeat=n) for n in range(3)]
    lines = [line_of(row) for row in whole]
    for damaged in _damages(lines[1].rstrip()):
        (store.path / "records.jsonl").write_bytes(
            lines[0] + b"\n" + damaged + b"\n" + lines[2] + b"\x00\x00"
        )
        run = load_run(store.path)
        assert run.records == (whole[0], whole[2])
        assert run.n_damaged >= 2


def test_lines_of_the_first_schema_are_read(store):
    (store.path / "records.jsonl").write_text(json.dumps(record().to_dict()) + "\n")
    assert load_run(store.path).records == (record(),)


def test_a_text_of_a_record_is_one_bounded_line_that_no_terminal_obeys():
    text = record(message="\x1b[31mred\nnext\ud800" + "x" * 10**6).message
    assert text.isprintable()
    assert text.startswith(" [31mred next x")
    assert len(text) == 1000


def test_a_run_is_a_line_and_a_table(store):
    rows = [record(), record(repeat=1, status="failed", metrics={})]
    store.end(rows, complete=True)
    run = load_run(store.path)
    assert repr(run) == f"Run(ball: 1 ok, 1 failed; {store.path})"
    assert "<table" in run._repr_html_()


def test_a_folder_that_cannot_be_made_is_met_with_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="--out"):
        RunFolder(tmp_path / "file" / "run")
