"""What mkdocs does here beside its plugins: pages from outside docs/, their links, and formulas without scripts."""

from __future__ import annotations

import html
import json
import os
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent
OUTSIDE = ("CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE", "reports/README.md", "reports/*.py")
IN_REPORTS = ("README.md", "*.png", "*.svg", "*.csv", "*.json", "*.toml", "*.py")
LIVE = max(ROOT.glob("reports/local/*bunny*/report.html"), default=None)
"""The page of the last run of the main job; a build without one has no such page."""

LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#)([^)#\s]+)")
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_files(files: Any, config: Any) -> Any:
    """Add the reports and the texts of the root to the pages of docs/."""
    patterns = [*OUTSIDE, *(f"reports/*/{pattern}" for pattern in IN_REPORTS)]
    for path in sorted({p for pattern in patterns for p in ROOT.glob(pattern)}):
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith("reports/local/"):
            files.append(File.generated(config, name, abs_src_path=str(path)))
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        files.append(File.generated(config, f"notebooks/{path.stem}.md", content=notebook_page(path)))
    if LIVE:
        files.append(File.generated(config, "live/report.html", abs_src_path=str(LIVE)))
    return files


def notebook_page(path: Path) -> str:
    """A notebook as Markdown: texts, code, and what the code said and drew."""
    lines = [f"[This page as a notebook]({path.name}), for `jupyter lab` (`pip install jupyterlab`).", ""]
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        lines += [text, ""] if cell["cell_type"] == "markdown" else ["```python", text, "```", ""]
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            said = "".join(output.get("text", []) or data.get("text/plain", []))
            drawn = f"![What the code draws](data:image/png;base64,{data.get('image/png', '').strip()})"
            lines += [drawn, ""] if "image/png" in data else ["```text", said.rstrip(), "```", ""]
    title = lines.pop(2)
    return "\n".join([title, "", *lines])


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links as they are right in the repository become links that are right in the site."""
    if "<!-- live report -->" in markdown and LIVE:
        link = "[Open the bunny's page](live/report.html): turn, zoom, sort."
        markdown = markdown.replace("<!-- live report -->", link)
    if page.parent is None:
        page.meta["hide"] = ["navigation"]
    source = page.file.abs_src_path or ROOT / "docs" / page.file.src_uri
    folder = Path(source).relative_to(ROOT).parent

    def moved(link: re.Match[str]) -> str:
        target = os.path.normpath(folder / link[1]).removeprefix("docs/")
        target = "index.md" if target == "README.md" else target
        return os.path.relpath(target, Path(page.file.src_uri).parent)

    return LINK.sub(moved, markdown)


def on_page_content(content: str, **_: Any) -> str:
    """Formulas become MathML, which browsers draw without a script."""

    def drawn(found: re.Match[str]) -> str:
        return convert(html.unescape(found[3]), display="inline" if found[2] == "(" else "block")

    return FORMULA.sub(drawn, content)


def on_post_page(output: str, **_: Any) -> str:
    """The theme's search dialog gets a name, for those who listen to a page."""
    return output.replace(
        'data-md-component="search" role="dialog"',
        'data-md-component="search" role="dialog" aria-label="Search"',
    )
