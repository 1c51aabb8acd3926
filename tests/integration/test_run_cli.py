"""``lpcompare run`` and ``list`` as their users meet them: tables, files, sentences for tracebacks."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest

from lpcompare.benchmark.record import load_run
from lpcompare.cli.run import _plan

QUICK = ["--method", "random_sample", "--method", "well_behaved", "--reduction", "0.8"]


@pytest.fixture(scope="module")
def finished(lpcompare, cloud_file, tmp_path_factory):
    out = tmp_path_factory.mktemp("quick") / "run"
    done = lpcompare("run", "--model", cloud_file, *QUICK, "--repeats", 2, "--out", out)
    assert done.returncode == 0, done.stderr
    return done, load_run(out)


def test_a_row_per_case_and_repeat_with_the_columns_that_were_promised(finished):
    _, run = finished
    with (run.folder / "records.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(run.records) == 4
    wanted = (
        "model method reduction target_count n_output status message seed repeat runtime_s "
        "plane_error_pct plane_error_max_pct plane_error"
    )
    assert set(wanted.split()) <= rows[0].keys()
    assert {row["n_output"] for row in rows} == {"100"}


def test_records_carry_what_a_reviewer_asks_for(finished):
    _, run = finished
    record = next(r for r in run.records if r.method == "well_behaved")
    assert record.status == "ok"
    assert record.runtime_s > 0
    assert record.cpu_s >= 0
    assert record.reference_s > 0
    assert 20 < record.peak_memory_mib < 2000
    assert record.timings == {"draw": 0.0}
    assert record.info == {"drawn": 100}
    assert run.environment["packages"]["numpy"] == np.__version__
    assert run.environment["threads"]["OMP_NUM_THREADS"] == str(run.plan["threads"])
    assert all(
        name in run.environment
        for name in ("cpu", "cores", "memory_mib", "os", "python", "command", "commit")
    )
    assert run.inputs["ball"]["n_points"] == 500
    assert len(run.inputs["ball"]["sha256"]) == 64


def test_result_clouds_are_kept_with_their_errors(finished):
    _, run = finished
    original = np.load(run.folder / run.inputs["ball"]["file"])["points"]
    kept = [r for r in run.records if r.cloud]
    assert {r.repeat for r in kept} == {0}
    for record in kept:
        result = np.load(run.folder / record.cloud)
        assert np.array_equal(result["points"], original[result["indices"]])
        assert result["plane_errors"].dtype == np.float32
        mean = 100 * result["plane_errors"].mean() / np.linalg.norm(np.ptp(original, axis=0))
        assert mean == pytest.approx(record.metrics["plane_error_pct"], rel=1e-5)


def test_repeats_draw_different_points_and_a_second_run_the_same_ones(
    finished, lpcompare, cloud_file, tmp_path
):
    _, run = finished
    digests = [r.points_sha256 for r in run.records]
    assert len(set(digests)) == 4
    lpcompare("run", "--model", cloud_file, *QUICK, "--repeats", 2, "--out", tmp_path / "run", "--threads", 1)
    assert [r.points_sha256 for r in load_run(tmp_path / "run").records] == digests


def test_the_table_fits_and_progress_is_silent_without_a_terminal(finished):
    done, _ = finished
    assert done.stderr == ""
    assert "ball: 80 % removed, 100 of 500 points asked" in done.stdout
    assert max(map(len, done.stdout.splitlines()[:-1])) <= 100


def test_a_comparison_of_a_run_with_itself_finds_nothing(finished, lpcompare):
    folder = finished[1].folder
    done = lpcompare("compare", folder, folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("identical") >= 2
    assert "slower" not in done.stdout


@pytest.fixture
def broken_files(tmp_path):
    lines = ["ply", "format ascii 1.0", "element vertex 3", *(f"property float {axis}" for axis in "xyz")]
    (tmp_path / "empty.ply").write_bytes(b"")
    (tmp_path / "truncated.ply").write_text("\n".join([*lines, "end_header", "0 0 0", "1 0"]))
    np.save(tmp_path / "nan.npy", np.array([[0.0, 0, 0], [np.nan, 1, 1]]))
    np.save(tmp_path / "all-nan.npy", np.full((3, 3), np.nan))
    np.save(tmp_path / "flat.npy", np.zeros((4, 2)))
    (tmp_path / "file").write_text("")
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        ["--model", "nosuch"],
        ["--model", "sphere", "--method", "nosuch"],
        ["--model", "sphere", "--metric", "nosuch"],
        ["--model", "sphere", "--study", "nosuch"],
        ["--model", "sphere", "--set", "lp_density.nosuch=3"],
        ["--model", "sphere", "--set", "lp_density.n_clusters=many"],
        ["--model", "sphere", "--reduction", "1.5"],
        ["--model", "sphere", "--reduction", "nan"],
        ["--model", "sphere", "--repeats", "0"],
        ["--model", "sphere", "--repeats", "10000000"],
        ["--model", "sphere", "--seed", "99999999999999999999999"],
        ["--model", "sphere", "--time-limit", "inf"],
        ["--model", "sphere", "--time-limit", "nan"],
        ["--model", "sphere", "--time-limit", "-1"],
        ["--model", "sphere", "--memory-limit", "1"],
        ["--model", "sphere", "--jobs", "0"],
        ["--model", "sphere", "--threads", "0"],
        ["--model", "sphere", "--set", "lp_uniform.nosuch=3"],
        ["--model", "sphere", "--set", "lp_uniform.random_state=3"],
        ["--model", "sphere", "--protocol", "fair"],
        ["--model", "sphere", "--resume"],
        ["--model", "sphere", "--model", "sphere"],
        ["--model", "empty.ply"],
        ["--model", "truncated.ply"],
        ["--model", "nan.npy", "--strict"],
        ["--model", "all-nan.npy"],
        ["--model", "flat.npy"],
        ["--model", "sphere", "--out", "file/run"],
        [],
    ],
    ids=" ".join,
)
def test_bad_input_is_one_sentence_and_exit_code_2(lpcompare, broken_files, words):
    before = sorted(broken_files.iterdir())
    done = lpcompare("run", *words, cwd=broken_files)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("lpcompare: ")
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert sorted(broken_files.iterdir()) == before, "nothing half-written"


@pytest.mark.parametrize("assignment", ["lp_density.n_clusters=-3", "lp_uniform.time_limit=-1"])
def test_a_setting_that_its_method_refuses_ends_the_run_before_the_first_case(
    lpcompare, cloud_file, tmp_path, assignment
):
    method = assignment.partition(".")[0]
    words = ["--method", "random_sample", "--method", method, "--set", assignment]
    done = lpcompare("run", "--model", cloud_file, *words, "--out", tmp_path / "run")
    assert done.returncode == 2, done.stdout
    assert done.stderr.startswith(f"lpcompare: {assignment.replace('.', ' ')}: ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "run" / "run.json").exists()


def test_a_setting_that_only_the_model_allows_is_run(lpcompare, cloud_file, tmp_path):
    words = ["--method", "lp_density", "--set", "lp_density.n_clusters=300", "--reduction", 0.3]
    done = lpcompare("run", "--model", cloud_file, *words, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    (record,) = load_run(tmp_path / "run").records
    assert record.settings["n_clusters"] == 300


def test_points_without_coordinates_are_left_out_and_counted(lpcompare, tmp_path):
    points = np.random.default_rng(0).random((300, 3))
    points[[3, 70], [0, 2]] = np.nan, np.inf
    np.save(tmp_path / "holes.npy", points)
    done = lpcompare("run", "--model", tmp_path / "holes.npy", *QUICK, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert "2 of 300 points have no finite coordinates and are left out." in done.stderr
    run = load_run(tmp_path / "run")
    assert {r.n_input for r in run.records} == {298}
    assert run.inputs["holes"]["left_out"] == "2 points without coordinates"


@pytest.mark.parametrize(("reductions", "title"), [([], "One ball."), ([0.9], "")])
def test_a_studys_title_stays_until_a_flag_replaces_a_field_of_the_study(tmp_path, reductions, title):
    path = tmp_path / "study.toml"
    path.write_text(
        "title = 'One ball.'\nmodels = ['sphere']\nmethods = ['random_sample']\nreductions = [0.8]"
    )
    assert _plan(str(path), {"methods": [], "reductions": reductions}, [], {}).title == title


def test_a_dry_run_prints_the_plan_and_leaves_nothing(lpcompare, tmp_path, cloud_file):
    done = lpcompare("run", "--model", cloud_file, *QUICK, "--dry-run", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("2 cases, about ")
    assert "seeds 0, 1 repeat, " in done.stdout
    assert "100 (80 % removed) of 500 points" in done.stdout
    assert not list(tmp_path.iterdir())


def test_the_default_folder_is_named_after_time_and_model(lpcompare, tmp_path, cloud_file):
    done = lpcompare("run", "--model", cloud_file, *QUICK, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (folder,) = (tmp_path / "reports" / "local").iterdir()
    assert folder.name.endswith("-ball")
    assert not list(folder.glob(".work")), "scratch files are gone"


def test_a_run_in_which_a_case_is_not_ok_says_so_by_its_exit_code(lpcompare, tmp_path, cloud_file):
    words = ["--method", "well_behaved", "--method", "declines", "--reduction", 0.8]
    done = lpcompare("run", "--model", cloud_file, *words, "--out", tmp_path / "run")
    assert done.returncode == 1
    assert done.stderr == ""
    assert [r.status for r in load_run(tmp_path / "run").records] == ["ok", "skipped"]


@pytest.mark.parametrize("more", [[], ["--jobs", 2, "--refine"]], ids=str)
def test_as_printed_hands_the_count_of_the_papers_method_to_all_others(lpcompare, tmp_path, cloud_file, more):
    words = ["--method", "random_sample", "--method", "lp_printed", "--protocol", "as-printed"]
    words += ["--set", "lp_printed.retention=keep-features", "--set", "lp_printed.n_clusters=3"]
    done = lpcompare(
        "run", "--model", cloud_file, *words, "--reduction", 0.7, "--out", tmp_path / "run", *more
    )
    assert done.returncode == 0, done.stderr
    printed, other = load_run(tmp_path / "run").records
    assert printed.method == "lp_printed"
    assert printed.n_output > printed.target_count == 150
    assert other.target_count == other.n_output == printed.n_output


def test_refined_subsets_carry_the_time_of_the_exchange(lpcompare, tmp_path, cloud_file):
    done = lpcompare("run", "--model", cloud_file, *QUICK, "--refine", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    for record in load_run(tmp_path / "run").records:
        assert record.refined
        assert record.n_output == 100
        assert 0 < record.timings["refine"] <= record.runtime_s


def test_damaged_inputs_are_judged_against_the_clean_cloud(lpcompare, tmp_path, cloud_file):
    study = tmp_path / "study.toml"
    study.write_text(f"models = ['{cloud_file}']\nreductions = [0.8]\n[perturbations]\noutliers = [0.5]\n")
    done = lpcompare("run", "--study", study, "--method", "well_behaved", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    clean, damaged = load_run(tmp_path / "run").records
    assert (clean.n_input, damaged.n_input) == (500, 750)
    assert clean.target_count == damaged.target_count == 100
    assert len(np.load(tmp_path / "run" / damaged.cloud)["plane_errors"]) == 500
    assert damaged.metrics["plane_error_pct"] > clean.metrics["plane_error_pct"]
    assert "ball with outliers" in done.stdout


def test_list_names_everything_in_one_line_each_and_imports_no_rival(plugin_environment):
    code = (
        "import sys; sys.argv = ['lpcompare', 'list']\n"
        "from lpcompare.cli import build_app\n"
        "build_app()(standalone_mode=False)\n"
        "rivals = {'pymeshlab', 'fast_simplification', 'cvxpy', 'highspy', 'open3d', 'naughty.hangs'}\n"
        "print('IMPORTED', sorted(rivals & sys.modules.keys()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=plugin_environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert "IMPORTED []" in done.stdout
    lines = done.stdout.splitlines()
    assert sum(line.startswith(("  ", "\t")) for line in lines) == 0  # a pipe has no width: nothing is broken
    assert any(line.startswith("random_sample ") for line in lines)
    assert any(line.startswith("bunny ") for line in lines)
    assert any(line.startswith("plane_error ") for line in lines)


def test_list_of_one_kind_and_of_an_unknown_kind(lpcompare):
    assert "bunny" not in lpcompare("list", "metrics").stdout
    wrong = lpcompare("list", "colours")
    assert wrong.returncode == 2
    assert wrong.stderr.count("\n") == 1


def test_run_json_is_strict_json(finished):
    def refuse(word):
        raise AssertionError(word)

    json.loads((finished[1].folder / "run.json").read_text(), parse_constant=refuse)
