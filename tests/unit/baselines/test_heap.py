"""The heap against sorting: whatever changes, keys come in order and equal keys by the rule."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare_baselines._heap import heap_of, pop, settle

KEYS = st.lists(st.integers(0, 5), min_size=1, max_size=30)
"""Few values, so that many are equal."""


def popped(heap, place, keys, last_first):
    return [int(pop(heap, size, place, keys, last_first)) for size in range(len(keys), 0, -1)]


def in_order(keys, last_first):
    return sorted(range(len(keys)), key=lambda row: (keys[row], -row if last_first else row))


@settings(deadline=None)
@given(KEYS, st.booleans())
def test_rows_come_by_their_keys_and_equal_ones_by_the_rule(numbers, last_first):
    keys = np.array(numbers, dtype=float)
    assert popped(*heap_of(keys, last_first), keys, last_first) == in_order(numbers, last_first)


@settings(deadline=None)
@given(KEYS, st.booleans(), st.data())
def test_a_row_whose_key_has_changed_finds_its_place(numbers, last_first, data):
    keys = np.array(numbers, dtype=float)
    heap, place = heap_of(keys, last_first)
    row = data.draw(st.integers(0, len(keys) - 1))
    keys[row] = data.draw(st.integers(-1, 6))
    settle(place[row], heap, len(keys), place, keys, last_first)
    assert popped(heap, place, keys, last_first) == in_order(keys, last_first)
