"""The site: it builds without a warning, works from the disk without a network, and its search finds things."""

import subprocess
import sys
from pathlib import Path
from shutil import which

import pytest

ROOT = Path(__file__).resolve().parents[2]
SIZES = {"laptop": (1280, 800), "phone": (390, 844)}


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("material", reason="lpcompare[docs] is not installed")
    folder = tmp_path_factory.mktemp("site")
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if which("chromium") is None:
        pytest.skip("Chromium is not installed")
    with api.sync_playwright() as play:
        found = play.chromium.launch(executable_path=which("chromium"), args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture(params=SIZES)
def page(request, browser):
    """A page of one size that notes what a reader must not see: messages and requests to a network."""
    width, height = SIZES[request.param]
    page = browser.new_page(viewport={"width": width, "height": height})
    page.noted = []
    page.on("console", lambda message: page.noted.append(message.text))
    page.on("request", lambda r: page.noted.append(r.url) if r.url.startswith("http") else None)
    yield page
    page.close()


@pytest.mark.parametrize("page", ["phone"], indirect=True)
def test_every_page_fits_a_phone_and_asks_for_nothing(site, page):
    for path in sorted(site.rglob("*.html")):
        if path.parent.name != "live" and path.name != "404.html":
            page.goto(path.as_uri(), wait_until="domcontentloaded")
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), path.name
    assert not page.noted


@pytest.mark.parametrize("page", ["phone"], indirect=True)
def test_a_reader_who_listens_or_types_reaches_all_of_it(site, page):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed").Axe()
    for name in ("index", "which-method", "background/program", "reference/python"):
        page.goto((site / f"{name}.html").as_uri())
        page.wait_for_timeout(300)
        faults = axe.run(page).response["violations"]
        assert [f["id"] for f in faults if f["impact"] in ("serious", "critical")] == []


def test_search_works_from_the_disk(site, page):
    page.goto((site / "index.html").as_uri())
    if page.viewport_size["width"] < 1000:
        page.click("label.md-header__button[for=__search]")
    page.click("input.md-search__input")
    page.keyboard.type("certificate")
    page.wait_for_selector(".md-search-result__item a[href*='program']")
    assert not page.noted


def test_formulas_are_drawn_without_a_script(site, page):
    page.goto((site / "background" / "program.html").as_uri())
    assert page.locator("math mtable").count() == 2
    assert "\\" not in page.locator("article").inner_text()
