"""A table on disk: measured once per case, taken up after a kill."""

import pytest
from reports.paper.table import Table

from lpcompare.errors import InputError

CASES = [{"model": "a", "k": k} for k in range(4)]


def measure(case):
    return {"square": case["k"] ** 2, "third": case["k"] / 3}


def test_every_case_is_measured_once(tmp_path):
    calls = []

    def counted(case):
        calls.append(case["k"])
        return measure(case)

    path = tmp_path / "t.csv"
    list(Table(path, ("model", "k")).fill(CASES[:2], counted))
    list(Table(path, ("model", "k")).fill(CASES, counted))
    assert calls == [0, 1, 2, 3]
    assert [r["square"] for r in Table(path, ("model", "k")).rows] == ["0", "1", "4", "9"]


@pytest.mark.parametrize("cut", [1, 5, 9])
def test_a_last_line_cut_by_a_kill_is_measured_again(tmp_path, cut):
    path = tmp_path / "t.csv"
    list(Table(path, ("model", "k")).fill(CASES, measure))
    whole = path.read_text(encoding="utf-8")
    path.write_text(whole[:-cut], encoding="utf-8")
    list(Table(path, ("model", "k")).fill(CASES, measure))
    assert path.read_text(encoding="utf-8") == whole


def test_a_share_of_zero_is_the_same_case_when_it_is_read_again(tmp_path):
    path, cases = tmp_path / "t.csv", [{"share": share} for share in (0.0, 0.25, 1.0)]
    list(Table(path, ("share",)).fill(cases, lambda case: {"twice": 2 * case["share"]}))
    list(Table(path, ("share",)).fill(cases, lambda case: pytest.fail("measured again")))


def test_a_foreign_file_is_refused(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("x,y\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="--out"):
        Table(path, ("model", "k"))
