"""`simplify_files`: exact counts, subsets, the same bytes whatever the blocks, and what is said of failures."""

import dataclasses
import json
import os
import shutil
import sys

import laspy
import numpy as np
import pytest
from filelock import FileLock

import lpcompare
from lpcompare.errors import InputError
from lpcompare.io import read
from lpcompare.large import simplify_files
from lpcompare.large.simplify_files import TILED
from lpcompare.registry import METHODS
from lpcompare.tiles import job, tasks

EXACT = ("lp_density", "lp_printed", "lp_uniform", "random_sample")


def thin(source, target, **options):
    options = {"target_count": 600, "n_tiles": 4, "method": "lp_density"} | options
    return lpcompare.simplify_files(source, target, **options)


@pytest.fixture
def blocks_of(monkeypatch):
    """Make blocks of so many rows."""

    def change(n):
        monkeypatch.setattr(simplify_files, "Job", lambda **how: job.Job(block_rows=n, **how))

    return change


def test_the_trait_and_the_table_name_the_same_methods():
    assert sorted(TILED) == [name for name in METHODS if METHODS.traits(name).in_tiles]


@pytest.mark.parametrize("method", TILED)
def test_kept_rows_are_rows_of_the_file_in_its_order(files, sheet, tmp_path, method):
    result = thin(files[".npy"], tmp_path / "thin.npy", method=method)
    kept = np.load(tmp_path / "thin.npy")
    rows = np.rint(kept[:, 3] ** 2).astype(int)
    assert (np.diff(rows) > 0).all()
    np.testing.assert_array_equal(kept[:, :3], sheet[rows])
    assert len(kept) == result.n_kept
    assert len(kept) == 600 if method in EXACT else abs(len(kept) - 600) < 60
    assert list(tmp_path.iterdir()) == [tmp_path / "thin.npy"]


@pytest.mark.parametrize("method", TILED)
def test_blocks_and_the_order_of_tasks_change_nothing(files, tmp_path, method, blocks_of, monkeypatch):
    thin(files[".npy"], tmp_path / "a.npy", method=method)
    blocks_of(1300)
    in_order = tasks._ordered
    monkeypatch.setattr(tasks, "_ordered", lambda some: in_order(list(reversed(some))) if some else [])
    thin(files[".npy"], tmp_path / "b.npy", method=method)
    assert (tmp_path / "a.npy").read_bytes() == (tmp_path / "b.npy").read_bytes()


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such limit")
def test_more_blocks_than_files_may_be_open_at_once(files, tmp_path, blocks_of):
    import resource

    blocks_of(25)
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    in_use = os.dup(0)
    os.close(in_use)
    resource.setrlimit(resource.RLIMIT_NOFILE, (in_use + 30, limits[1]))
    try:
        assert thin(files[".npy"], tmp_path / "thin.npy", method="random_sample").n_kept == 600
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)


def test_another_seed_gives_another_sample(files, tmp_path):
    for seed in (0, 1):
        thin(files[".npy"], tmp_path / f"{seed}.npy", method="random_sample", random_state=seed)
    assert (tmp_path / "0.npy").read_bytes() != (tmp_path / "1.npy").read_bytes()


def test_voxels_are_those_of_the_whole_cloud(files, sheet, tmp_path):
    for n_tiles in (1, 5):
        thin(files[".npy"], tmp_path / "thin.npy", method="voxel_nearest", n_tiles=n_tiles)
        rows = np.rint(np.load(tmp_path / "thin.npy")[:, 3] ** 2).astype(int)
        whole = lpcompare.simplify(sheet, target_count=600, method="voxel_nearest")
        np.testing.assert_array_equal(rows, whole.indices)


def test_disks_are_apart_and_none_could_be_added(files, sheet, tmp_path):
    from lpcompare.geometry.neighbors import Neighbors

    radius = thin(files[".npy"], tmp_path / "thin.npy", method="poisson_disk", n_tiles=7).info["radius"]
    kept = np.load(tmp_path / "thin.npy")[:, :3]
    assert Neighbors(kept).query(kept, 2)[0][:, 1].min() >= radius
    assert Neighbors(kept).query(sheet, 1)[0].max() <= radius


def test_densities_of_the_whole_clusters_are_kept(files, tmp_path):
    result = thin(files[".npy"], tmp_path / "thin.npy", method="lp_density", n_clusters=4)
    assert result.info["largest_residual"] < 1e-3
    for tolerance in (0.01, 0.05):
        options = {"method": "lp_uniform", "n_clusters": 4, "density_tolerance": tolerance}
        assert thin(files[".npy"], tmp_path / "thin.npy", **options).info["largest_residual"] <= tolerance


