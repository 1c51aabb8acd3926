"""Holes on a square grid: none, one in the middle, one at the rim."""

import numpy as np
import pytest
from reports.paper.holes import describe_holes

SIDE = 41
GRID = np.stack(
    [*np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(-1, 1, SIDE)), np.zeros((SIDE, SIDE))], -1
)
POINTS = GRID.reshape(-1, 3)
LABELS = np.zeros(len(POINTS), dtype=np.intp)
RADIUS = np.abs(POINTS[:, :2]).max(axis=1)


def test_the_whole_cloud_has_no_gap():
    values = describe_holes(POINTS, POINTS, LABELS)
    assert values["gap_max_pct"] == 0
    assert values["wide_gap_pct"] == 0


def test_a_hole_in_the_middle_is_central_and_has_its_size():
    values = describe_holes(POINTS, POINTS[RADIUS > 0.501], LABELS)
    assert values["central_pct"] == 100
    assert values["gap_max_pct"] == pytest.approx(100 * 0.55 / np.sqrt(8), rel=1e-6)
    assert values["wide_gap_pct"] > 5


def test_a_hole_at_the_rim_is_not_central():
    assert describe_holes(POINTS, POINTS[RADIUS < 0.701], LABELS)["central_pct"] == 0
