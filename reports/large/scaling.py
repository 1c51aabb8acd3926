"""How long `lp_uniform` would take on more points and workers: a simulation of the graph of its tasks.

    python reports/large/scaling.py

Writes scaling.csv. The seconds of a task are those of tasks.csv, CPU microseconds a point and stage, measured on one
machine; the rest is assumed and named below. Nothing here was run on a cluster.
"""

import heapq
import math
from pathlib import Path

import pandas as pd

HERE = Path(__file__).parent
TILE = 1_000_000
SCHEDULER_S = 1e-3
"""Dask's scheduler, per task (assumed)."""
FILE_S = 2e-4
"""The first process, per file that it reads between two stages (assumed)."""
STORAGE_BYTES_S = 5e9
"""Shared storage, all workers together (assumed)."""
BYTES = {
    "reading": 10,
    "spilling": 42,
    "sorting": 64,
    "curvature": 66,
    "cells": 140,
    "swaps": 140,
    "selection": 140,
}
"""Read and written per point; a halo's points are counted as often as they are read (from the code)."""
SEQUENTIAL = ("writing",)


def makespan(n_tasks, seconds, workers, color, before):
    """End of the last of equal tasks, each after those that it waits for, on so many workers."""
    free, done = [0.0] * min(workers, n_tasks), {}
    for task in sorted(range(n_tasks), key=color):
        ready = max((done[t] for t in before(task)), default=0.0)
        start = max(heapq.heappop(free), ready)
        done[task] = start + seconds
        heapq.heappush(free, done[task])
    return max(done.values())


def turns(n_tasks):
    """Colors of the tiles of a square grid, four of them, and the tiles that each one waits for."""
    side = math.isqrt(n_tasks - 1) + 1

    def color(task):
        row, column = divmod(task, side)
        return row % 2 * 2 + column % 2

    def before(task):
        row, column = divmod(task, side)
        around = [(row + i, column + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        inside = [r * side + c for r, c in around if r >= 0 and 0 <= c < side and r * side + c < n_tasks]
        return [t for t in inside if color(t) < color(task)]

    return color, before


def simulate(n_points, workers, costs):
    """Seconds of every stage."""
    n_tiles = math.ceil(n_points / TILE)
    stages = {}
    for stage, microseconds in costs.items():
        seconds = microseconds * 1e-6 * n_points / n_tiles
        if stage in SEQUENTIAL:
            stages[stage] = seconds * n_tiles
            continue
        in_turns = turns(n_tiles) if stage == "swaps" else (lambda _: 0, lambda _: [])
        work = makespan(n_tiles, seconds, workers, *in_turns)
        moved = BYTES.get(stage, 50) * n_points / STORAGE_BYTES_S
        stages[stage] = max(work, moved, n_tiles * SCHEDULER_S) + n_tiles * FILE_S
    return stages


def main():
    """Simulate and write the table."""
    costs = pd.read_csv(HERE / "tasks.csv").set_index("stage")["microseconds"].to_dict()
    rows = []
    for n_points in (10**8, 10**9, 10**10, 10**11):
        for workers in (1, 10, 100, 1000):
            stages = simulate(n_points, workers, costs)
            total = sum(stages.values())
            most = max(stages, key=stages.get)
            rows.append(
                {"points": n_points, "workers": workers, "hours": total / 3600, "longest": most}
                | {"share_of_longest": stages[most] / total, "writing_hours": stages["writing"] / 3600}
            )
    table = pd.DataFrame(rows)
    table["speed_up"] = table.groupby("points")["hours"].transform("first") / table["hours"]
    table.to_csv(HERE / "scaling.csv", index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
