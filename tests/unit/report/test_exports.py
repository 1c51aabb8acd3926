"""Tables, figures and the MeshLab project say what run.json says."""

import csv
import shutil
from dataclasses import replace
from statistics import median
from xml.etree import ElementTree

import numpy as np
import pytest
from made_runs import dented_sphere

from lpcompare.benchmark.record import load_run
from lpcompare.errors import InputError
from lpcompare.mesh_library import pymeshlab
from lpcompare.report.figures import FORMATS, write_figures
from lpcompare.report.meshlab_project import write_project
from lpcompare.report.tables import (
    NARROW,
    escape_cell,
    escape_latex,
    format_run,
    plain,
    write_csv,
    write_latex,
    write_markdown,
)


def test_csv_has_a_row_per_cell_with_the_median_of_the_repeats(plain_run, tmp_path):
    run = load_run(plain_run)
    with write_csv(run, tmp_path / "c.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 9
    for row in rows[:6]:
        same = [r for r in run.records if (r.method, f"{r.reduction}") == (row["method"], row["reduction"])]
        assert float(row["runtime_s"]) == median(r.runtime_s for r in same)
        assert float(row["plane_error_pct_high"]) == max(r.metrics["plane_error_pct"] for r in same)
        assert float(row["time_search_s"]) > 0
    failed = [row for row in rows if row["status"] == "failed"]
    assert [row["runtime_s"] for row in failed] == [""]


def test_latex_table_balances_and_escapes(plain_run, tmp_path):
    text = write_latex(load_run(plain_run), tmp_path / "t.tex").read_text()
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == 1
    rows = [line for line in text.splitlines() if line.endswith(r"\\") and "multicolumn" not in line]
    assert {line.count(" & ") for line in rows} == {4}
    assert r"random\_sample" in text
    assert text.count(r"\textbf") == 2
    assert escape_latex(r"a_b%&#${}~^\<>") == (
        r"a\_b\%\&\#\$\{\}\textasciitilde{}\textasciicircum{}\textbackslash{}\textless{}\textgreater{}"
    )


def test_markdown_rows_have_as_many_cells_as_the_head(new_run, tmp_path):
    new_run.model("<script>|", dented_sphere(200))
    new_run.case("<script>|", "random_sample", 0.8, label="a|b")
    text = write_markdown(load_run(new_run.write()), tmp_path / "t.md").read_text()
    assert r"\<script\>\|" in text
    rows = [line.replace(r"\|", "") for line in text.splitlines() if line.startswith("|")]
    assert {line.count("|") for line in rows} == {4}


def test_every_figure_is_written_in_every_format(plain_run, tmp_path):
    paths = write_figures(load_run(plain_run), tmp_path)
    assert {p.suffix[1:] for p in paths} == set(FORMATS)
    assert {p.stem for p in paths} == {
        f"dented-{n}"
        for n in ("error-runtime", "error-points", "ratio", "stages", "kept", "errors", "surfaces")
    }
    heads = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}
    assert all(p.read_bytes().startswith(heads[p.suffix]) for p in paths)


def test_perturbed_inputs_have_a_figure_of_their_own(new_run, tmp_path):
    new_run.model("dented", dented_sphere(300))
    new_run.case("dented", "random_sample", 0.8)
    new_run.records += [
        replace(new_run.records[0], perturbation=kind, perturbation_level=0.5)
        for kind in ("noise", "missing")
    ]
    names = {path.stem for path in write_figures(load_run(new_run.write()), tmp_path)}
    assert "dented-perturbed-0.8" in names


def test_a_run_without_results_or_clouds_has_the_figures_that_it_can(plain_run, new_run, tmp_path):
    assert write_figures(load_run(new_run.write()), tmp_path / "none") == []
    shutil.copy(plain_run / "run.json", tmp_path / "run.json")
    names = {p.stem for p in write_figures(load_run(tmp_path), tmp_path / "some")}
    assert names == {f"dented-{n}" for n in ("error-runtime", "error-points", "ratio", "stages")}


