"""Neighborhoods that are kept up to date equal those made anew."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.uniform.neighborhoods import Neighborhoods


@pytest.mark.parametrize("share", [0.0, 0.3])
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n_kept=st.integers(5, 60), n_swaps=st.integers(1, 4))
def test_swaps_leave_what_a_fresh_start_has(share, seed, n_kept, n_swaps):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(300, 3)) * [1.0, 1.0, 0.1]
    normals = rng.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    tree = Neighbors(points)
    state = Neighborhoods(tree, normals, rng.choice(300, n_kept, replace=False), share)
    for _ in range(n_swaps):
        n_changed = int(rng.integers(1, n_kept // 2))
        dropped = rng.choice(state.kept, n_changed, replace=False)
        added = rng.choice(np.setdiff1d(np.arange(300), state.kept), n_changed, replace=False)
        state.swap(dropped, added)
        fresh = Neighborhoods(tree, normals, state.kept, share)
        assert np.array_equal(state.owners, fresh.owners)
        assert np.array_equal(state.gaps, fresh.gaps)
        assert np.array_equal(state.errors, fresh.errors)
