"""The methods on graphs: what each must show by its publication."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.stats import spearmanr

from lpcompare.geometry.graphs import gaussian_graph, high_pass_energy, nearest_others
from lpcompare.geometry.shares import nearest_shares
from lpcompare.registry import METHODS
from lpcompare_baselines.chen_graph import chen_graph
from lpcompare_baselines.leal_saliency import leal_saliency, sparse_codes
from lpcompare_baselines.mahdaoui_entropy import mahdaoui_entropy
from lpcompare_baselines.qi_graph import qi_graph, solve_shares


def cube(n=24):
    """The faces of a cube, sampled by square grids."""
    a, b = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    faces = [np.stack(np.broadcast_arrays(a, b, np.full_like(a, s)), -1).reshape(-1, 3) for s in (0.0, 1.0)]
    return np.unique(np.concatenate([np.roll(f, k, axis=1) for f in faces for k in range(3)]), axis=0)


def rng(seed=0):
    return np.random.default_rng(seed)


def test_neighbors_are_others_and_the_graph_is_symmetric_and_without_a_scale():
    points = np.repeat(rng().normal(size=(50, 3)), 3, axis=0)
    distances, rows = nearest_others(points, 5)
    assert not (rows == np.arange(150)[:, None]).any()
    assert (np.diff(distances, axis=1) >= 0).all()
    assert (distances[:, :2] == 0).all()
    graph = gaussian_graph(points, 5)
    assert np.array_equal(graph.toarray(), graph.T.toarray())
    assert np.allclose(graph.toarray(), gaussian_graph(1000 * points + 5e5, 5).toarray(), atol=1e-6)


def test_shares_are_the_nearest_ones():
    values = rng().normal(size=200)
    shares = nearest_shares(values, 60.0)
    assert shares.sum() == pytest.approx(60.0)
    inside = (shares > 0) & (shares < 1)
    shift = np.median((values - shares)[inside])
    assert np.allclose(shares, np.clip(values - shift, 0, 1))


def test_chen_draws_the_edges_of_a_cube_in_their_share_of_the_response():
    points = cube()
    response = np.sqrt(high_pass_energy(points, 15))
    on_edge = ((points == 0) | (points == 1)).sum(axis=1) >= 2
    expected = response[on_edge].sum() / response.sum()
    draws = [on_edge[chen_graph(points, 60, rng=rng(s)).indices].mean() for s in range(40)]
    assert on_edge.mean() < 0.5 * expected
    assert np.mean(draws) == pytest.approx(expected, abs=0.04)


def test_chen_does_not_depend_on_the_scale():
    points = rng().normal(size=(500, 3))
    near, far = (chen_graph(s * points, 100, rng=rng()) for s in (1.0, 4096.0))
    assert np.array_equal(near.indices, far.indices)


def test_qi_without_uniformity_keeps_the_greatest_features():
    points = rng().normal(size=(600, 3))
    features = high_pass_energy(points, 15)
    kept = qi_graph(points, 90, rng=rng(), uniformity=0.0).indices
    assert set(kept) == set(np.argsort(-features)[:90])


def test_qi_with_uniformity_keeps_neighborhoods_nearer_to_their_share_than_chance():
    points = rng(3).random((3000, 3)) * [1, 1, 0]
    _, near = nearest_others(points, 15)
    m = len(points) // 10

    def spread(rows):
        return np.var(np.isin(near, rows).sum(axis=1))

    chance = np.mean([spread(rng(s).choice(len(points), m, replace=False)) for s in range(5)])
    loose, tight = (spread(qi_graph(points, m, rng=rng(), uniformity=u).indices) for u in (0.0, 30.0))
    assert tight < 0.9 * chance
    assert tight < loose


def test_qi_solves_its_program():
    """Against the conditions of an optimum: equal slopes inside, ordered ones at the limits."""
    points = rng().normal(size=(80, 3))
    _, near = nearest_others(points, 6)
    members = csr_array((np.ones(480), near.ravel(), np.arange(81) * 6), shape=(80, 80))
    features, weight = high_pass_energy(points, 6), 0.2
    x = solve_shares(features, members, weight, 20)
    slope = features * (x - 1) + weight * (members.T @ (members @ x - 20 / 80 * 6))
    inside = (x > 0.01) & (x < 0.99)
    level = slope[inside].mean()
    assert x.sum() == pytest.approx(20, abs=1e-6)
    assert np.abs(slope[inside] - level).max() < 0.02
    assert slope[x <= 0.01].min(initial=level) >= level - 0.02
    assert slope[x >= 0.99].max(initial=level) <= level + 0.02


def test_mahdaoui_deletes_the_dense_half_first():
    dense, sparse = rng(1).random((3000, 3)) * [1, 1, 0], rng(2).random((600, 3)) * [1, 1, 0] + [2, 0, 0]
    points = np.vstack([dense, sparse])
    kept = mahdaoui_entropy(points, 600, rng=rng()).indices
    assert (kept >= 3000).mean() > 0.95


@pytest.mark.skipif(bool(METHODS.missing("cloudcompare_random")), reason="CloudCompare is not installed")
def test_cloudcompare_draws_at_random_as_numpy_does():
    """Counts in ten equal stretches of the rows: chi-square with 9 degrees of freedom, limit at 1e-4."""
    from scipy.stats import chi2

    points = rng().normal(size=(2000, 3))
    limit = chi2.isf(1e-4, 9)
    for name in ("cloudcompare_random", "random_sample"):
        rows = METHODS.get(name)(points, 500, rng=rng()).indices
        counts = np.bincount(rows // 200, minlength=10)
        assert counts.sum() == 500
        assert ((counts - 50) ** 2 / 50).sum() < limit


def test_leal_keeps_more_where_the_saliency_is_high():
    points = cube(40)
    result = leal_saliency(points, len(points) // 10, rng=rng())
    saliency = result.info["saliency"]
    tenth = (np.argsort(np.argsort(saliency)) * 10) // len(points)
    shares = np.bincount(tenth[result.indices], minlength=10) / np.bincount(tenth)
    assert spearmanr(np.arange(10), shares).statistic > 0.5
    assert 0 <= saliency.min() <= saliency.max() <= 1


def test_sparse_codes_use_few_atoms_and_lower_the_error():
    features, atoms = rng(1).normal(size=(300, 7)), rng(2).normal(size=(32, 7))
    atoms /= np.linalg.norm(atoms, axis=1, keepdims=True)
    codes = sparse_codes(features, atoms)
    assert (codes != 0).sum(axis=1).max() <= 3
    left = np.linalg.norm(features - codes @ atoms, axis=1) / np.linalg.norm(features, axis=1)
    one = np.sqrt(1 - (np.abs(features @ atoms.T).max(axis=1) / np.linalg.norm(features, axis=1)) ** 2)
    assert (left <= one + 1e-9).all()
    assert left.mean() < 0.8 * one.mean()
