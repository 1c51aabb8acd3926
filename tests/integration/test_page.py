"""The page in a browser: no error, no request, and everything that can be clicked does what it says."""

import csv
import json
import shutil
import sys
import threading
from http.client import HTTPConnection
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from made_runs import MadeRun, dented_sphere, plain_run  # noqa: F401

from lpcompare.benchmark.record import load_run
from lpcompare.report.page import write_page, write_view
from lpcompare.report.serve import make_server
from lpcompare.types import PointCloud

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
FLAGS += ["--disable-gpu-compositing"]  # the views alone go through software WebGL, not the whole page
DRIVER = "GL Driver Message (OpenGL, Performance"
"""The browser's own note that software WebGL is slow."""
WAIT_MS = 120_000


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

    def __init__(self, browser, path, script="", fragment="", **context):
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        self.page = self.context.new_page()
        self.page.add_init_script(script)
        self.page.set_default_timeout(WAIT_MS)
        self.complaints, self.requests = [], []
        self.page.on("console", lambda m: DRIVER in m.text or self.complaints.append(m.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri() + fragment)

    def drawn(self, views):
        self.page.wait_for_function(f"document.getElementById('view-grid').dataset.drawn === '{views}'")
        return self

    def quiet(self, path):
        own = [url for url in self.requests if not url.startswith("blob:")]
        return not self.complaints and own == [path.as_uri()]


@pytest.fixture(scope="module")
def path(plain_run, tmp_path_factory):  # noqa: F811
    return write_page(plain_run, tmp_path_factory.mktemp("page") / "page.html")


@pytest.fixture(scope="module")
def opened(browser, path):
    visit = Visit(browser, path).drawn(3)
    yield visit
    visit.context.close()


RESET = """async () => {
  for (const id of ["filter", "filter-reduction"]) byId(id).value = "";
  filterTable(byId("table"));
  hiddenMethods.clear();
  byId("view-points").value = "all";
  byId("view-layout").value = "side";
  Object.assign(view, { colour: "error", keptOnly: false, reduction: 0.9, layout: "side" });
  Object.assign(view, { ends: null, picked: null, full: null });
  document.documentElement.classList.remove("filled");
  byId("views").scrollIntoView();
  view.methods = ["random_sample", "first_rows"];
  Object.assign(camera, { yaw: 0.35, pitch: 0.25 });
  chooseModel(0);
  fit();
  await showViews();
}"""


@pytest.fixture
def visit(opened):
    """The page of the plain run, opened once: the original and two results at 90 %, nothing filtered."""
    opened.page.evaluate(RESET)
    settle(opened.page)
    return opened.drawn(3)


def settle(page):
    """Until the views are drawn and the camera rests."""
    page.wait_for_function("asked === 0 && view.most === Infinity")


def column(page, key):
    number = page.evaluate(
        "key => [...document.querySelectorAll('#table th')].findIndex(h => h.dataset.key === key) + 1", key
    )
    return page.eval_on_selector_all(
        f"#table tbody tr:not([hidden]) td:nth-child({number})",
        "cells => cells.map(c => c.dataset.value ?? c.innerText)",
    )


def test_page_opens_without_a_complaint_or_a_request(visit, path):
    visit.page.evaluate("drawCharts()")
    visit.page.wait_for_selector("#charts[data-drawn]")
    assert visit.page.locator("#chart-runtime .plot-container").count() == 1
    assert visit.quiet(path), (visit.complaints, visit.requests)


def test_the_charts_come_after_the_views_and_do_not_wait_to_be_seen(browser, path):
    visit = Visit(browser, path, viewport={"width": 1280, "height": 300}).drawn(3)
    assert visit.page.evaluate("typeof Plotly") == "undefined"
    visit.page.wait_for_selector("#charts[data-drawn]", state="attached")
    assert visit.page.evaluate("scrollY") == 0
    visit.context.close()


def test_a_click_on_a_heading_sorts_and_a_second_one_turns_the_order(visit):
    heading = visit.page.locator("#table th[data-key=runtime_s] button")
    heading.click()
    up = column(visit.page, "runtime_s")
    values = [float(v) for v in up if v != "–"]
    assert values == sorted(values)
    assert up[-3:] == ["–"] * 3, "rows without a value stay at the end"
    heading.click()
    down = column(visit.page, "runtime_s")
    assert [float(v) for v in down if v != "–"] == values[::-1]
    assert down[-3:] == ["–"] * 3


def test_words_and_a_reduction_filter(visit):
    visit.page.fill("#filter", "random_sample")
    assert column(visit.page, "reduction") == ["0.8", "0.9"]
    visit.page.select_option("#filter-reduction", "0.9")
    assert column(visit.page, "reduction") == ["0.9"]
    assert visit.page.inner_text("#filter-count") == "1 of 9 rows"
    visit.page.fill("#filter", "nothing of the kind")
    assert column(visit.page, "reduction") == []


def test_every_measure_is_one_click_away(visit):
    before = visit.page.locator("#table thead th:visible").count()
    visit.page.check("#all-columns")
    assert visit.page.locator("#table thead th:visible").count() > before
    visit.page.uncheck("#all-columns")


def matrices(page):
    """The matrix with which each view was drawn last; all canvases have one size."""
    settle(page)
    return np.array(page.evaluate("panels().map(panel => [...panel.seen.turn])"))


def middle(page, number):
    box = page.locator("#view-grid canvas").nth(number).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def turned_together(page, before):
    after = matrices(page)
    assert np.abs(after - before).max() > 0.01, "the views have moved"
    assert np.abs(after - after[0]).max() < 1e-3, "all alike"


def test_a_drag_on_one_view_turns_all(visit):
    before = matrices(visit.page)
    x, y = middle(visit.page, 1)
    visit.page.mouse.move(x, y)
    visit.page.mouse.down()
    for step in range(1, 6):
        visit.page.mouse.move(x + 20 * step, y + 8 * step)
    visit.page.mouse.up()
    turned_together(visit.page, before)


def test_the_wheel_on_one_view_zooms_all(visit):
    before = matrices(visit.page)
    visit.page.mouse.move(*middle(visit.page, 2))
    for _ in range(3):
        visit.page.mouse.wheel(0, -120)
    visit.page.wait_for_function("camera.distance < 0.9 * reachOf(view.model) / Math.sin(FIELD / 2)")
    turned_together(visit.page, before)


def touch(session, kind, *places):
    points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def test_fingers_on_one_view_turn_and_zoom_all(browser, path):
    visit = Visit(browser, path, has_touch=True).drawn(3)
    session = visit.context.new_cdp_session(visit.page)
    visit.page.locator("#view-grid").scroll_into_view_if_needed()
    before, (x, y) = matrices(visit.page), middle(visit.page, 0)
    touch(session, "touchStart", (x, y))
    for step in range(1, 6):
        touch(session, "touchMove", (x + 15 * step, y + 10 * step))
    touch(session, "touchEnd")
    turned_together(visit.page, before)
    before, distance = matrices(visit.page), visit.page.evaluate("camera.distance")
    touch(session, "touchStart", (x - 20, y), (x + 20, y))
    for step in range(1, 6):
        touch(session, "touchMove", (x - 20 - 8 * step, y), (x + 20 + 8 * step, y))
    touch(session, "touchEnd")
    assert visit.page.evaluate("camera.distance") < 0.7 * distance
    turned_together(visit.page, before)
    visit.context.close()


def test_the_keyboard_alone_reaches_every_control_and_turns_the_views(browser, path):
    visit = Visit(browser, path).drawn(3)
    page = visit.page
    wanted = page.evaluate(
        """() => [...document.querySelectorAll("button, select, input, canvas[tabindex], summary")]
          .filter(e => e.checkVisibility() && !e.disabled).map((e, i) => (e.dataset.stop = i)).length"""
    )
    reached = set()
    for _ in range(3 * wanted):
        page.keyboard.press("Tab")
        stop = page.evaluate("document.activeElement.dataset.stop ?? null")
        if stop is None and len(reached) == wanted:
            break
        reached.add(stop)
    assert len(reached - {None}) == wanted
    before = matrices(page)
    page.locator("#view-grid canvas").first.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    turned_together(page, before)
    page.locator(".fill").first.focus()
    page.keyboard.press("Enter")
    assert page.locator(".view.full").count() == 1
    page.keyboard.press("Escape")
    assert page.locator(".view.full").count() == 0
    visit.context.close()


def colours(page, number):
    """How many pixels of a view have which colour, the rare ones left out."""
    settle(page)
    return page.evaluate(
        """i => {
          const canvas = panels()[i].querySelector("canvas"), counts = {};
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          for (const word of new Uint32Array(data.buffer)) counts[word] = (counts[word] ?? 0) + 1;
          return Object.keys(counts).length;
        }""",
        number,
    )


def test_switching_the_colouring_recolours_and_changes_the_legend(visit):
    errors = visit.page.evaluate("layersOf(shownEntries()[1])[0].kind")
    assert errors == "scalar"
    assert visit.page.locator("#scale").is_visible()
    many = colours(visit.page, 1)
    visit.page.select_option("#view-colour", "marks")
    visit.page.wait_for_function("layersOf(shownEntries()[1])[0].kind === 'category'")
    assert "removed" in visit.page.inner_text("#scale-keys")
    assert not visit.page.locator("#scale").is_visible()
    assert many > 50
    visit.page.select_option("#view-colour", "height")
    visit.page.wait_for_function("byId('scale-text').textContent.startsWith('height')")


def test_the_ends_of_the_scale_can_be_dragged_and_reset(visit):
    usual = visit.page.evaluate("scaleEnds()")
    before = visit.page.evaluate("panels()[1].querySelector('canvas').toDataURL()")
    visit.page.locator("#scale-bar").scroll_into_view_if_needed()
    box = visit.page.locator("#scale-bar").bounding_box()
    reach = visit.page.evaluate("scaleReach()")
    x = box["x"] + box["width"] * (usual[1] - reach[0]) / (reach[1] - reach[0])
    visit.page.mouse.move(x, box["y"] + 7)
    visit.page.mouse.down()
    visit.page.mouse.move(x - 60, box["y"] + 7, steps=4)
    visit.page.mouse.up()
    settle(visit.page)
    ends = visit.page.evaluate("scaleEnds()")
    assert ends[0] == usual[0]
    assert ends[1] < usual[1]
    assert visit.page.evaluate("panels()[1].querySelector('canvas').toDataURL()") != before
    visit.page.click("#scale-reset")
    visit.page.wait_for_function("view.ends === null")
    assert visit.page.evaluate("scaleEnds()") == usual


def test_error_colours_share_one_scale_with_ticks_and_a_histogram_of_each(visit):
    scales = visit.page.evaluate("shownEntries().slice(1).map(e => layersOf(e)[0].ends)")
    assert len(scales) == 2
    assert scales[0] == scales[1]
    assert visit.page.locator("#scale-histogram path").count() == 2
    marks = [float(text) for text in visit.page.locator("#scale-ticks span").all_inner_texts()]
    assert len(marks) >= 3
    assert np.allclose(np.diff(marks), np.diff(marks)[0])


def test_the_numbers_of_each_view_are_mean_95_percent_and_largest(visit, plain_run):  # noqa: F811
    with np.load(plain_run / "clouds" / "dented.npz") as file:
        points = file["points"]
    with np.load(plain_run / "clouds" / "dented~first_rows~0.9~s0.npz") as file:
        errors = file["plane_errors"] * 100 / np.linalg.norm(np.ptp(points, axis=0))
    text = visit.page.locator(".view figcaption").nth(2).inner_text()
    for value in (np.percentile(errors, 95), errors.max()):
        assert f"{value:.3g}" in text


def test_the_kept_points_are_as_many_as_the_result_has(visit):
    visit.page.select_option("#view-points", "kept")
    visit.page.wait_for_function("view.keptOnly")
    assert visit.page.evaluate("shownEntries().slice(1).map(e => layersOf(e)[0].rows.length)") == [150, 150]


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


def test_a_row_of_the_table_opens_its_view(visit):
    visit.page.fill("#filter", "moved_points")
    visit.page.locator("#table .open[data-reduction='0.8']:visible").click()
    visit.drawn(4)
    assert visit.page.evaluate("[view.reduction, view.methods.at(-1)]") == [0.8, "moved_points"]


def test_a_picked_point_is_read_in_every_view(visit, plain_run):  # noqa: F811
    x, y = middle(visit.page, 1)
    visit.page.mouse.click(x, y)
    visit.page.wait_for_function("view.picked !== null")
    settle(visit.page)
    row = visit.page.evaluate("view.picked")
    said = visit.page.locator(".readout").all_inner_texts()
    with np.load(plain_run / "clouds" / "dented.npz") as file:
        points = file["points"]
    place = [float(word.strip(",")) for word in said[0].split()[1:4]]
    original = np.argmin(np.linalg.norm(points - place, axis=1))
    assert np.allclose(points[original], place, atol=1e-3)
    for name, text in zip(visit.page.evaluate("view.methods"), said[1:], strict=True):
        with np.load(plain_run / "clouds" / f"dented~{name}~0.9~s0.npz") as file:
            error = file["plane_errors"][original] * 100 / np.linalg.norm(np.ptp(points, axis=0))
            kept = original in file["indices"]
        assert float(text.split()[2]) == pytest.approx(error, rel=0.02, abs=1e-3)
        assert ("kept" in text) == kept
    turn = visit.page.evaluate("[...panels()[2].seen.turn]")
    assert turn == visit.page.evaluate("[...panels()[1].seen.turn]"), "marked at one place in all views"
    assert row < 1500


def test_two_results_in_one_view_swipe_and_blink(visit):
    visit.page.select_option("#view-layout", "swipe")
    visit.drawn(1)
    settle(visit.page)
    picture = "panels()[0].querySelector('canvas').toDataURL()"
    half = visit.page.evaluate(picture)
    visit.page.locator("#view-swipe").fill("0.9")
    visit.page.wait_for_function(f"asked === 0 && {picture} !== {json.dumps(half)}")
    visit.page.select_option("#view-layout", "blink")
    visit.page.wait_for_function("view.blink === 1 && asked === 0")
    first = visit.page.evaluate(picture)
    visit.page.wait_for_function(f"view.blink === 0 && asked === 0 && {picture} !== {json.dumps(first)}")
    visit.page.select_option("#view-layout", "side")
    visit.drawn(3)


def test_the_address_holds_what_is_shown(visit, browser, path):
    page = visit.page
    page.select_option("#view-colour", "height")
    page.select_option("#view-points", "kept")
    page.locator("#view-methods button", has_text="moved_points").click()
    page.locator("#view-grid canvas").first.focus()
    page.keyboard.press("ArrowRight")
    page.fill("#filter", "first")
    page.locator("#table th[data-key=runtime_s] button").click()
    page.select_option("#chart-measure", "hausdorff_pct")
    settle(page)
    shown = """[view.colour, view.keptOnly, view.methods.join(), byId("filter").value, byId("chart-measure").value,
      document.querySelector("#table th[aria-sort]").dataset.key,
      ...[camera.yaw, camera.pitch, camera.distance].map(c => c.toFixed(3))]"""
    there = page.evaluate(shown)
    again = Visit(browser, path, fragment=page.evaluate("location.hash")).drawn(4)
    assert again.page.evaluate(shown) == there
    assert column(again.page, "method") == column(page, "method")
    again.context.close()
    page.select_option("#chart-measure", "plane_error_pct")


@pytest.mark.parametrize(
    "fragment",
    ["#views=<img src=x>&colour=nothing&ends=a,b&camera=1,2&picked=9999999&model=none", "#removed=7"],
)
def test_an_address_of_nonsense_shows_the_page(browser, path, fragment):
    visit = Visit(browser, path, fragment=fragment).drawn(3)
    assert not visit.complaints
    visit.context.close()


def saved(page, act):
    with page.expect_download() as waiting:
        act()
    return Path(waiting.value.path()).read_bytes()


def test_picture_table_cloud_and_reference_are_saved(visit, plain_run):  # noqa: F811
    page = visit.page
    assert saved(page, lambda: page.click("#save-picture")).startswith(b"\x89PNG")
    page.fill("#filter", "first_rows")
    rows = list(csv.DictReader(saved(page, lambda: page.click("#save-table")).decode().splitlines()))
    assert [row["method"] for row in rows] == ["first_rows", "first_rows"]
    assert float(rows[0]["plane_error_pct"]) > 0
    page.locator("#view-methods button", has_text="random_sample").click()
    ply = saved(page, lambda: page.click("#save-cloud"))
    head, _, body = ply.partition(b"end_header\n")
    assert b"element vertex 150" in head
    with np.load(plain_run / "clouds" / "dented~first_rows~0.9~s0.npz") as file:
        kept = file["points"]
    found = np.frombuffer(body).reshape(-1, 3)
    order, other = np.lexsort(found.round(3).T), np.lexsort(kept.round(3).T)
    assert np.allclose(np.sort(found, axis=0), np.sort(kept, axis=0), atol=1e-4), (order[:3], other[:3])
    page.fill("#filter", "")
    entry = saved(page, page.locator("#table .cite").first.click).decode()
    assert entry.startswith("@misc{random_sample,")


def test_charts_follow_measure_reference_and_legend(visit):
    visit.page.evaluate("drawCharts()")
    visit.page.select_option("#chart-measure", "hausdorff_pct")
    visit.page.wait_for_function("byId('chart-count')._fullLayout?.yaxis.title.text.includes('Hausdorff')")
    visit.page.select_option("#chart-reference", "first_rows")
    visit.page.wait_for_function(
        "byId('chart-ratio').data.some(t => t.name === 'first_rows' && t.x.every(v => v === 1))"
    )
    visit.page.locator("#chart-legend button", has_text="first_rows").click()
    visit.page.wait_for_function("!byId('chart-count').data.some(t => t.name === 'first_rows')")
    visit.page.locator("#chart-legend button", has_text="first_rows").click()


def test_better_is_up_whichever_way_a_measure_goes(visit):
    visit.page.evaluate("drawCharts()")
    visit.page.select_option("#chart-measure", "plane_error_pct")
    range_of = "byId('chart-runtime')._fullLayout.yaxis.range"
    visit.page.wait_for_function(
        "byId('chart-runtime')._fullLayout?.yaxis.title.text.includes('better is up')"
    )
    low, high = visit.page.evaluate(range_of)
    assert low > high, "the smallest error is on top"
    axis = visit.page.evaluate("measureAxis('plane_error_pct', [1, 2, 4], 100)")
    assert axis["autorange"] == "reversed"
    visit.page.evaluate("page.headings.made_db = { label: 'PSNR [dB]', unit: 'dB', better: 'higher' }")
    decibels = visit.page.evaluate("measureAxis('made_db', [10, 40, 80], 100)")
    assert "autorange" not in decibels
    assert "type" not in decibels, "decibels are logarithms already"


def test_one_reduction_has_no_chart_against_the_count_and_one_method_no_front(browser, tmp_path):
    made = MadeRun(tmp_path / "run")
    made.model("m", dented_sphere(300))
    made.case("m", "random_sample", 0.9)
    visit = Visit(browser, write_page(made.write())).drawn(2)
    visit.page.evaluate("drawCharts()")
    visit.page.wait_for_selector("#charts[data-drawn]")
    assert visit.page.locator("#chart-count").count() == 0
    assert not visit.page.locator("#chart-front").is_visible()
    visit.context.close()


def test_pointing_at_a_method_in_the_legend_picks_it_out(visit):
    visit.page.evaluate("drawCharts()")
    opacities = "byId('chart-count').data.map(t => [t.name, t.opacity])"
    visit.page.wait_for_function("byId('chart-count').data?.length")
    visit.page.mouse.move(0, 0)
    visit.page.locator("#chart-legend button", has_text="first_rows").hover()
    visit.page.wait_for_function("byId('chart-count').data.some(t => t.opacity < 1)")
    assert [name for name, opacity in visit.page.evaluate(opacities) if opacity == 1] == ["first_rows"]
    visit.page.mouse.move(0, 0)
    visit.page.wait_for_function("byId('chart-count').data.every(t => t.opacity === 1)")


def test_perturbations_are_drawn_per_kind_and_the_note_names_what_never_saw_outliers(
    browser,
    plain_run,  # noqa: F811
    tmp_path,
):
    run = json.loads((plain_run / "run.json").read_text(encoding="utf-8"))
    kinds = [("noise", 0.5), ("noise", 1.0), ("outliers", 0.1)]
    run["records"] += [
        row | {"perturbation": kind, "perturbation_level": level, "needs_mesh": row["method"] == "first_rows"}
        for row in run["records"]
        for kind, level in kinds
    ]
    (tmp_path / "run.json").write_text(json.dumps(run), encoding="utf-8")
    path = write_page(tmp_path)
    visit = Visit(browser, path)
    visit.page.evaluate("drawCharts()")
    visit.page.wait_for_function("byId('perturbation-noise').data")
    drawn = "byId('perturbation-noise').data.map(t => [t.name, ...t.x])"
    assert [0, 0.5, 1] in [curve[1:] for curve in visit.page.evaluate(drawn)]
    assert len(visit.page.evaluate(drawn)) == 3
    assert "needs the mesh (first_rows) never sees them" in visit.page.inner_text("#perturbations .note")
    visit.page.click("#chart-legend button[data-method=first_rows]")
    visit.page.wait_for_function(f"{drawn}.length === 2")
    visit.page.select_option("#perturbation-reduction", "0.8")
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


def test_paper_is_light_and_holds_the_views_and_every_chart(browser, path):
    visit = Visit(browser, path, color_scheme="dark").drawn(3)
    assert len(visit.page.pdf()) > 50_000
    visit.page.wait_for_selector("#charts[data-drawn]", state="attached")
    assert visit.page.locator("#charts .plot-container").count() == 4
    visit.page.emulate_media(media="print", color_scheme="dark")
    assert visit.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert colours(visit.page, 1) > 20, "a blank picture has one colour"
    visit.context.close()


def test_a_phone_needs_no_sideways_scrolling(browser, path):
    visit = Visit(
        browser, path, viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True
    ).drawn(3)
    assert visit.page.evaluate("document.documentElement.scrollWidth") <= 390
    visit.context.close()


def test_without_webgl_a_picture_is_shown(browser, path):
    no_webgl = """
      const { getContext } = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind === "webgl2" ? null : getContext.call(this, kind, ...rest);
      };"""
    visit = Visit(browser, path, no_webgl)
    visit.page.wait_for_load_state()
    still = visit.page.locator("#view-still img")
    assert still.is_visible()
    assert "first_rows (plane error" in still.get_attribute("alt")
    assert not visit.page.locator("#view-live").is_visible()
    visit.page.locator("#table th[data-key=runtime_s] button").click()
    assert column(visit.page, "runtime_s")[-1] == "–", "the rest of the page works"
    assert visit.quiet(path), (visit.complaints, visit.requests)
    visit.context.close()


def test_without_javascript_a_sentence_says_so_and_the_numbers_are_there(browser, path):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(path.as_uri())
    text = page.inner_text("body")
    assert "This page needs JavaScript" in text
    assert "has the lowest plane error" in text
    assert "SIGABRT" in text
    assert page.locator("#view-still img").is_visible()
    assert page.locator("#table thead th").count() <= 11, "a reader of the text alone meets the main measures"
    context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_serious_fault(browser, path, scheme):
    found = find_spec("axe_playwright_python")
    if found is None:
        pytest.skip("axe-playwright-python is not installed")
    visit = Visit(browser, path, color_scheme=scheme).drawn(3)
    visit.page.evaluate("drawCharts()")
    visit.page.wait_for_selector("#charts[data-drawn]")
    visit.page.evaluate(Path(found.origin).with_name("axe.min.js").read_text(encoding="utf-8"))
    faults = visit.page.evaluate("axe.run().then(found => found.violations)")
    serious = [f for f in faults if f["impact"] in ("serious", "critical")]
    assert not serious, [(f["id"], [n["html"][:120] for n in f["nodes"][:3]]) for f in serious]
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
    visit.page.wait_for_selector("#charts[data-drawn]")
    assert visit.page.title() != "caught"
    assert visit.page.locator("main img:not(#view-still img)").count() == 0
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
    cloud = PointCloud(points, colors=np.ones((300, 4)), attributes={"heat": points[:, 2]}, name="one")
    path = write_view(cloud, tmp_path / "view.html")
    visit = Visit(browser, path).drawn(1)
    visit.page.select_option("#view-colour", "heat")
    visit.page.wait_for_function("Math.abs(scaleEnds()[1] - 1.1) < 0.1")
    assert visit.quiet(path), (visit.complaints, visit.requests)
    visit.context.close()


def test_a_served_page_asks_for_a_result_when_it_is_shown(browser, plain_run):  # noqa: F811
    server = make_server(load_run(plain_run))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}/"
    context = browser.new_context()
    page = context.new_page()
    asked, complaints = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("console", lambda message: complaints.append(message.text))
    page.goto(address)
    page.wait_for_function("document.getElementById('view-grid').dataset.drawn === '3'")
    before = len(asked)
    assert sum("/result/" in url for url in asked) == 2
    page.locator("#view-methods button", has_text="moved_points").click()
    page.wait_for_function("document.getElementById('view-grid').dataset.drawn === '4'")
    assert len(asked) == before + 1
    assert all(url.startswith(address) for url in asked)
    assert not [text for text in complaints if "favicon" not in text], complaints
    context.close()
    server.shutdown()
    server.server_close()


def test_a_server_answers_only_to_its_own_name_and_only_with_results(plain_run):  # noqa: F811
    with make_server(load_run(plain_run)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()

        def status(path, host="127.0.0.1"):
            link = HTTPConnection("127.0.0.1", server.server_port)
            link.request("GET", path, headers={"Host": f"{host}:{server.server_port}"})
            found = link.getresponse().status
            link.close()
            return found

        assert status("/") == 200
        assert status("/result/0/0") == 200
        assert status("/", "evil.example") == 403
        assert [status(p) for p in ("/result/0/99", "/result/9/0", "/../run.json", "/x")] == [404] * 4
        server.shutdown()
