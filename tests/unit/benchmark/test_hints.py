"""Type annotations as rules for values from outside."""

from collections.abc import Mapping
from typing import Any, Literal

import pytest

from lpcompare.benchmark.hints import fits, spell


@pytest.mark.parametrize(
    ("value", "hint", "yes"),
    [
        (3, int, True),
        (3, float, True),
        (3.0, int, False),
        (True, int, False),
        (True, float, False),
        (True, bool, True),
        ("a", str, True),
        (None, int | None, True),
        ("auto", int | Literal["auto"], True),
        ("many", int | Literal["auto"], False),
        ([1, 2], list[int], True),
        ([1, "2"], list[int], False),
        ([1], tuple[int, ...], True),
        ("text", list[str], False),
        ({"a": 1}, Mapping[str, Any], True),
        ([], Mapping[str, Any], False),
        (object(), Any, True),
    ],
)
def test_a_value_fits_or_not(value, hint, yes):
    assert fits(value, hint) is yes


@pytest.mark.parametrize(
    ("hint", "words"),
    [
        (int, "int"),
        (int | Literal["auto"], "int or 'auto'"),
        (float | None, "float or nothing"),
        (list[float], "a list of float"),
        (tuple[int, ...] | None, "a list of int or nothing"),
        (Mapping[str, Any], "a table"),
    ],
)
def test_annotations_are_spelled_for_people(hint, words):
    assert spell(hint) == words
