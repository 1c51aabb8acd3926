"""The sentences follow the numbers."""

from lpcompare.report.cells import Cell, Interval
from lpcompare.report.findings import summarize


def cell(method, error, runtime=1.0, reduction=0.9, model="bunny", spread=0.0, **known):
    values = {
        "plane_error_pct": Interval(error, error - spread, error + spread, 2),
        "runtime_s": Interval.of([runtime]),
        "n_output": Interval.of([known.pop("n_output", 10)]),
        **known.pop("extra", {}),
    }
    return Cell(model, method, reduction, 100, 10, {"ok": 1}, values=values, **known)


def told(cells):
    return " ".join(summarize(cells))


def test_one_winner_everywhere_with_its_lead():
    text = told(
        [cell("a", 1, reduction=r) for r in (0.7, 0.8, 0.9)]
        + [cell("b", 2, reduction=r) for r in (0.7, 0.8, 0.9)]
    )
    assert (
        "a has the lowest error (eq. 27) at all three reductions, 1.00 % of the diagonal; "
        "b has 2.00 times as much." in text
    )


def test_a_lead_too_small_for_three_digits_is_called_as_much():
    assert "; b has as much, to three digits." in told([cell("a", 1), cell("b", 1.001)])
    assert "; b has 1.00 to 2.00 times as much." in told(
        [cell("a", 1, reduction=0.8), cell("b", 1.001, reduction=0.8), cell("a", 1), cell("b", 2)]
    )


def test_a_single_method_is_not_called_the_lowest():
    text = told([cell("a", 1, reduction=0.8), cell("a", 2)])
    assert "a has an error (eq. 27) of 1.00 to 2.00 % of the diagonal." in text
    assert "lowest" not in text


def test_winners_that_change_are_named_with_their_reductions():
    text = told([cell("a", 1, reduction=0.7), cell("b", 2, reduction=0.7), cell("a", 3), cell("b", 2)])
    assert "a has the lowest error (eq. 27) at 70 %" in text
    assert "b has the lowest error (eq. 27) at 90 %" in text


def test_overlapping_repeats_are_not_called_a_difference():
    assert "not told apart" in told([cell("a", 1.0, spread=0.2), cell("b", 1.1, spread=0.2)])
    assert "not told apart" not in told([cell("a", 1.0), cell("b", 1.1)])


def test_the_fastest_and_what_the_best_takes():
    assert "b is the fastest (2.00 ms); a takes 5.00 s." in told([cell("a", 1, 5.0), cell("b", 2, 0.002)])


def test_a_winner_that_was_given_the_mesh_is_not_the_only_one_named():
    text = told([cell("qem", 1, needs_mesh=True), cell("a", 2), cell("b", 3)])
    assert (
        "Of the methods that were given points and no mesh, a has the lowest error at 90 %; "
        "b has 1.50 times as much." in text
    )


def test_a_winner_that_moves_its_points_is_not_the_only_one_named():
    text = told([cell("moved", 1, subset=False), cell("a", 2, subset=True), cell("b", 3, subset=True)])
    assert (
        "Of the methods whose result is a subset of the original points, a has the lowest error at 90 %"
        in text
    )


def test_a_measure_that_ties_its_leader_with_others_does_not_disagree():
    tie = {"hausdorff_pct": Interval.of([0.0])}
    assert "Other measures" not in told([cell("b", 2, extra=tie), cell("a", 1, extra=tie)])


def test_another_measure_with_another_winner_is_named():
    other = "hausdorff_pct"
    text = told([
        cell("a", 1, extra={other: Interval.of([9.0])}),
        cell("b", 2, extra={other: Interval.of([3.0])}),
    ])  # fmt: skip
    assert "Other measures put another method first: b (Hausdorff distance)." in text


def test_no_more_than_four_leaders_of_other_measures_are_named():
    keys = ["hausdorff_pct", "mean_distance_pct", "d1_mse", "d2_mse", "plane_error_max_pct"]
    cells = [cell("best", 1, extra={key: Interval.of([9.0]) for key in keys})]
    for place, method in enumerate("abcde"):
        values = {key: Interval.of([1.0 if keys[place] == key else 5.0]) for key in keys}
        cells.append(cell(method, 2 + place, extra=values))
    (sentence,) = [s for s in summarize(cells) if s.startswith("Other measures")]
    assert "others (two measures)." in sentence
    assert sum(f" {method} (" in sentence for method in "abcde") == 3


def test_measures_that_share_a_beginning_are_named_in_full():
    other = {"density_objective_pct": (9.0, 3.0), "density_objective_max_pct": (9.0, 3.0)}
    a, b = ({key: Interval.of([pair[i]]) for key, pair in other.items()} for i in range(2))
    text = told([cell("a", 1, extra=a), cell("b", 2, extra=b)])
    assert (
        "mean over 20 clusters; " in text or "; Density objective Z (eq. 14), mean over 20 clusters" in text
    )
    assert "Density objective Z (eq. 14), worst cluster" in text


def test_methods_that_share_the_lead_of_a_measure_are_not_told_as_one_winner():
    other = "hausdorff_backward_pct"
    zero, one = {other: Interval.of([0.0])}, {other: Interval.of([1.0])}
    best = cell("a", 1, extra=one)
    pair = told([best, *(cell(m, 2, extra=zero) for m in "bc")])
    many = told([best, *(cell(m, 2, extra=zero) for m in "bcde")])
    assert "first: b and c (Largest distance of a reduced point to the original)." in pair
    assert "first: four methods alike (Largest distance of a reduced point to the original)." in many


def test_counts_that_were_missed_are_named():
    assert "b (up to 20 % more)" in told([cell("a", 1), cell("b", 2, n_output=12)])


def test_troubles_are_counted_by_kind():
    bad = [Cell("m", s, 0.9, 9, 1, {s: 2}, message="x") for s in ("failed", "timeout", "skipped")]
    text = told([cell("a", 1), *bad])
    assert "Two cases failed: failed." in text
    assert "Two cases ran out of time: timeout." in text
    assert "Two cases did not apply or could not run: skipped." in text


def test_nothing_and_nothing_but_failures():
    assert summarize([]) == ["The run holds no case: nothing was compared."]
    assert "No case ended with a result." in summarize([Cell("m", "a", 0.9, 9, 1, {"failed": 1})])


def test_ten_models_with_one_constant_winner_are_significant():
    cells = [
        cell(m, e, model=f"m{i}") for i in range(10) for m, e in (("a", 1 + i), ("b", 2 + i), ("c", 3 + i))
    ]
    text = told(cells)
    assert "a has the lowest error (eq. 27) in all 10 pairs of model and reduction" in text
    assert "Over ten models, a has the best mean rank and is significantly better than c (5 %)." in text


def test_damaged_inputs_are_no_more_models_and_decide_nothing():
    clean = [cell("a", 1), cell("b", 2)]
    damaged = [cell(m, e, model="bunny + noise 1", perturbed=True) for m, e in (("a", 9), ("b", 3))]
    text = told(clean + damaged)
    assert "Two methods on bunny (100 points)" in text
    assert "four cases, all with a result; those of one damaged input are not in what follows." in text
    assert "a has the lowest error (eq. 27) at 90 %, 1.00 % of the diagonal" in text
    assert text.split(". ", 1)[1] == told(clean).split(". ", 1)[1]
    assert "damaged input" not in told(damaged), "there is nothing else to speak of"