def test_tiles_cost_little_against_the_whole_in_memory(files, sheet, tmp_path):
    result = thin(files[".npy"], tmp_path / "thin.npy", method="lp_uniform", target_count=900)
    kept = np.load(tmp_path / "thin.npy")[:, :3]
    whole = lpcompare.simplify(sheet, target_count=900)
    metrics = ["plane_error", "hausdorff"]
    tiled, known = (lpcompare.evaluate(sheet, r, metrics=metrics) for r in (kept, whole))
    assert result.n_kept == 900
    assert tiled["plane_error_pct"] < 1.1 * known["plane_error_pct"]
    assert tiled["hausdorff_pct"] < 1.2 * known["hausdorff_pct"]


def test_a_survey_of_several_files_is_one_cloud(files, tmp_path):
    parts = []
    las = laspy.read(files[".laz"])
    for i in range(3):
        part = laspy.LasData(las.header, las.points[i::3].copy())
        part.write(str(tmp_path / f"part{i}.laz"))
        parts.append(tmp_path / f"part{i}.laz")
    result = thin(parts, tmp_path / "one.laz")
    one = laspy.read(tmp_path / "one.laz")
    assert len(one) == 600 == result.n_kept
    (tmp_path / "many").mkdir()
    thin(parts, tmp_path / "many")
    many = [laspy.read(tmp_path / "many" / path.name) for path in parts]
    np.testing.assert_array_equal(np.concatenate([m["score"] for m in many]), one["score"])


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".las"])
def test_other_formats_keep_the_same_points(files, tmp_path, suffix):
    thin(files[suffix], tmp_path / f"thin{suffix}")
    np.save(tmp_path / "plain.npy", read(files[suffix]).points)
    thin(tmp_path / "plain.npy", tmp_path / "thin.npy")
    kept = read(tmp_path / f"thin{suffix}").points
    np.testing.assert_allclose(kept, np.load(tmp_path / "thin.npy"), rtol=0, atol=1e-9)


def test_points_without_coordinates_are_left_out_and_said(tmp_path):
    points = np.random.default_rng(0).random((900, 3))
    points[::9] = np.nan
    np.save(tmp_path / "gaps.npy", points)
    result = thin(tmp_path / "gaps.npy", tmp_path / "thin.npy", target_count=100)
    assert np.isfinite(np.load(tmp_path / "thin.npy")).all()
    assert result.notes == ("100 points without coordinates were left out",)
    with pytest.raises(InputError, match="1 to the 800 points"):
        thin(tmp_path / "gaps.npy", tmp_path / "thin.npy", target_count=850)


