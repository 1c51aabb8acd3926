"""The page without a browser: what is in it, what is escaped, what is refused."""

import base64
import json
import re
import shutil

import numpy as np
import pytest
from made_runs import METHODS, dented_sphere

from lpcompare.benchmark.plan import Plan, Variant
from lpcompare.benchmark.runner import run_plan
from lpcompare.errors import InputError, UnknownName
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.report.page import write_page, write_view
from lpcompare.types import PointCloud


def text_of(path):
    """The page without its data and scripts."""
    return re.sub(r"(?s)<(script|style)[^>]*>.*?</\1>", "", path.read_text(encoding="utf-8"))


def data_of(path, which):
    found = re.search(
        rf'(?s)<script type="application/json" id="{which}">(.*?)</script>', path.read_text("utf-8")
    )
    return json.loads(found[1])


def test_page_names_every_method_status_and_reason_and_the_command(plain_run, tmp_path):
    text = text_of(write_page(plain_run, tmp_path / "page.html"))
    for word in (*METHODS, "crasher", "sleeper", "mesher", "SIGABRT", "Stopped after 300 s.", "no faces"):
        assert word in text
    assert "lpcompare run --model made" in text
    assert "first_rows" in text_of(write_page(plain_run / "run.json", tmp_path / "again.html"))


@pytest.mark.parametrize("part", ["environment", "plan", "inputs", "records"])
def test_a_run_that_says_little_has_a_page(plain_run, tmp_path, part):
    run = json.loads((plain_run / "run.json").read_text(encoding="utf-8"))
    run[part] = type(run[part])()
    (tmp_path / "run.json").write_text(json.dumps(run), encoding="utf-8")
    assert "</html>" in text_of(write_page(tmp_path))


def test_points_that_no_method_saw_are_on_the_page(plain_run, tmp_path):
    run = json.loads((plain_run / "run.json").read_text(encoding="utf-8"))
    for facts in run["inputs"].values():
        assert "left_out" not in facts
        facts["left_out"] = "7 points without coordinates"
    (tmp_path / "run.json").write_text(json.dumps(run), encoding="utf-8")
    assert "left_out 7 points without coordinates" in text_of(write_page(tmp_path))


def test_the_heading_is_the_studys_title_and_the_model_where_there_is_none(plain_run, tmp_path):
    run = json.loads((plain_run / "run.json").read_text(encoding="utf-8"))
    assert "<h1>dented</h1>" in text_of(write_page(plain_run, tmp_path / "page.html"))
    run["plan"]["title"] = "What <b>noise</b> does."
    (tmp_path / "run.json").write_text(json.dumps(run), encoding="utf-8")
    text = text_of(write_page(tmp_path))
    assert "<h1>What &lt;b&gt;noise&lt;/b&gt; does.</h1>" in text
    assert "compared · dented</p>" in text


