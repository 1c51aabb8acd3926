"""Stage 3: the boolean program against brute force, its certificates and its solvers."""

from itertools import combinations
from threading import Event

import cvxpy as cp
import highspy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpcompare.checks import target_from_reduction
from lpcompare.errors import SolverError
from lpcompare.paper.budget import allocate_budget, split_budget
from lpcompare.paper.certificate import TOLERANCE, DensityGoal, certify
from lpcompare.paper.density import cluster_density, inverse_distance_costs
from lpcompare.paper.highs import Canonical
from lpcompare.paper.program import Program, SolverSettings, build_program, select
from lpcompare.paper.reduction import Reading
from lpcompare.paper.start import exchange, starting_mask


def select_one(costs, n_keep, goal, *, rng, settings=None, cancelled=None):
    (result,) = select([Program(costs, n_keep, goal)], [rng], settings, cancelled=cancelled)
    return result


def generators(n):
    return np.random.default_rng(0).spawn(n)


def costs_of(n_points, seed):
    points = np.random.default_rng(seed).normal(size=(n_points, 3))
    return inverse_distance_costs(points, points.mean(axis=0))


def brute_force(costs, n_keep, goal):
    return min(goal.objective(costs[list(rows)]) for rows in combinations(range(len(costs)), n_keep))


@pytest.mark.parametrize("density", ["mean", "printed"])
@pytest.mark.parametrize("method", ["lp_density", "lp_printed"])
@pytest.mark.parametrize("block", range(4))
def test_objective_is_that_of_brute_force(method, density, block):
    for seed in range(40 * block, 40 * block + 40):
        rng = np.random.default_rng(seed)
        n_points = int(rng.integers(2, 13))
        n_keep = int(rng.integers(1, n_points + 1))
        costs, mean_cost = costs_of(n_points, seed)
        goal = Reading(method, density).goal(costs, n_keep, mean_cost)
        mask, certificate = select_one(costs, n_keep, goal, rng=rng)
        best = brute_force(costs, n_keep, goal)
        assert mask.sum() == n_keep
        assert certificate.objective == pytest.approx(goal.objective(costs[mask]), abs=1e-15)
        assert certificate.objective <= best + TOLERANCE * goal.density
        assert certificate.proven, certificate
        assert certificate.bound <= best + 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_objective_is_that_of_brute_force_on_fourteen_points(seed):
    costs, _ = costs_of(14, seed)
    goal = DensityGoal(1.0)
    _, certificate = select_one(costs, 7, goal, rng=np.random.default_rng(seed))
    assert certificate.objective <= brute_force(costs, 7, goal) + TOLERANCE


@pytest.mark.parametrize("solver", ["highs-cold", "SCIPY"])
@pytest.mark.parametrize("k", [1.0, 3.0])
def test_other_solvers_agree(solver, k):
    for seed in range(5):
        costs, _ = costs_of(9, seed)
        goal = DensityGoal(1.0, k)
        found = select_one(costs, 3, goal, rng=np.random.default_rng(0), settings=SolverSettings(solver))[1]
        assert found.objective <= brute_force(costs, 3, goal) + 1e-5


def test_printed_reading_is_proven_by_sorting():
    costs, _ = costs_of(300, 0)
    mask, certificate = select_one(costs, 90, DensityGoal(1.0, 300 / 90), rng=np.random.default_rng(0))
    assert certificate.proof == "sorting"
    assert certificate.gap <= TOLERANCE
    assert np.array_equal(np.flatnonzero(mask), np.sort(np.argsort(costs)[:90])), "the farthest points"


def test_density_reading_is_proven_by_zero():
    costs, _ = costs_of(300, 0)
    mask, certificate = select_one(costs, 90, DensityGoal(1.0), rng=np.random.default_rng(0))
    assert (certificate.status, certificate.proof) == ("optimal", "zero")
    assert certificate.residual == abs(costs[mask].mean() - 1) <= TOLERANCE


def test_a_target_between_the_mean_and_the_extreme_is_reached():
    costs, _ = costs_of(200, 1)
    ordered = np.sort(costs)
    for wanted in (ordered[:60].mean() * 1.02, ordered[-60:].mean() * 0.98, ordered[:60].mean() * 1.0001):
        mask, certificate = select_one(costs, 60, DensityGoal(wanted), rng=np.random.default_rng(0))
        assert mask.sum() == 60
        assert certificate.proven


def test_nothing_to_choose_is_counted():
    costs, _ = costs_of(5, 0)
    for n_keep in (0, 5):
        mask, certificate = select_one(costs, n_keep, DensityGoal(1.0), rng=np.random.default_rng(0))
        assert mask.sum() == n_keep
        assert (certificate.proof, certificate.status) == ("counting", "optimal")
    empty, certificate = select_one(np.empty(0), 0, DensityGoal(0.0), rng=np.random.default_rng(0))
    assert len(empty) == 0
    assert certificate.residual == 0


