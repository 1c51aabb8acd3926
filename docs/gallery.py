"""Make the pictures of the README and of docs/ again, from one run: ``python docs/gallery.py RUN``.

RUN is the folder of ``lpcompare run --model bunny``. It needs Chromium, playwright and ``pdftoppm`` (poppler-utils).
The pictures of a study are made by its own script under reports/.
"""

from __future__ import annotations

import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

from PIL import Image, ImageDraw, ImageFont
from playwright.sync_api import Browser, Page, sync_playwright

from lpcompare.report.page import write_page

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
WEBGL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
NO_WEBGL = "HTMLCanvasElement.prototype.getContext = () => null;"
DRAWN = "#view-grid[data-drawn]"
DESKTOP, LAPTOP, PHONE = (
    {"width": 1600, "height": 1000},
    {"width": 1280, "height": 800},
    {"width": 390, "height": 844},
)
SWIPE = "#views=poisson_disk,lp_uniform&layout=swipe&full=0"
Shot = tuple[str, str, dict[str, object]]
SHOTS: list[Shot] = [
    ("desktop, light", "", {"viewport": DESKTOP}),
    ("laptop, dark", "", {"viewport": LAPTOP, "color_scheme": "dark"}),
    ("one view fills the window, swipe", SWIPE, {"viewport": LAPTOP}),
    ("without WebGL", "", {"viewport": LAPTOP}),
    ("without JavaScript", "", {"viewport": LAPTOP, "java_script_enabled": False}),
    ("phone, light", "", {"viewport": PHONE, "has_touch": True}),
    ("phone, dark", "", {"viewport": PHONE, "has_touch": True, "color_scheme": "dark"}),
]
HEIGHT, GAP, TITLE = 430, 12, 24


def shoot(browser: Browser, page: Path, shot: Shot, out: Path) -> None:
    """One screen of the page; on a phone, from the views on."""
    name, fragment, options = shot
    tab = browser.new_context(**options).new_page()  # type: ignore[arg-type]
    if name == "without WebGL":
        tab.add_init_script(NO_WEBGL)
    tab.goto(page.as_uri() + fragment)
    if not name.startswith("without"):
        _settle(tab)
    if name.startswith("phone"):
        tab.evaluate("document.getElementById('views').scrollIntoView()")
    tab.screenshot(path=out)
    tab.context.close()


def shoot_report(browser: Browser, page: Path) -> None:
    """The page from its top, for the site."""
    tab = browser.new_page(viewport={"width": 1240, "height": 1200})
    tab.goto(page.as_uri())
    _settle(tab)
    tab.screenshot(path=IMAGES / "report.png")
    _shrink(Image.open(IMAGES / "report.png"), IMAGES / "report.png")


def print_pages(browser: Browser, page: Path, folder: Path) -> list[tuple[str, Path]]:
    """The first pages on paper."""
    tab = browser.new_page()
    tab.goto(page.as_uri())
    _settle(tab)
    tab.wait_for_selector("#charts[data-drawn]", state="attached", timeout=120_000)
    tab.pdf(path=folder / "print.pdf", format="A4")
    subprocess.run(["pdftoppm", "-r", "60", "-l", "4", "-png", "print.pdf", "print"], cwd=folder, check=True)
    return [(f"print, page {i}", path) for i, path in enumerate(sorted(folder.glob("print-*.png")), 1)]


def sheet(pictures: list[tuple[str, Path]], out: Path) -> None:
    """All screens at one height, in rows, each below its title."""
    scaled = [(name, _to_height(Image.open(path).convert("RGB"))) for name, path in pictures]
    whole = Image.new("RGB", (1420, 3000), "#87909c")
    pen, font = ImageDraw.Draw(whole), ImageFont.load_default(size=15)
    x = y = GAP
    for name, picture in scaled:
        if x + picture.width + GAP > whole.width:
            x, y = GAP, y + HEIGHT + TITLE + GAP
        pen.text((x, y), name, fill="white", font=font)
        whole.paste(picture, (x, y + TITLE))
        x += picture.width + GAP
    _shrink(whole.crop((0, 0, whole.width, y + TITLE + HEIGHT + GAP)), out)


def _settle(tab: Page) -> None:
    tab.wait_for_selector(DRAWN, state="attached", timeout=120_000)
    tab.wait_for_timeout(1500)


def _to_height(picture: Image.Image) -> Image.Image:
    return picture.resize((round(picture.width * HEIGHT / picture.height), HEIGHT), Image.Resampling.LANCZOS)


def _shrink(picture: Image.Image, out: Path) -> None:
    picture.convert("RGB").quantize(256).save(out, optimize=True)


def main(run: Path) -> None:
    """Make every picture."""
    other: Callable[..., None] = runpy.run_path(str(ROOT / "reports" / "pictures" / "draw.py"))["draw_bunny"]
    other(run, ROOT / "reports" / "pictures" / "bunny.png")
    runpy.run_path(str(IMAGES / "draw_metrics.py"), run_name="__main__")
    with TemporaryDirectory() as name, sync_playwright() as running:
        folder = Path(name)
        page = write_page(run, folder / "report.html").resolve()
        browser = running.chromium.launch(executable_path=which("chromium"), args=WEBGL)
        shoot_report(browser, page)
        pictures = [(shot[0], folder / f"{i}.png") for i, shot in enumerate(SHOTS)]
        for shot, (_, path) in zip(SHOTS, pictures, strict=True):
            shoot(browser, page, shot, path)
        sheet([*pictures, *print_pages(browser, page, folder)], IMAGES / "page-screens.png")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
