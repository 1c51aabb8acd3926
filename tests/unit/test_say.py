"""Lines on a terminal: broken between words, none longer than the terminal, nothing lost."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpcompare import cli
from lpcompare.cli._say import broken

WORDS = st.lists(st.text("abc-/._", min_size=1, max_size=12), min_size=1, max_size=40)


@given(WORDS, st.integers(40, 120))
def test_lines_fit_and_keep_every_word(words, width):
    lines = broken(" ".join(words), width).split("\n")
    assert max(map(len, lines)) <= width
    assert " ".join(lines).split() == words


def test_what_follows_stands_below_the_text():
    assert broken("name   " + "word " * 4 + "word", 20) == "name   word word\n       word word\n       word"
    assert broken("  lp_uniform  one\n\nshort", 80) == "  lp_uniform  one\n\nshort"


def test_a_long_path_stays_whole():
    path = "/a/" + "long-folder/" * 10
    assert path in broken(f"The run is in {path}; look at it.", 40).split("\n")[1]


@pytest.mark.parametrize("error", [MemoryError(), RuntimeError("can't start new thread")])
def test_too_little_memory_is_one_sentence(error, monkeypatch, capsys):
    def work(**_):
        raise error

    monkeypatch.setattr(cli, "build_app", lambda *_: work)
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 2
    assert "more memory than there is" in capsys.readouterr().err