def test_program_has_the_rows_of_the_paper():
    costs = np.array([0.5, 1.0, 1.5])
    problem, x, _ = build_program([Program(costs, 2, DensityGoal(1.0, 1.5))])
    assert x.attributes["boolean"]
    assert len(problem.constraints) == 4
    data, *_ = problem.get_problem_data(cp.HIGHS)
    assert sorted(np.unique(np.abs(data["A"].toarray()))) == pytest.approx([0, 0.375, 0.75, 1, 1.125])


def test_a_time_limit_keeps_the_incumbent_and_says_so():
    costs = np.random.default_rng(0).integers(1, 4, size=40) + np.random.default_rng(1).normal(size=40) * 1e-3
    goal = DensityGoal(float(costs.mean()) + 3e-5)
    limited = SolverSettings(time_limit=0.0)
    mask, certificate = select_one(costs, 3, goal, rng=np.random.default_rng(0), settings=limited)
    assert mask.sum() == 3
    assert certificate.proven or certificate.status == "time limit"
    assert certificate.objective >= certificate.bound


def test_clusters_solved_together_are_solved_as_each_alone():
    programs = []
    for seed, (n_points, n_keep) in enumerate([(40, 9), (7, 0), (300, 90), (5, 5), (25, 3)]):
        costs, _ = costs_of(n_points, seed)
        programs.append(Program(costs, n_keep, DensityGoal(1.0, 1.0 + 0.5 * (seed == 4))))
    steps = []
    together = select(
        programs, generators(len(programs)), progress=lambda done, total: steps.append((done, total))
    )
    for program, rng, (mask, certificate) in zip(programs, generators(5), together, strict=True):
        alone, proof = select_one(program.costs, program.n_keep, program.goal, rng=rng)
        assert np.array_equal(mask, alone)
        assert certificate == proof
    assert steps == [(done, 5) for done in range(1, 6)]


def test_a_solve_after_one_of_the_users_own_with_other_threads():
    costs, _ = costs_of(30, 0)
    problem, x, y = build_program([Program(costs, 9, DensityGoal(1.0))])
    highspy.Highs.resetGlobalScheduler(True)
    problem.solve(solver=cp.HIGHS, threads=2)
    canonical, start = Canonical(problem), np.concatenate([x.value, y.value])
    columns = np.concatenate([canonical.columns(x), canonical.columns(y)])
    outcome = canonical.solve_from(columns, start, objective_target=1e-6, time_limit=5.0, gap=0.0)
    assert outcome.status == "optimal"
    problem.solve(solver=cp.HIGHS, threads=1)