def test_meshlab_opens_the_project_with_names_qualities_and_colours(new_run, tmp_path):
    points = dented_sphere(400)
    new_run.model("m & <m>", points, faces=np.array([[0, 1, 2]]))
    new_run.case("m & <m>", "first_rows", 0.9)
    new_run.case("m & <m>", "moved_points", 0.9)
    folder = new_run.write()
    (project,) = write_project(load_run(folder), tmp_path / "mlp")
    ElementTree.parse(project)
    meshes = pymeshlab().MeshSet()
    meshes.load_project(str(project))
    layers = {m.label(): m for m in (meshes.mesh(i) for i in range(meshes.mesh_number()))}
    assert list(layers) == [
        "m & <m>",
        "first_rows 90 % removed",
        "first_rows 90 % removed: error of every original",
        "moved_points 90 % removed",
        "moved_points 90 % removed: error of every original",
    ]
    assert layers["m & <m>"].face_number() == 1
    with np.load(folder / "clouds" / "m-m~first_rows~0.9~s0.npz") as file:
        errors, rows = file["plane_errors"].astype(float), file["indices"]
    errors *= 100 / np.linalg.norm(np.ptp(points, axis=0))
    own, whole = layers["first_rows 90 % removed"], layers["first_rows 90 % removed: error of every original"]
    assert np.array_equal(own.vertex_matrix(), points[rows])
    assert np.allclose(own.vertex_scalar_array(), errors[rows], rtol=1e-6)
    assert np.allclose(whole.vertex_scalar_array(), errors, rtol=1e-6)
    assert len(np.unique(whole.vertex_color_matrix(), axis=0)) > 20


def test_a_project_without_clouds_is_refused(plain_run, tmp_path):
    shutil.copy(plain_run / "run.json", tmp_path / "run.json")
    with pytest.raises(InputError, match=r"no clouds|not a readable run"):
        write_project(load_run(tmp_path), tmp_path / "mlp")


def test_one_result_is_visible_beside_the_original(plain_run, tmp_path):
    (project,) = write_project(load_run(plain_run), tmp_path / "mlp")
    layers = ElementTree.parse(project).iter("MLMesh")
    visible = [layer.get("label") for layer in layers if layer.get("visible") == "1"]
    assert visible == ["dented", "moved_points 90 % removed"], "the lowest error at the largest reduction"


def test_printed_tables_fit_a_narrow_terminal_and_name_what_did_not_end(plain_run):
    text = format_run(load_run(plain_run))
    assert max(map(len, text.splitlines())) <= NARROW
    assert "dented: 80 % removed, 300 of 1,500 points asked" in text
    for word in ("failed", "timeout", "skipped", "SIGABRT", "Stopped after 300 s.", "no faces"):
        assert word in text


def test_a_wider_terminal_is_given_longer_names(new_run):
    new_run.model("m", dented_sphere(200))
    label = "random_sample " + "setting=1 " * 9
    new_run.case("m", "random_sample", 0.8, label=label.strip())
    run = load_run(new_run.write())
    assert label.strip() not in format_run(run)
    assert label.strip() in format_run(run, 200)


@pytest.mark.parametrize("start", ["=", "+", "-", "@", " =", "\t="])
def test_no_cell_is_read_as_a_formula(start):
    assert escape_cell(f"{start}1+1").startswith("'")
    assert escape_cell("plain") == "plain"
    assert escape_cell(-1.5) == -1.5


def test_names_from_outside_move_no_cursor_and_open_no_formula(new_run, tmp_path):
    evil = "=cmd|' /C calc'!A0\x1b[2J\x1b]0;title\x07\r\n"
    new_run.model("m", dented_sphere(200))
    new_run.case("m", "random_sample", 0.8, label=evil)
    new_run.trouble("m", evil + "2", 0.8, "failed", "\x1b[31m" + evil)
    run = load_run(new_run.write())
    texts = [format_run(run), write_markdown(run, tmp_path / "t.md").read_text()]
    texts += [
        write_latex(run, tmp_path / "t.tex").read_text(),
        write_csv(run, tmp_path / "t.csv").read_text(),
    ]
    assert not any("\x1b" in text or "\r" in text or "\x07" in text for text in texts)
    with (tmp_path / "t.csv").open(newline="") as file:
        assert all(row["method"].startswith("'=cmd") for row in csv.DictReader(file))
    assert plain("a\x1b[2Jb\nc") == "ab c"


def test_a_file_outside_the_runs_folder_is_not_read(plain_run, tmp_path):
    shutil.copytree(plain_run, tmp_path / "run")
    secret = tmp_path / "secret.npz"
    shutil.copy(plain_run / "clouds" / "dented.npz", secret)
    document = (tmp_path / "run" / "run.json").read_text()
    for name in ("../secret.npz", str(secret)):
        moved = document.replace("clouds/dented.npz", name)
        (tmp_path / "run" / "run.json").write_text(moved)
        with pytest.raises(InputError, match=r"no clouds|not a readable run"):
            write_project(load_run(tmp_path / "run"), tmp_path / "mlp")
