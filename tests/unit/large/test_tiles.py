"""Tiles hold every point once, in input order; shares are exact; colors differ where tiles touch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lpcompare.large.shares import largest_remainder
from lpcompare.large.tiled_voxels import count_occupied
from lpcompare.tiles.colors import coloring, earlier
from lpcompare.tiles.job import Job
from lpcompare.tiles.tasks import Executor, Task
from lpcompare.tiles.tiles import around, cut, distances_to_box, reading, spilling, tile_of, uniform
from lpcompare_baselines._cells import grid_cells, n_occupied


@given(
    arrays(np.float64, st.integers(1, 20), elements=st.floats(0, 10)),
    st.integers(0, 2**31),
    st.integers(0, 100),
)
def test_shares_are_exact_and_within_their_limits(weights, seed, total):
    most = np.random.default_rng(seed).integers(0, 30, len(weights))
    total = min(total, int(most.sum()))
    shares = largest_remainder(total, weights, most)
    assert shares.sum() == total
    assert (shares >= 0).all()
    assert (shares <= most).all()


def test_shares_without_limits_are_those_of_the_weights():
    np.testing.assert_array_equal(
        largest_remainder(100, np.array([1.0, 2.0, 5.0]), np.full(3, 100)), [13, 25, 62]
    )


@given(st.integers(1, 12), st.integers(0, 2**31))
def test_touching_tiles_never_have_one_color(n, seed):
    touching = np.random.default_rng(seed).random((n, n)) < 0.4
    touching = np.triu(touching, 1) | np.triu(touching, 1).T
    others = [np.flatnonzero(row) for row in touching]
    colors = coloring(others)
    assert not (touching & (colors[:, None] == colors)).any()
    pairs = {(t, o) for t, before in enumerate(earlier(others, colors)) for o in before}
    assert len(pairs) == touching.sum() // 2  # of every two that touch, one comes first


def test_a_cut_shares_the_points_and_leaves_are_numbered(sheet):
    for n in (1, 2, 7, 16):
        tiles = tile_of(sheet, cut(sheet, n))
        counts = np.bincount(tiles, minlength=n)
        assert len(counts) == n
        assert counts.min() > 0.8 * len(sheet) / n


def test_numbers_of_rows_are_even_and_follow_the_seed():
    rows = np.arange(100_000)
    numbers = uniform(rows, 3)
    assert 0 <= numbers.min() < numbers.max() < 1
    assert len(np.unique(numbers)) == len(rows)
    assert np.abs(np.histogram(numbers, 20, (0, 1))[0] - 5000).max() < 5 * np.sqrt(5000)
    assert abs(np.corrcoef(numbers, uniform(rows, 4))[0, 1]) < 0.02
    assert abs(np.corrcoef(numbers[1:], numbers[:-1])[0, 1]) < 0.02


def spilled(folder, path, count, **options):
    job = Job(folder, ((path, count),), 10, "random_sample", n_tiles=5, **options)
    executor = Executor()
    for step in (reading, spilling):
        step(job, lambda stage, tasks: executor.run(stage, job, tasks))
    return job


def test_every_point_is_in_one_tile_whatever_the_blocks(files, sheet, tmp_path):
    jobs = [spilled(tmp_path / str(n), files[".npy"], 6000, block_rows=n) for n in (1700, 6000)]
    for tile in range(5):
        rows = [np.asarray(job.map_array("rows", tile)) for job in jobs]
        np.testing.assert_array_equal(*rows)
        assert (np.diff(rows[0]) > 0).all()
        np.testing.assert_array_equal(jobs[0].map_array("points", tile), sheet[rows[0]])
    every = np.concatenate([jobs[0].map_array("rows", tile) for tile in range(5)])
    np.testing.assert_array_equal(np.sort(every), np.arange(6000))
    assert not list((tmp_path / "1700" / "block_points").iterdir())


def test_what_is_around_a_tile_is_all_within_reach(files, sheet, tmp_path):
    job = spilled(tmp_path, files[".npy"], 6000)
    box = {edge: job.load("boxes")[edge][2] for edge in ("low", "high")}
    near = around(job, 2, 0.7)
    rows = np.concatenate([job.map_array("rows", t)[near.places[near.tiles == t]] for t in range(5)])
    own = np.asarray(job.map_array("rows", 2))
    wanted = np.setdiff1d(np.flatnonzero(distances_to_box(sheet, box["low"], box["high"]) <= 0.7), own)
    np.testing.assert_array_equal(np.sort(rows), wanted)


def test_points_without_coordinates_are_in_no_tile(tmp_path):
    points = np.random.default_rng(0).random((100, 3))
    points[::10, 1] = np.nan
    np.save(tmp_path / "gaps.npy", points)
    job = spilled(tmp_path / "spill", tmp_path / "gaps.npy", 100)
    every = np.concatenate([job.map_array("rows", tile) for tile in range(5)])
    assert len(every) == 90 == job.load("whole")["count"]
    assert not (every % 10 == 0).any()


def leave(job, number):
    job.save_array("left", number, np.array([len(list((job.folder / "left").glob("*")))]))


def test_tasks_wait_for_those_before_them_and_are_not_repeated(tmp_path):
    job = Job(tmp_path, (), 1, "random_sample")
    (tmp_path / "left").mkdir()
    outputs = [job.path("left", n, ".npy") for n in range(4)]
    tasks = [Task(leave, n, outputs[n], tuple(outputs[n + 1 : n + 2])) for n in range(4)]
    executor = Executor()
    executor.run("some", job, tasks[3:])
    executor.run("all", job, tasks)
    assert executor.n_run == {"some": 1, "all": 3}
    assert [int(job.map_array("left", n)[0]) for n in (3, 2, 1, 0)] == sorted(
        int(job.map_array("left", n)[0]) for n in range(4)
    )


@pytest.mark.parametrize("n_tiles", [1, 2, 7, 40])
@pytest.mark.parametrize("edge", [0.05, 0.7, 6.0, 100.0])
def test_cubes_counted_in_tiles_are_those_of_the_whole(sheet, files, tmp_path, n_tiles, edge):
    job = Job(tmp_path, ((files[".npy"], len(sheet)),), 100, "voxel_nearest", n_tiles=n_tiles)
    executor = Executor(None)

    def run(stage, tasks):
        executor.run(stage, job, tasks)

    reading(job, run)
    spilling(job, run)
    assert count_occupied(job, run, edge) == n_occupied(grid_cells(sheet, edge))
