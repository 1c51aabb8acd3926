"""The sentences follow the numbers."""

from frames import record, table_of

from lpcompare.report.findings import summarize


def cell(method, error, runtime=1.0, reduction=0.9, model="bunny", spread=0.0, **known):
    """The records of one cell; two repeats where the error spreads."""
    known = {"n_output": 10, "runtime_s": runtime, "metrics": known.pop("extra", None), **known}
    errors = [error - spread, error + spread] if spread else [error]
    return [record(method, reduction, i, error=e, model=model, **known) for i, e in enumerate(errors)]


def table(groups):
    return table_of(*(row for group in groups for row in group))


def told(groups):
    return " ".join(summarize(table(groups)))


def test_one_winner_everywhere_with_its_lead():
    text = told(
        [cell("a", 1, reduction=r) for r in (0.7, 0.8, 0.9)]
        + [cell("b", 2, reduction=r) for r in (0.7, 0.8, 0.9)]
    )
    assert (
        "a has the lowest plane error at all three reductions, 1.00 % of the diagonal; "
        "b has 2.00 times as much." in text
    )


def test_a_lead_too_small_for_three_digits_is_called_as_much():
    assert "; b has as much, to three digits." in told([cell("a", 1), cell("b", 1.001)])
    assert "; b has 1.00 to 2.00 times as much." in told(
        [cell("a", 1, reduction=0.8), cell("b", 1.001, reduction=0.8), cell("a", 1), cell("b", 2)]
    )


def test_a_single_method_is_not_called_the_lowest():
    text = told([cell("a", 1, reduction=0.8), cell("a", 2)])
    assert "a has a plane error of 1.00 to 2.00 % of the diagonal." in text
    assert "lowest" not in text


def test_winners_that_change_are_named_with_their_reductions():
    text = told([cell("a", 1, reduction=0.7), cell("b", 2, reduction=0.7), cell("a", 3), cell("b", 2)])
    assert "a has the lowest plane error at 70 %, 1.00 % of the diagonal; b has 2.00 times as much" in text
    assert "; at 90 % it is that of b." in text


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
    tie = {"hausdorff_pct": 0.0}
    assert "other measure" not in told([cell("b", 2, extra=tie), cell("a", 1, extra=tie)])


def test_another_measure_with_another_winner_is_named():
    other = "hausdorff_pct"
    text = told([
        cell("a", 1, extra={other: 9.0}),
        cell("b", 2, extra={other: 3.0}),
    ])  # fmt: skip
    assert 'By one other measure, "Hausdorff distance, the larger of both ways", b is first.' in text


def test_other_measures_are_counted_and_who_is_first_most_often_is_named():
    keys = ["hausdorff_pct", "mean_distance_pct", "d1_mse", "d2_mse"]
    rows = [cell("a", 1, extra=dict.fromkeys(keys, 5.0))]
    rows += [cell("b", 2, extra=dict.fromkeys(keys[:3], 1.0) | {keys[3]: 9.0})]
    rows += [cell("c", 3, extra=dict.fromkeys(keys[:3], 9.0) | {keys[3]: 1.0})]
    assert "By 4 of 4 other measures another method is first, most often b." in told(rows)


def test_methods_that_share_the_lead_of_a_measure_are_not_told_as_one_winner():
    other = "hausdorff_backward_pct"
    best = cell("a", 1, extra={other: 1.0})
    pair = told([best, *(cell(m, 2, extra={other: 0.0}) for m in "bc")])
    assert (
        'By one other measure, "Largest distance of a reduced point to the original", b and c are first.'
        in pair
    )


def test_counts_that_were_missed_are_named():
    text = told([cell("a", 1), cell("b", 2, n_output=12)])
    assert "Not at equal counts: b (up to 20 % more)." in text


def test_troubles_are_counted_by_kind():
    statuses = ("failed", "timeout", "skipped")
    bad = [[record(s, repeat=i, status=s, model="bunny") for i in range(2)] for s in statuses]
    text = told([cell("a", 1), *bad])
    assert "Two cases failed: failed." in text
    assert "Two cases ran out of time: timeout." in text
    assert "Two cases did not apply or could not run: skipped." in text


def test_nothing_and_nothing_but_failures():
    assert summarize(table_of()) == ["The run holds no case: nothing was compared."]
    (sentence,) = summarize(table_of(record(status="failed")))
    assert sentence.endswith("One case failed: f. No case ended with a result.")


def test_ten_models_with_one_constant_winner_are_significant():
    cells = [
        cell(m, e, model=f"m{i}") for i in range(10) for m, e in (("a", 1 + i), ("b", 2 + i), ("c", 3 + i))
    ]
    text = told(cells)
    assert "a has the lowest plane error in all 10 pairs of model and reduction" in text
    assert "Over ten models, the mean rank of a is the best and significantly better" in text
    assert "than that of 1 of the 2 others (5 %)." in text


def test_perturbed_inputs_are_no_more_models_and_decide_nothing():
    clean = [cell("a", 1), cell("b", 2)]
    noise = {"perturbation": "noise", "perturbation_level": 1.0}
    perturbed = [cell(m, e, **noise) for m, e in (("a", 9), ("b", 3))]
    text = told(clean + perturbed)
    assert "Two methods on bunny (100 points)" in text
    assert "four cases, all with a result; those of one perturbed input are not in what follows." in text
    assert "a has the lowest plane error at 90 %, 1.00 % of the diagonal" in text
    assert text.split(". ", 1)[1] == told(clean).split(". ", 1)[1]
    assert "perturbed input" not in told(perturbed), "there is nothing else to speak of"


def test_there_are_at_most_four_findings_however_much_there_is_to_say():
    metrics = {"a": 9.0, "b": 1.0, "c": 5.0, "d": 7.0}
    groups = [
        cell(m, e * (1 + i), r, reduction=0.8, model=f"m{i}", extra={"hausdorff_pct": metrics[m]}, **known)
        for i in range(12)
        for m, e, r, known in (
            ("a", 1, 9.0, {"needs_mesh": True, "subset": False}),
            ("b", 2, 1.0, {"needs_mesh": False, "subset": True}),
            ("c", 3, 2.0, {"needs_mesh": False, "subset": True}),
            ("d", 4, 3.0, {"needs_mesh": False, "subset": True, "n_output": 13}),
        )
    ]
    lead, *findings = summarize(table([*groups, [record("e", status="failed", model="m0", reduction=0.8)]]))
    assert "Not at equal counts: d" in lead
    assert "One case failed: e." in lead
    assert len(findings) == 4
    assert max(len(text) for text in findings) < 300
