"""Run files, records, studies and replies, changed at random: a sentence or a result, never a traceback."""

import json
import math
import random
import sys
from contextlib import suppress
from pathlib import Path

import msgspec
import pytest

from lpcompare.benchmark.case import Answer, Request, _last_answer
from lpcompare.benchmark.record import Record, line_of, load_run
from lpcompare.benchmark.study import build_plan, preset_names, read_study
from lpcompare.errors import LpcompareError
from lpcompare.processes.children import Ending
from lpcompare.report.comparison import format_comparison
from lpcompare.report.tables import format_run

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from made_runs import plain_run  # noqa: F401 - a fixture

ODD = (
    None, True, -1, 0, 2**70, -0.5, 1e308, math.nan, "", "../../x", "/etc/passwd", "\x1b[2J", "\ud800", "x" * 5000,
    [], [[]], {}, {"a": {"b": []}}, ["ok"], "NaN", "=1+1",
)  # fmt: skip


@pytest.fixture
def n_mutations(request):
    return 5000 if request.config.getoption("--long") else 500


def changed_bytes(text, rng):
    """Bytes flipped, cut, doubled or put in."""
    data = bytearray(text)
    for _ in range(rng.randint(1, 4)):
        place = rng.randrange(len(data) + 1)
        kind = rng.randrange(5)
        if kind == 0 and data:
            data[place - 1] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del data[place : place + rng.randint(1, 200)]
        elif kind == 2:
            data[place:place] = data[place : place + rng.randint(1, 200)]
        elif kind == 3:
            data[place:place] = rng.randbytes(rng.randint(1, 9))
        else:
            data[place:place] = rng.choice(
                [b"[" * 2000, b'"', b"{", b"\x00" * 64, b"1e999", b"\\ud800", b"\n"]
            )
    return bytes(data)


def changed_values(document, rng):
    """The same document with a value of another kind somewhere, or without a key."""
    copy = json.loads(json.dumps(document))
    for _ in range(rng.randint(1, 3)):
        holder = copy
        while True:
            keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
            if not keys:
                break
            key = rng.choice(keys)
            deeper = isinstance(holder[key], dict | list) and holder[key]
            if not deeper or rng.random() < 0.2:
                if rng.random() < 0.2:
                    del holder[key]
                else:
                    holder[key] = rng.choice(ODD)
                break
            holder = holder[key]
    return copy


def shown(run):
    """Everything that is made of a run without its clouds."""
    text = format_run(run) + repr(run) + run._repr_html_() + format_comparison(run, run)
    assert "\x1b" not in text


def test_run_json(
    plain_run,  # noqa: F811
    tmp_path,
    n_mutations,
):
    rng = random.Random(1)
    text = (plain_run / "run.json").read_bytes()
    document, path, n_read = json.loads(text), tmp_path / "run.json", 0
    for number in range(n_mutations):
        if number % 2:
            path.write_bytes(changed_bytes(text, rng))
        else:
            path.write_text(json.dumps(changed_values(document, rng)))
        with suppress(LpcompareError):
            shown(load_run(tmp_path))
            n_read += 1
    assert n_read > n_mutations / 20, "some mutations are harmless: the tables were tried"


def test_records(
    plain_run,  # noqa: F811
    tmp_path,
    n_mutations,
):
    rng = random.Random(2)
    document = json.loads((plain_run / "run.json").read_text())
    records = load_run(plain_run).records
    text = b"".join(map(line_of, records))
    head = json.dumps(document | {"records": [], "complete": False})
    (tmp_path / "run.json").write_text(head)
    for _ in range(n_mutations):
        (tmp_path / "records.jsonl").write_bytes(changed_bytes(text, rng))
        run = load_run(tmp_path)
        assert set(map(repr, run.records)) <= set(map(repr, records)), "no damaged record is believed"
        assert len(run.records) >= len(records) - 16


def test_studies(tmp_path, n_mutations):
    rng = random.Random(3)
    folder = Path(read_study.__code__.co_filename).parent / "presets"
    texts = [(folder / f"{name}.toml").read_bytes() for name in preset_names()]
    path = tmp_path / "study.toml"
    for _ in range(n_mutations):
        path.write_bytes(changed_bytes(rng.choice(texts), rng))
        with suppress(LpcompareError):
            build_plan(read_study(str(path)))


def test_replies(n_mutations):
    rng = random.Random(4)
    record = Record("ball", "m", 0.5, 10, 5, 0, 0, "ok", key="k", metrics={"a": 1.0}, info={"b": "c"})
    request = Request(record, "in.npz", "0", "", {}, 1)
    answer = Answer(request.token, record, "the call", finished=True)
    text = msgspec.json.encode(answer)
    for number in range(n_mutations):
        if number % 2:
            line = changed_bytes(text, rng).decode(errors="replace")
        else:
            line = json.dumps(changed_values(json.loads(text), rng))
        believed = _last_answer(Ending(0, "", f"\n{line}\n", ""), request)
        assert believed.record.case_id == record.case_id
        assert believed.token == request.token
        assert believed.record.message.isprintable()
