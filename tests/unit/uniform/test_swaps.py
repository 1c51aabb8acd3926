"""What an exchange must keep, and what it must gain."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from lpcompare.errors import InputError, UnknownName
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.planes import plane_distances
from lpcompare.geometry.surface import estimate_surface
from lpcompare.metrics.comparison import Comparison
from lpcompare.uniform.densities import DensityBand
from lpcompare.uniform.disks import disk_radius
from lpcompare.uniform.neighborhoods import SIZES, Neighborhoods
from lpcompare.uniform.swaps import EMPHASES, refine, swap_points


def bumps(n_points=3000, seed=0):
    """A surface that is flat on one side and wavy on the other."""
    x, y = np.random.default_rng(seed).random((2, n_points))
    return np.column_stack([x, y, np.where(x > 0.5, 0.05 * np.sin(30 * x) * np.sin(30 * y), 0.0)])


def random_rows(n_points, n_keep, seed=0):
    return np.sort(np.random.default_rng(seed).choice(n_points, n_keep, replace=False))


def error(points, rows):
    comparison = Comparison(points, points[rows])
    return np.mean([comparison.plane_errors(k).mean() for k in SIZES])


def reach(points, rows):
    return Comparison(points, points[rows]).forward_distances.max()


def test_error_falls_and_holes_close():
    points = bumps()
    before = random_rows(len(points), 300)
    after = refine(points, before)
    assert error(points, after) < 0.85 * error(points, before)
    assert reach(points, after) < 0.9 * reach(points, before)


@given(
    seed=st.integers(0, 2**32 - 1),
    n_points=st.integers(1, 120),
    share=st.floats(0.01, 1.0),
    copies=st.integers(1, 3),
)
@settings(max_examples=40, deadline=None)
def test_count_rows_and_input_are_kept(seed, n_points, share, copies):
    rng = np.random.default_rng(seed)
    points = np.repeat(rng.normal(size=(n_points, 3)) * [1.0, 1.0, 0.1], copies, axis=0)
    rows = random_rows(len(points), max(1, int(share * len(points))), seed)
    given_points, given_rows = points.copy(), rows.copy()
    after = refine(points, rows)
    assert len(after) == len(rows)
    assert (np.diff(after) > 0).all()
    assert after[0] >= 0
    assert after[-1] < len(points)
    assert np.array_equal(points, given_points)
    assert np.array_equal(rows, given_rows)


@pytest.mark.parametrize("n_keep", [20, 100, 900])
def test_neither_holes_nor_the_error_grow(n_keep):
    tree, emphasis = Neighbors(bumps()), EMPHASES["balanced"]
    normals, limit = estimate_surface(tree).normals, 1.28 * disk_radius(tree.sorted_points, n_keep)

    def rank(kept):
        return Neighborhoods(tree, normals, kept, emphasis.triangle_share).rank(limit)

    first = random_rows(len(tree.points), n_keep)
    rows = swap_points(tree, normals, first, n_rounds=30)
    again = swap_points(tree, normals, rows)
    assert rank(again) <= rank(rows) < rank(first)


def test_same_input_same_points_on_one_thread_or_two(monkeypatch):
    points, rows = bumps(), random_rows(3000, 400)
    results = []
    for threads in "112":
        monkeypatch.setenv("LPCOMPARE_THREADS", threads)
        results.append(refine(points, rows))
    assert np.array_equal(results[0], results[1])
    assert np.array_equal(results[0], results[2])


def test_far_from_the_origin_the_same_points():
    points, rows = bumps(), random_rows(3000, 400)
    exact = np.round(points * 2**20) / 2**20
    assert np.array_equal(refine(exact, rows), refine(np.add(exact, [2**19, 2**22, 0]), rows))


def test_no_rounds_change_nothing():
    rows = random_rows(3000, 100)
    assert np.array_equal(refine(bumps(), rows, n_rounds=0), rows)


def halves(points):
    """Two clusters, the costs of their points (eq. 13, mean 1), and how far kept points are from that mean."""
    labels = (points[:, 1] > 0.5).astype(np.intp)
    centroids = np.array([points[labels == c].mean(axis=0) for c in (0, 1)])
    costs = 1 / np.linalg.norm(points - centroids[labels], axis=1)
    costs /= np.array([costs[labels == c].mean() for c in (0, 1)])[labels]

    def worst(kept):
        return max(abs(costs[kept[labels[kept] == c]].mean() - 1) for c in (0, 1))

    return labels, costs, worst


@pytest.mark.parametrize("height", [1.0, 0.0])
def test_a_density_comes_back_to_its_band(height):
    """Also on an exact plane, where no point has an error."""
    tree = Neighbors(bumps() * [1.0, 1.0, height])
    labels, costs, worst = halves(tree.sorted_points)
    far = np.flatnonzero(costs < 0.9)[:: len(costs) // 400]
    normals = estimate_surface(tree).normals
    rows = swap_points(tree, normals, far, n_rounds=8, band=DensityBand(labels, costs, 0.01))
    assert worst(far) > 0.1
    assert worst(rows) < 0.011


def test_a_density_stays_in_its_band():
    tree = Neighbors(bumps())
    labels, costs, worst = halves(tree.sorted_points)
    normals = estimate_surface(tree).normals
    far = np.flatnonzero(costs < 0.9)[:: len(costs) // 400]
    near = swap_points(tree, normals, far, n_rounds=8, band=DensityBand(labels, costs, 0.01))
    free = swap_points(tree, normals, near, n_rounds=8)
    held = swap_points(tree, normals, near, n_rounds=8, band=DensityBand(labels, costs, 0.01))
    assert worst(held) < 0.011 < worst(free)


def test_an_outlier_that_looks_urgent_does_not_stay():
    """A point high above a plane has the largest error; keeping it would tilt the planes of its neighbours."""
    ground = np.column_stack([np.random.default_rng(0).random((2000, 2)), np.zeros(2000)])
    points = np.concatenate([ground, [[0.5, 0.5, 0.02]]])
    assert 2000 not in refine(points, random_rows(2000, 200))


def test_no_original_is_beyond_the_hole_limit():
    points = bumps()
    radius = disk_radius(points, 300)
    for emphasis in ("coverage", "balanced", "error"):
        rows = refine(points, random_rows(len(points), 300), n_rounds=15, emphasis=emphasis)
        assert reach(points, rows) <= EMPHASES[emphasis].hole_limit * radius


@pytest.mark.parametrize(("n_points", "within"), [(6000, 0.05), (20000, 0.1)])
def test_the_disk_radius_gives_the_count(n_points, within):
    """Of 12 points for each one kept, all are looked at; of a denser cloud a part, and more fit into it."""
    points = np.column_stack([np.random.default_rng(0).random((n_points, 2)), np.zeros(n_points)])
    radius = disk_radius(points, 500)
    kept: list[np.ndarray] = []
    for point in points[np.random.default_rng(1).permutation(n_points)]:
        if not kept or np.linalg.norm(np.array(kept) - point, axis=1).min() >= radius:
            kept.append(point)
    assert len(kept) == pytest.approx(500, rel=within)
    assert disk_radius(np.zeros((5, 3)), 2) == 0.0


@given(
    seed=st.integers(0, 2**32 - 1),
    n_points=st.integers(20, 500),
    share=st.floats(0.1, 0.6),
    swapped=st.floats(0.0, 0.5),
)
@settings(max_examples=40, deadline=None)
def test_lists_kept_up_to_date_are_those_of_fresh_queries(seed, n_points, share, swapped):
    rng = np.random.default_rng(seed)
    tree = Neighbors(rng.normal(size=(n_points, 3)) * [1.0, 1.0, 0.1])
    points = tree.sorted_points
    rows = random_rows(n_points, max(4, int(share * n_points)), seed)
    state = Neighborhoods(tree, np.tile([0.0, 0.0, 1.0], (n_points, 1)), rows, 0.0)
    for _ in range(4):
        free = np.setdiff1d(np.arange(n_points), state.kept)
        n_swaps = min(int(swapped * len(state.kept)), len(free))
        state.swap(rng.choice(state.kept, n_swaps, replace=False), rng.choice(free, n_swaps, replace=False))
        n_neighbors = min(12, len(state.kept))
        distances, nearest = KDTree(points[state.kept]).query(points, n_neighbors)
        assert np.array_equal(state.kept[nearest], state.lists[:, :n_neighbors])
        assert np.array_equal(state.owners, nearest[:, 0])
        assert state.gaps == pytest.approx(distances[:, :2])
        sizes = tuple(sorted({min(size, n_neighbors) for size in SIZES}))
        expected = plane_distances(points, points, state.lists[:, :n_neighbors], sizes)
        assert state.errors == pytest.approx(expected)


@given(seed=st.integers(0, 2**32 - 1), triangle_share=st.sampled_from([0.0, 0.2, 1.0]))
@settings(max_examples=20, deadline=None)
def test_a_trial_foretells_the_errors_and_changes_nothing(seed, triangle_share):
    rng = np.random.default_rng(seed)
    tree = Neighbors(rng.normal(size=(300, 3)) * [1.0, 1.0, 0.1])
    normals = np.tile([0.0, 0.0, 1.0], (300, 1))
    state, twin = (Neighborhoods(tree, normals, random_rows(300, 90, seed), triangle_share) for _ in range(2))
    for n_swaps in (0, 5, 60):
        free = np.setdiff1d(np.arange(300), state.kept)
        dropped, added = (rng.choice(rows, n_swaps, replace=False) for rows in (state.kept, free))
        foretold = state.try_swap(dropped, added)
        for name in ("kept", "gaps", "errors", "owners"):
            assert np.array_equal(getattr(state, name), getattr(twin, name))
        state.swap(dropped, added)
        twin.swap(dropped, added)
        assert np.array_equal(state.errors, foretold)
        assert np.array_equal(state.errors, twin.errors)


@pytest.mark.parametrize(
    ("rows", "settings", "words"),
    [
        ([0, 0, 1], {}, "distinct rows"),
        ([], {}, "distinct rows"),
        ([0, 3000], {}, "distinct rows"),
        ([0, 1], {"n_rounds": -1}, "n_rounds is -1"),
        ([0, 1], {"emphasis": "speed"}, "speed"),
    ],
)
def test_what_cannot_be_worked_on_is_said(rows, settings, words):
    with pytest.raises((InputError, UnknownName), match=words):
        refine(bumps(), np.array(rows, dtype=np.intp), **settings)
