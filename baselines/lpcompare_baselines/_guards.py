"""What is checked before a rival sees a cloud."""

from __future__ import annotations

import numpy as np

from lpcompare.errors import NotApplicable
from lpcompare.types import Points
from lpcompare_baselines._cells import grid_cells, n_occupied


def check_distinct(points: Points, target_count: int) -> None:
    """Decline a count that a method which drops duplicates cannot return; raises NotApplicable."""
    n_distinct = len(np.unique(points, axis=0))
    if target_count > n_distinct:
        raise NotApplicable(
            f"{target_count} points are asked for, but only {n_distinct} of the {len(points)} are distinct; "
            "ask for fewer."
        )


def check_resolved(points: Points, target_count: int, finest: float) -> None:
    """Decline a count that would need a size below the finest: one far outlier makes every size coarse.

    Raises
    ------
    NotApplicable
        Fewer cells of the finest size hold points than are asked for.
    """
    n_cells = n_occupied(grid_cells(points, finest)) if finest > 0 else 1
    if target_count > n_cells:
        raise NotApplicable(
            f"{target_count} points are asked for, but at {finest:.3g}, the finest size for a cloud this "
            f"wide, only {n_cells} of the {len(points)} are apart; remove far outliers or ask for fewer."
        )