def test_page_asks_for_nothing_from_a_network(plain_run, tmp_path):
    page = write_page(plain_run, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "default-src 'none'" in page
    bare = re.sub(r"(?s)<script.*?</script>", "", page)
    sources = re.findall(r"""<(?:script|img|iframe|link)[^>]+(?:src|href)\s*=\s*["']?([^"'>]*)""", bare)
    assert all(source.startswith("data:image/png;base64,") for source in sources)


def test_names_that_look_like_markup_show_as_text(new_run, tmp_path):
    evil = "<script>alert(1)</script>"
    new_run.model(evil, dented_sphere(300))
    new_run.case(evil, "random_sample", 0.9, label="<img src=x onerror=alert(2)>")
    new_run.case(evil, "first_rows", 0.9, label="\"&'</script><b>")
    new_run.trouble(evil, "sad", 0.9, "failed", "</td><script>alert(3)</script>")
    path = write_page(new_run.write(), tmp_path / "page.html")
    page = path.read_text(encoding="utf-8")
    assert evil not in page
    assert "<img src=x" not in text_of(path)
    assert "</script><b>" not in page
    assert "<b>&lt;img src=x" in page, "the reference's name is text"
    assert "&lt;script&gt;alert(1)" in page
    assert data_of(path, "view-data")[0]["name"] == evil


def words(text):
    return np.frombuffer(base64.b64decode(text), "<u2")


def test_view_data_gives_the_errors_and_the_points_back(plain_run, tmp_path):
    (model,) = data_of(write_page(plain_run, tmp_path / "page.html"), "view-data")
    with np.load(plain_run / "clouds" / "dented.npz") as file:
        points = file["points"]
    shown = words(model["points"]).reshape(-1, 3) / 65535 * model["span"] + model["low"]
    distances, rows = Neighbors(points).query(shown, 1)
    assert distances.max() < 2 * max(model["span"]) / 65535
    assert sorted(rows[:, 0]) == list(range(len(points))), "every point is there, in another order"
    (result,) = [r for r in model["results"] if r["method"] == "first_rows" and r["reduction"] == 0.9]
    with np.load(plain_run / "clouds" / "dented~first_rows~0.9~s0.npz") as file:
        errors, kept = file["plane_errors"] * 100 / np.linalg.norm(np.ptp(points, axis=0)), file["indices"]
    packed = result["columns"]["error"]
    found = words(packed["steps"]) / 65535 * packed["span"] + packed["low"]
    assert np.allclose(found, errors[rows[:, 0]], atol=packed["span"] / 65535)
    bits = np.unpackbits(np.frombuffer(base64.b64decode(result["kept"]), "u1"), bitorder="little")
    assert np.array_equal(np.sort(rows[np.flatnonzero(bits[: len(points)]), 0]), kept)


def test_the_reference_the_best_subset_and_the_papers_method_are_shown_first(plain_run, tmp_path):
    (model,) = data_of(write_page(plain_run, tmp_path / "p.html", reference="moved_points"), "view-data")
    assert model["defaults"][:2] == ["moved_points", "random_sample"]


def test_marks_of_a_method_are_offered_where_it_said_them(new_run, tmp_path):
    points = dented_sphere(300)
    new_run.model("m", points)
    marks = {
        "labels": np.arange(300) % 7,
        "curvature": np.linspace(0, 1, 300),
        "feature_mask": np.arange(300) < 9,
    }
    new_run.case("m", "random_sample", 0.9, marks=marks)
    new_run.case("m", "first_rows", 0.9)
    with_marks, without = data_of(write_page(new_run.write(), tmp_path / "p.html"), "view-data")[0]["results"]
    assert {"labels", "features"} <= with_marks.keys()
    assert "curvature" in with_marks["columns"]
    assert not {"labels", "features"} & without.keys()
    assert list(without["columns"]) == ["error"]


def test_a_real_run_of_our_method_offers_its_clusters_curvature_and_features(tmp_path):
    plan = Plan(models=("m",), variants=(Variant("lp_density"),), reductions=(0.8,), threads=1)
    run_plan(plan, {"m": PointCloud(dented_sphere(300), name="m")}, tmp_path / "run")
    (result,) = data_of(write_page(tmp_path / "run"), "view-data")[0]["results"]
    assert {"labels", "features", "kept"} <= result.keys()
    assert result["columns"].keys() == {"error", "curvature"}


def test_a_large_cloud_is_thinned_for_display_and_its_numbers_are_not(new_run, tmp_path, monkeypatch):
    monkeypatch.setattr("lpcompare.report.clouds3d.MOST_POINTS", 200)
    new_run.model("m", dented_sphere(1000))
    new_run.case("m", "random_sample", 0.5)
    (model,) = data_of(write_page(new_run.write(), tmp_path / "p.html"), "view-data")
    assert (model["shown"], model["total"]) == (200, 1000)
    assert model["results"][0]["count"] == 500
    assert "nearest" in model["results"][0]


def test_from_run_json_alone_the_page_says_that_it_has_no_views(plain_run, tmp_path):
    shutil.copy(plain_run / "run.json", tmp_path / "run.json")
    path = write_page(tmp_path)
    assert path == tmp_path / "report.html"
    assert "made without the clouds of the run" in text_of(path)
    assert data_of(path, "view-data") == []


def test_empty_single_and_ten_model_runs_each_give_a_page(new_run, tmp_path):
    assert "nothing was compared" in text_of(write_page(new_run.write(), tmp_path / "empty.html"))
    for i in range(10):
        new_run.model(f"model {i}", dented_sphere(200, seed=i))
        new_run.case(f"model {i}", "random_sample", 0.8)
    assert "One method on ten models" in text_of(write_page(new_run.write(), tmp_path / "single.html"))
    for i in range(10):
        new_run.case(f"model {i}", "first_rows", 0.8)
        new_run.case(f"model {i}", "moved_points", 0.8)
    text = text_of(write_page(new_run.write(), tmp_path / "ten.html"))
    assert "Ranks over the models" in text
    assert "Friedman" in text


@pytest.mark.parametrize(
    "content", ["", '{"schema_version": 1, "plan"', "[1, 2]", '{"nodes": []}', '{"schema_version": 99}']
)
def test_a_truncated_or_foreign_file_is_refused_in_a_sentence(tmp_path, content):
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(InputError, match="run"):
        write_page(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_a_truncated_cloud_is_refused_and_leaves_no_page(new_run):
    new_run.model("m", dented_sphere(200))
    new_run.case("m", "random_sample", 0.8)
    folder = new_run.write()
    file = folder / "clouds" / "m~random_sample~0.8~s0.npz"
    file.write_bytes(file.read_bytes()[:200])
    with pytest.raises(InputError, match="readable"):
        write_page(folder)
    assert not list(folder.glob("report.html*"))


def test_an_unknown_reference_is_refused(plain_run, tmp_path):
    with pytest.raises(UnknownName, match="random_sample"):
        write_page(plain_run, tmp_path / "p.html", reference="randomsample")


def test_same_run_same_page(plain_run, tmp_path):
    first, second = (write_page(plain_run, tmp_path / f"{i}.html").read_bytes() for i in range(2))
    assert first == second


@pytest.mark.parametrize(
    "points", [np.zeros((1, 3)), np.ones((5, 3)), np.c_[np.arange(9.0), np.zeros((9, 2))]]
)
def test_one_cloud_has_a_page_even_without_extent(tmp_path, points):
    path = write_view(PointCloud(points, name="<b>tiny"), tmp_path / "v.html")
    assert data_of(path, "view-data")[0]["total"] == len(points)
    assert "<b>tiny" not in path.read_text(encoding="utf-8")


def test_a_clouds_own_colours_and_scalars_are_offered(tmp_path):
    points = dented_sphere(50)
    cloud = PointCloud(
        points, colors=np.tile([1, 0, 0, 1.0], (50, 1)), attributes={"height": points[:, 2], "names": points}
    )
    (view,) = data_of(write_view(cloud, tmp_path / "v.html"), "view-data")
    assert list(view["columns"]) == ["height"]
    assert base64.b64decode(view["colors"])[:3] == b"\xff\x00\x00"
