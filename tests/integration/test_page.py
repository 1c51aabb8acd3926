"""The page in a browser: no error, no request, and everything that can be clicked does what it says."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from made_runs import MadeRun, dented_sphere, plain_run  # noqa: F401

from lpcompare.report.page import write_page, write_view
from lpcompare.types import PointCloud

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
WAIT_MS = 60_000


@pytest.fixture(scope="module")
def browser():
    """Debian's Chromium, drawing WebGL in software."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("chromium is not installed (Debian: apt-get install chromium)")
    with playwright.sync_playwright() as running:
        chromium = running.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield chromium
        chromium.close()


class Visit:
    """A page opened from disk, with all that it complained about and asked for."""

    def __init__(self, browser, path, script="", **context):
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        self.page = self.context.new_page()
        self.page.add_init_script(script)
        self.page.set_default_timeout(WAIT_MS)
        self.complaints, self.requests = [], []
        self.page.on("console", lambda m: m.type == "error" and self.complaints.append(m.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri())

    def drawn(self, views):
        self.page.wait_for_function(f"document.getElementById('view-grid').dataset.drawn === '{views}'")
        return self

    def quiet(self, path):
        return not self.complaints and self.requests == [path.as_uri()]


@pytest.fixture(scope="module")
def path(plain_run, tmp_path_factory):  # noqa: F811
    return write_page(plain_run, tmp_path_factory.mktemp("page") / "page.html")


@pytest.fixture(scope="module")
def opened(browser, path):
    visit = Visit(browser, path).drawn(3)
    yield visit
    visit.context.close()


RESET = """async () => {
  for (const id of ["filter", "filter-reduction"]) document.getElementById(id).value = "";
  filterTable(document.getElementById("table"));
  hiddenMethods.clear();
  document.getElementById("view-points").value = "all";
  Object.assign(view, { colour: "errors", keptOnly: false, reduction: 0.9 });
  view.methods = ["random_sample", "first_rows"];
  chooseModel(0);
  await drawViews();
}"""


@pytest.fixture
def visit(opened):
    """The page of the plain run, opened once: the original and two results at 90 %, nothing filtered."""
    opened.page.evaluate(RESET)
    return opened.drawn(3)


def column(page, number):
    return page.eval_on_selector_all(
        f"#table tbody tr:not([hidden]) td:nth-child({number})",
        "cells => cells.map(c => c.dataset.value ?? c.innerText)",
    )


def test_page_opens_without_a_complaint_or_a_request(visit, path):
    visit.page.evaluate("drawCharts()")
    assert visit.page.locator("#chart-runtime .plot-container").count() == 1
    assert visit.quiet(path), (visit.complaints, visit.requests)


WATCH_DRAWING = """
window.steps = [];
let plotly;
Object.defineProperty(window, "Plotly", {
  configurable: true,
  get: () => plotly,
  set: (loaded) => {
    plotly = { ...loaded, react: async (target, ...rest) => {
      steps.push(target.className === "scene" ? "view" : "chart");
      await loaded.react(target, ...rest);
      requestAnimationFrame(() => setTimeout(() => steps.push("frame")));
    } };
  },
});
"""


def test_each_view_is_on_the_screen_before_the_next_is_begun_and_the_charts_come_last(browser, path):
    everything_in_sight = {"width": 1280, "height": 2400}
    visit = Visit(browser, path, WATCH_DRAWING, viewport=everything_in_sight).drawn(3)
    visit.page.wait_for_function("steps.filter(step => step === 'chart').length === 4")
    assert visit.page.evaluate("steps").index("chart") == 6
    assert visit.page.evaluate("steps.slice(0, 6)") == ["view", "frame"] * 3
    visit.context.close()


def test_a_click_on_a_heading_sorts_and_a_second_one_turns_the_order(visit):
    heading = visit.page.locator("#table th[title=runtime_s] button")
    number = visit.page.evaluate(
        "[...document.querySelectorAll('#table th')].findIndex(h => h.title === 'runtime_s') + 1"
    )
    heading.click()
    up = column(visit.page, number)
    values = [float(v) for v in up if v != "–"]
    assert values == sorted(values)
    assert up[-3:] == ["–"] * 3, "rows without a value stay at the end"
    heading.click()
    down = column(visit.page, number)
    assert [float(v) for v in down if v != "–"] == values[::-1]
    assert down[-3:] == ["–"] * 3


def test_words_and_a_reduction_filter(visit):
    visit.page.fill("#filter", "random")
    assert column(visit.page, 2) == ["0.8", "0.9"]
    visit.page.select_option("#filter-reduction", "0.9")
    assert column(visit.page, 2) == ["0.9"]
    assert visit.page.inner_text("#filter-count") == "1 of 9 rows"
    visit.page.fill("#filter", "nothing of the kind")
    assert column(visit.page, 2) == []


def test_every_measure_is_one_click_away(visit):
    before = visit.page.locator("#table thead th:visible").count()
    visit.page.check("#all-columns")
    assert visit.page.locator("#table thead th:visible").count() > before


def cameras(page):
    return page.evaluate(
        "scenes().map(s => Object.values(s._fullLayout.scene._scene.getCamera().eye).map(v => +v.toFixed(4)))"
    )


def test_turning_one_view_turns_the_others(visit):
    box = visit.page.locator("#view-grid .scene").nth(1).bounding_box()
    before = cameras(visit.page)
    assert before[0] == before[1] == before[2]
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    visit.page.mouse.move(x, y)
    visit.page.mouse.down()
    for step in range(1, 6):
        visit.page.mouse.move(x + 20 * step, y + 8 * step)
    visit.page.mouse.up()
    visit.page.wait_for_function("leader === null")
    visit.page.wait_for_timeout(500)
    after = cameras(visit.page)
    assert after[1] != before[1]
    assert after[0] == pytest.approx(after[1], abs=1e-3)
    assert after[2] == pytest.approx(after[1], abs=1e-3)


def colours(page, scene):
    return page.evaluate(f"Array.from(scenes()[{scene}].data[0].marker.color)")


def test_switching_the_colouring_recolours_and_changes_the_legend(visit):
    errors = colours(visit.page, 1)
    visit.page.select_option("#view-colour", "marks")
    visit.page.wait_for_function("scenes()[1].data[0].marker.cmax === 3")
    assert set(colours(visit.page, 1)) == {0.5, 1.5}
    assert "removed" in visit.page.inner_text("#view-legend")
    visit.page.select_option("#view-colour", "errors")
    visit.page.wait_for_function("scenes()[1].data[0].marker.cmax !== 3")
    assert colours(visit.page, 1) == errors


def test_error_colours_share_one_scale(visit):
    scales = visit.page.evaluate("scenes().slice(1).map(s => s.data[0].marker.cmax)")
    assert len(scales) == 2
    assert len(set(scales)) == 1


def test_the_kept_points_are_as_many_as_the_result_has(visit):
    visit.page.select_option("#view-points", "kept")
    visit.page.wait_for_function(
        "scenes()[1].data[0].x.length === 150 && scenes()[2].data[0].x.length === 150"
    )
    assert len(set(map(len, visit.page.evaluate("scenes().map(s => Array.from(s.data[0].x))")))) == 2


def test_methods_and_reductions_can_be_chosen(visit):
    visit.page.locator("#view-methods button", has_text="moved_points").click()
    visit.drawn(4)
    visit.page.select_option("#view-reduction", "0.8")
    visit.page.wait_for_function(
        "[...document.querySelectorAll('.view figcaption span')].slice(1)"
        ".every(detail => detail.textContent.startsWith('300 '))"
    )
    visit.page.locator("#view-methods button", has_text="first_rows").click()
    visit.drawn(3)


def test_pointing_at_a_cloud_reads_the_same_point_in_every_view(visit, plain_run):  # noqa: F811
    visit.page.evaluate("readOut(scenes()[1], { pointNumber: 7, curveNumber: 0, x: 0, y: 0, z: 0 })")
    said = visit.page.locator(".readout").all_inner_texts()
    with np.load(plain_run / "clouds" / "dented.npz") as file:
        points = file["points"]
    for name, text in zip(visit.page.evaluate("view.methods"), said[1:], strict=True):
        with np.load(plain_run / "clouds" / f"dented~{name}~0.9~s0.npz") as file:
            error = file["plane_errors"][7] * 100 / np.linalg.norm(np.ptp(points, axis=0))
        assert float(text.split()[1]) == pytest.approx(error, rel=0.02, abs=1e-3)


def test_charts_follow_measure_reference_and_legend(visit):
    visit.page.evaluate("drawCharts()")
    visit.page.select_option("#chart-measure", "hausdorff_pct")
    visit.page.wait_for_function(
        "document.getElementById('chart-count')._fullLayout.yaxis.title.text.includes('Hausdorff')"
    )
    visit.page.select_option("#chart-reference", "first_rows")
    visit.page.wait_for_function(
        "document.getElementById('chart-ratio').data"
        ".some(t => t.name === 'first_rows' && t.x.every(v => v === 1))"
    )
    visit.page.locator("#chart-legend button", has_text="first_rows").click()
    visit.page.wait_for_function(
        "!document.getElementById('chart-count').data.some(t => t.name === 'first_rows')"
    )


def test_pointing_at_a_method_in_the_legend_picks_it_out(visit):
    visit.page.evaluate("drawCharts()")
    opacities = "document.getElementById('chart-count').data.map(t => [t.name, t.opacity])"
    visit.page.mouse.move(0, 0)
    visit.page.locator("#chart-legend button", has_text="first_rows").hover()
    visit.page.wait_for_function("document.getElementById('chart-count').data.some(t => t.opacity < 1)")
    assert [name for name, opacity in visit.page.evaluate(opacities) if opacity == 1] == ["first_rows"]
    visit.page.mouse.move(0, 0)
    visit.page.wait_for_function("document.getElementById('chart-count').data.every(t => t.opacity === 1)")


def test_damage_is_drawn_per_kind_and_the_note_names_what_never_saw_outliers(browser, plain_run, tmp_path):  # noqa: F811
    run = json.loads((plain_run / "run.json").read_text(encoding="utf-8"))
    damage = [("noise", 0.5), ("noise", 1.0), ("outliers", 0.1)]
    run["records"] += [
        row | {"perturbation": kind, "perturbation_level": level, "needs_mesh": row["method"] == "first_rows"}
        for row in run["records"]
        for kind, level in damage
    ]
    (tmp_path / "run.json").write_text(json.dumps(run), encoding="utf-8")
    path = write_page(tmp_path)
    visit = Visit(browser, path)
    visit.page.evaluate("drawCharts()")
    drawn = "document.getElementById('damage-noise').data.map(t => [t.name, ...t.x])"
    assert [0, 0.5, 1] in [curve[1:] for curve in visit.page.evaluate(drawn)]
    assert len(visit.page.evaluate(drawn)) == 3
    assert "needs the mesh (first_rows) never sees them" in visit.page.inner_text("#damage .note")
    visit.page.click("#chart-legend button[data-method=first_rows]")
    visit.page.wait_for_function(f"{drawn}.length === 2")
    visit.page.select_option("#damage-reduction", "0.8")
    visit.page.wait_for_function(f"{drawn}.length === 2")
    assert visit.quiet(path), (visit.complaints, visit.requests)
    visit.context.close()


def test_the_button_turns_light_to_dark_and_back(visit):
    ground = lambda: visit.page.evaluate("getComputedStyle(document.body).backgroundColor")  # noqa: E731
    light = ground()
    visit.page.click("#theme")
    assert ground() != light
    visit.page.click("#theme")
    assert ground() == light


def test_paper_is_light_and_holds_every_chart(browser, path):
    visit = Visit(browser, path, color_scheme="dark").drawn(3)
    assert len(visit.page.pdf()) > 50_000
    assert visit.page.locator("#charts .plot-container").count() == 4
    visit.page.emulate_media(media="print", color_scheme="dark")
    assert visit.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    visit.context.close()


def test_paper_shows_what_the_views_show(browser, path):
    visit = Visit(browser, path).drawn(3)
    visit.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    colours = visit.page.eval_on_selector_all(
        "#view-grid canvas.still",
        """stills => stills.map(s => {
          const { data } = s.getContext("2d").getImageData(0, 0, s.width, s.height);
          return new Set(new Uint32Array(data.buffer)).size;
        })""",
    )
    assert len(colours) == 3
    assert min(colours) > 20, "a blank picture has one colour"
    assert visit.page.locator("#view-grid .scene:visible").count() == 0
    visit.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert visit.page.locator("#view-grid .still").count() == 0
    assert visit.page.locator("#view-grid .scene:visible").count() == 3
    assert visit.quiet(path), (visit.complaints, visit.requests)
    visit.context.close()


def test_a_phone_needs_no_sideways_scrolling(browser, path):
    visit = Visit(browser, path, viewport={"width": 390, "height": 844}).drawn(3)
    assert visit.page.evaluate("document.documentElement.scrollWidth") <= 390
    visit.context.close()


def test_a_model_named_script_shows_as_text_everywhere(browser, tmp_path):
    evil = "<script>document.title='caught'</script><img src=x onerror=\"document.title='caught'\">"
    made = MadeRun(tmp_path / "run")
    for name in (evil, "other"):
        made.model(name, dented_sphere(300))
        made.case(name, "random_sample", 0.9, label=evil)
    made.trouble(evil, evil, 0.9, "failed", evil)
    path = write_page(made.write(), tmp_path / "page.html")
    visit = Visit(browser, path).drawn(2)
    visit.page.evaluate("drawCharts()")
    assert visit.page.title() != "caught"
    assert visit.page.locator("main img").count() == 0
    assert evil in visit.page.inner_text("#view-methods")
    assert evil in visit.page.inner_text("#table")
    assert visit.quiet(path), (visit.complaints, visit.requests)
    visit.context.close()


def test_a_page_without_clouds_and_an_empty_one_open_without_a_complaint(browser, plain_run, tmp_path):  # noqa: F811
    shutil.copy(plain_run / "run.json", tmp_path / "run.json")
    for path in (write_page(tmp_path), write_page(MadeRun(tmp_path / "none").write())):
        visit = Visit(browser, path)
        visit.page.wait_for_load_state()
        assert visit.quiet(path), (visit.complaints, visit.requests)
        visit.context.close()


def test_one_cloud_opens_and_its_colouring_can_be_chosen(browser, tmp_path):
    points = dented_sphere(300)
    cloud = PointCloud(points, colors=np.ones((300, 4)), attributes={"height": points[:, 2]}, name="one")
    path = write_view(cloud, tmp_path / "view.html")
    visit = Visit(browser, path).drawn(1)
    visit.page.select_option("#view-colour", "height")
    visit.page.wait_for_function("Math.abs(scenes()[0].data[0].marker.cmax - 1.1) < 0.1")
    assert visit.quiet(path), (visit.complaints, visit.requests)
    visit.context.close()