def test_coinciding_points_are_no_trouble(tmp_path):
    np.save(tmp_path / "one.npy", np.repeat(np.eye(3), 200, axis=0))
    for method in EXACT:
        thin(tmp_path / "one.npy", tmp_path / "thin.npy", target_count=50, method=method)
        assert len(np.load(tmp_path / "thin.npy")) == 50


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "farthest_point"}, "whole cloud at once"),
        ({"method": "quadric_collapse"}, "needs the mesh"),
        ({"density": "printed"}, "only 'mean' can be used"),
        ({"n_neighbors": 0}, "n_neighbors is 0"),
        ({"target_count": 6001}, "from 1 to 6000"),
        ({"memory": 2**20, "n_tiles": None}, "give at least"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_sentence(files, tmp_path, options, words):
    with pytest.raises(InputError, match=words):
        thin(files[".npy"], tmp_path / "thin.npy", **options)
    assert not list(tmp_path.iterdir())


def test_an_input_is_not_replaced_and_formats_are_not_mixed(files, tmp_path):
    with pytest.raises(InputError, match="is an input"):
        thin(files[".npy"], files[".npy"])
    with pytest.raises(InputError, match="not of one format"):
        thin(files[".npy"], tmp_path / "thin.ply")


def interrupted(monkeypatch, error, after):
    """Raise an error when so many tasks are done."""
    done = []

    def run(job, some, before=tasks._here):
        for task in some:
            yield from before(job, [task])
            done.append(task)
            if len(done) == after:
                raise error

    monkeypatch.setattr(tasks, "_here", run)


@pytest.mark.parametrize("method", TILED)
@pytest.mark.parametrize("after", [3, 9])
def test_resuming_gives_the_same_bytes(files, tmp_path, method, after):
    thin(files[".npy"], tmp_path / "whole.npy", method=method)
    with pytest.MonkeyPatch.context() as patch:
        interrupted(patch, KeyboardInterrupt(), after)
        try:
            thin(files[".npy"], tmp_path / "thin.npy", method=method)
        except KeyboardInterrupt as error:
            assert f"{tmp_path / '.thin.npy.spill'}; continue with --resume" in str(error)
    assert not (tmp_path / "thin.npy").exists() or after == 9
    thin(files[".npy"], tmp_path / "thin.npy", method=method, resume=True)
    assert (tmp_path / "whole.npy").read_bytes() == (tmp_path / "thin.npy").read_bytes()
    assert not (tmp_path / ".thin.npy.spill").exists()


def test_a_spill_folder_of_another_order_is_not_continued(files, tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        interrupted(patch, KeyboardInterrupt(), 3)
        with pytest.raises(KeyboardInterrupt):
            thin(files[".npy"], tmp_path / "thin.npy")
    with pytest.raises(InputError, match="other inputs or settings"):
        thin(files[".npy"], tmp_path / "thin.npy", resume=True, target_count=500)
    assert json.loads((tmp_path / ".thin.npy.spill" / "job.json").read_text())["method"][2] == 600


def stop(work, error):
    """End some work after two tasks; SystemExit passes everything by, as SIGKILL does."""
    with pytest.MonkeyPatch.context() as patch:
        interrupted(patch, error, 2)
        with pytest.raises(type(error)):
            work()


def test_what_a_killed_process_leaves_is_no_obstacle(files, tmp_path):
    def reduce():
        return thin(files[".npy"], tmp_path / "thin.npy", method="random_sample")

    def evaluate():
        return lpcompare.evaluate_files(files[".npy"], tmp_path / "thin.npy", n_tiles=4)

    stop(reduce, SystemExit())
    reduce()
    stop(evaluate, SystemExit())
    assert evaluate()["plane_error_pct"] > 0
    assert [path.name for path in tmp_path.iterdir()] == ["thin.npy"]


def test_an_evaluation_leaves_the_tiles_of_an_interrupted_thinning(files, tmp_path):
    np.save(tmp_path / "thin.npy", np.eye(3))
    stop(lambda: thin(files[".npy"], tmp_path / "thin.npy", method="random_sample"), KeyboardInterrupt())
    lpcompare.evaluate_files(files[".npy"], tmp_path / "thin.npy")
    assert (tmp_path / ".thin.npy.spill" / "job.json").exists()


def test_an_input_that_changes_meanwhile_is_refused(files, tmp_path):
    shutil.copy(files[".npy"], tmp_path / "scan.npy")

    def grow(stage, *_):
        if stage == "writing":
            with (tmp_path / "scan.npy").open("ab") as file:
                file.write(b"more")

    with pytest.raises(InputError, match="changed while it was read"):
        thin(tmp_path / "scan.npy", tmp_path / "thin.npy", method="random_sample", callback=grow)
    assert not (tmp_path / "thin.npy").exists()


def test_two_processes_do_not_work_in_one_spill_folder(files, tmp_path):
    (tmp_path / ".thin.npy.spill").mkdir()
    with (
        FileLock(tmp_path / ".thin.npy.spill" / "spill.lock"),
        pytest.raises(InputError, match="Another lpcompare works in"),
    ):
        thin(files[".npy"], tmp_path / "thin.npy", method="random_sample")


def test_a_full_disk_is_one_sentence_and_keeps_the_tiles(files, tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        interrupted(patch, OSError(28, "No space left on device"), 4)
        with pytest.raises(InputError, match=r"No space left on device.*continue with --resume"):
            thin(files[".npy"], tmp_path / "thin.npy")
    assert (tmp_path / ".thin.npy.spill").is_dir()
    assert thin(files[".npy"], tmp_path / "thin.npy", resume=True).n_kept == 600


def test_a_disk_that_is_too_small_is_foreseen(files, tmp_path, monkeypatch):
    full = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: full)
    with pytest.raises(InputError, match="needs about 0 MiB for the tiles and has 0 MiB"):
        thin(files[".npy"], tmp_path / "thin.npy")


def test_a_folder_that_is_no_spill_folder_is_left_alone(files, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="not empty and no spill folder"):
        thin(files[".npy"], tmp_path / "thin.npy", spill=tmp_path / "mine")
    assert (tmp_path / "mine" / "letter.txt").exists()


def test_jobs_are_frozen(tmp_path):
    with pytest.raises(dataclasses.FrozenInstanceError):
        job.Job(tmp_path, (), 1, "random_sample").seed = 3


@pytest.mark.parametrize("name", ["n_tiles", "memory"])
@pytest.mark.parametrize("value", [0, -1, 2.5])
def test_numbers_that_count_nothing_are_refused(files, tmp_path, name, value):
    with pytest.raises(InputError, match=name):
        thin(files[".npy"], tmp_path / "thin.npy", **{name: value})
    assert not (tmp_path / "thin.npy").exists()


@pytest.mark.parametrize("letter", ["e", "ü"])
def test_the_longest_name_of_a_file_has_a_place_for_its_tiles(files, tmp_path, letter):
    name = letter * (251 // len(letter.encode())) + ".npy"
    thin(files[".npy"], tmp_path / name, method="random_sample", n_tiles=3)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert lpcompare.evaluate_files(files[".npy"], tmp_path / name)["plane_error_pct"] > 0
    assert [path.name for path in tmp_path.iterdir()] == [name]
