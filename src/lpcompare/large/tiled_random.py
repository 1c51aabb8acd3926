"""`random_sample` of files: the rows with the smallest of the numbers that the seed gives to rows."""

from __future__ import annotations

import numpy as np

from lpcompare.tiles.job import Job
from lpcompare.tiles.tiles import Run, block_tasks, uniform, valid_points

_STEPS = 53
"""Bits of a number."""


def stages(job: Job, run: Run) -> None:
    """Sort the rows of every block by their numbers, find the number up to which all are kept, keep."""
    run("sorting", block_tasks(job, draw, "drawn"))
    numbers = [job.map_array("numbers", block.number) for block in job.blocks]
    low, high = 0, 2**_STEPS
    while low < high:
        middle = (low + high) // 2
        found = sum(int(np.searchsorted(part, middle * 2.0**-_STEPS, "right")) for part in numbers)
        low, high = (low, middle) if found >= job.target_count else (middle + 1, high)
    job.save("threshold", number=low * 2.0**-_STEPS)
    run("selection", block_tasks(job, keep, "chosen"))


def draw(job: Job, number: int) -> None:
    """The rows of a block in the order of their numbers."""
    _, rows = valid_points(job, job.blocks[number])
    numbers = uniform(rows, job.seed + 1)
    order = np.argsort(numbers, kind="stable")
    job.save_array("numbers", number, numbers[order])
    job.save_array("row_order", number, rows[order])
    job.save("drawn", number, count=len(rows))


def keep(job: Job, number: int) -> None:
    """Keep the rows up to the threshold."""
    count = np.searchsorted(job.map_array("numbers", number), job.load("threshold")["number"], "right")
    job.save_array("kept", number, np.sort(job.map_array("row_order", number)[:count]))
    job.save("chosen", number, count=count)