def test_a_joint_problem_is_the_sum_of_its_parts():
    programs = [Program(costs_of(n, n)[0], n // 3, DensityGoal(1.0)) for n in (6, 9, 12)]
    joint, _, y = build_program(programs)
    joint.solve(solver=cp.HIGHS)
    for program, objective in zip(programs, y.value, strict=True):
        assert objective == pytest.approx(brute_force(program.costs, program.n_keep, program.goal), abs=1e-6)


def test_a_cancelled_solve_ends_with_its_start():
    cancelled = Event()
    cancelled.set()
    costs = np.round(np.random.default_rng(0).uniform(1, 2, size=60), 3)
    goal = DensityGoal(float(costs.mean()) + 1.23456e-5)
    mask, _ = select_one(costs, 7, goal, rng=np.random.default_rng(0), cancelled=cancelled)
    assert mask.sum() == 7


def test_a_cold_solver_without_a_solution_is_one_sentence():
    costs, _ = costs_of(2000, 0)
    with pytest.raises(SolverError, match="time_limit"):
        select_one(
            costs,
            600,
            DensityGoal(1.0),
            rng=np.random.default_rng(0),
            settings=SolverSettings("SCIPY", time_limit=0.0),
        )


@pytest.mark.parametrize("solver", ["highs", "highs-cold", "SCIPY"])
@pytest.mark.parametrize("gap", [0.0, 0.9])
def test_what_a_solver_leaves_within_its_gap_is_not_called_proven(solver, gap):
    for seed in range(6):
        costs = np.round(np.random.default_rng(seed).uniform(2, 8, size=12)) / 4
        goal = DensityGoal(float(costs.mean()) + 1e-3)
        settings = SolverSettings(solver, gap=gap)
        certificate = select_one(costs, 5, goal, rng=np.random.default_rng(seed), settings=settings)[1]
        best = brute_force(costs, 5, goal)
        assert certificate.bound <= best + 1e-9
        assert certificate.proven == (certificate.objective <= certificate.bound + TOLERANCE * goal.density)
        assert certificate.status == ("optimal" if certificate.proven else "gap")


@pytest.mark.parametrize("solver", ["highs", "highs-cold"])
@pytest.mark.parametrize("density", [1e-200, 1e-18, 1e14, 1e16, 1e200])
def test_a_density_that_no_selection_comes_near_is_no_obstacle(solver, density):
    costs, _ = costs_of(40, 0)
    settings = SolverSettings(solver)
    mask, certificate = select_one(
        costs, 9, DensityGoal(density), rng=np.random.default_rng(0), settings=settings
    )
    rows = np.argsort(costs)[:9] if density < 1 else np.argsort(costs)[-9:]
    assert np.array_equal(np.flatnonzero(mask), np.sort(rows))
    assert (certificate.proof, certificate.status) == ("sorting", "optimal")


def test_certificate_names_a_bound_above_the_objective_never():
    costs, _ = costs_of(10, 0)
    certificate = certify(costs, np.arange(10) < 4, DensityGoal(1.0, 2.5), "optimal", {"solver": 99.0})
    assert certificate.bound <= certificate.objective


@given(n_points=st.integers(1, 60), seed=st.integers(0, 9999), data=st.data())
def test_start_has_the_right_count_and_exchanges_never_worsen(n_points, seed, data):
    n_keep = data.draw(st.integers(1, n_points))
    costs, _ = costs_of(n_points, seed)
    target = data.draw(st.floats(0.1, 3))
    mask = starting_mask(costs, n_keep, target, np.random.default_rng(seed))
    better = exchange(costs, mask, target)
    assert mask.sum() == better.sum() == n_keep
    assert abs(costs[better].mean() - target) <= abs(costs[mask].mean() - target)
    lowest = np.sort(costs)[:n_keep].mean()
    if target <= lowest:
        assert costs[mask].mean() == pytest.approx(lowest)


def test_point_on_the_centroid_has_a_finite_cost():
    points = np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
    costs, mean_cost = inverse_distance_costs(points, np.zeros(3))
    assert np.isfinite(costs).all()
    assert np.isfinite(mean_cost)
    assert costs.mean() == pytest.approx(1)
    assert costs.argmax() == 0


def test_equal_points_cost_the_same():
    costs, mean_cost = inverse_distance_costs(np.ones((4, 3)), np.ones(3))
    assert costs.tolist() == [1, 1, 1, 1]
    assert mean_cost == 1


def test_printed_density_is_the_reciprocal_of_the_sum_in_model_units():
    points = np.random.default_rng(0).normal(size=(50, 3))
    costs, mean_cost = inverse_distance_costs(points, np.zeros(3))
    distances = np.linalg.norm(points, axis=1)
    printed = cluster_density(costs, mean_cost, "printed") * mean_cost
    assert printed == pytest.approx(1 / np.sum(1 / distances))
    assert cluster_density(costs, mean_cost, "mean") * mean_cost == pytest.approx(np.mean(1 / distances))


@given(sizes=st.lists(st.integers(0, 1000), min_size=1, max_size=30), share=st.floats(0, 1))
def test_budget_sums_to_the_target_and_fits_every_cluster(sizes, share):
    sizes = np.array(sizes)
    total = int(share * sizes.sum())
    budget = allocate_budget(total, sizes)
    assert budget.sum() == total
    assert (budget >= 0).all()
    assert (budget <= sizes).all()
    exact = total * sizes / max(sizes.sum(), 1)
    assert (np.abs(budget - exact) < 1 + 1e-9).all()


@given(
    budget=st.integers(0, 100),
    extra=st.integers(0, 100),
    share=st.floats(0, 1),
    n_features=st.integers(0, 200),
)
def test_features_take_at_most_their_share(budget, extra, share, n_features):
    n_features = min(n_features, budget + extra)
    features, chosen = (int(v[0]) for v in split_budget(np.array([budget]), np.array([n_features]), share))
    assert features + chosen == budget
    assert 0 <= features <= min(n_features, share * budget + 1e-6)
    assert chosen <= budget + extra - features


@pytest.mark.parametrize(
    ("n_points", "reduction", "count"),
    [(35947, 0.7, 10784), (35947, 0.8, 7189), (35947, 0.9, 3594), (10, 0.9, 1), (3, 0.99, 1), (7, 0.0, 7)],
)
def test_target_counts_are_those_of_the_paper(n_points, reduction, count):
    assert target_from_reduction(n_points, reduction) == count


@settings(max_examples=25)
@given(seed=st.integers(0, 9999))
def test_equal_costs_are_no_obstacle(seed):
    costs = np.random.default_rng(seed).integers(1, 3, size=12).astype(float)
    goal = DensityGoal(float(costs.mean()))
    _, certificate = select_one(costs, 5, goal, rng=np.random.default_rng(seed))
    assert certificate.objective <= brute_force(costs, 5, goal) + TOLERANCE * goal.density
