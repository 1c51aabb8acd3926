"""run.json: what is written is read again, older and foreign files are met with a sentence."""

import json
import math

import pytest

from lpcompare.benchmark.record import SCHEMA_VERSION, Record, load_run
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
    rows = [record(), record(repeat=1, status="failed", message='a "b"\nc', key="k1", settings={"k": [1, 2]})]
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
    assert "plane_error_pct,1,0.1,0.1,0.1" in (store.path / "summary.csv").read_text()


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
        ("[1, 2]", "no schema_version"),
        ('{"a": 1}', "no schema_version"),
        ('{"schema_version": 1}', "'plan' is missing"),
        (json.dumps({"schema_version": SCHEMA_VERSION + 1}), "Update lpcompare"),
        (json.dumps({"schema_version": 1, **HEAD, "records": [{"model": "x"}]}), "no field 'method'"),
        (json.dumps({"schema_version": 1, **HEAD, "records": [3]}), "not an object"),
    ],
)
def test_truncated_and_foreign_files_are_met_with_a_sentence(store, text, words):
    (store.path / "run.json").write_text(text)
    with pytest.raises(InputError, match=words):
        load_run(store.path)


@pytest.mark.parametrize(
    ("field", "value"), [("status", "great"), ("seed", "0"), ("reduction", None), ("metrics", 1)]
)
def test_a_field_of_the_wrong_kind_is_named(field, value):
    with pytest.raises(InputError, match=field):
        Record.from_dict(record().to_dict() | {field: value})


def test_a_folder_without_a_run_is_met_with_a_sentence(tmp_path):
    with pytest.raises(InputError, match=r"holds no run\.json"):
        load_run(tmp_path)


def test_binary_rubbish_is_met_with_a_sentence(store):
    (store.path / "run.json").write_bytes(b"\x80\x81\x00")
    with pytest.raises(InputError, match="not a readable run"):
        load_run(store.path)


@pytest.mark.parametrize("line", [b'{"model": "b"\n', b"\x00\x00\n", b"\xff\n"])
def test_a_damaged_line_that_is_not_the_last_is_met_with_a_sentence(store, line):
    store.begin(HEAD, [])
    (store.path / "records.jsonl").write_bytes(line + b"{}")
    with pytest.raises(InputError, match=r"records\.jsonl is damaged"):
        load_run(store.path)


def test_a_folder_that_cannot_be_made_is_met_with_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="--out"):
        RunFolder(tmp_path / "file" / "run")
