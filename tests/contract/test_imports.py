"""Imports point one way: the table of CONTRIBUTING.md, enforced on every source file."""

import ast
from importlib.util import find_spec
from pathlib import Path

import pytest

CORE = {"types", "errors"}
ALLOWED = {
    "types": set(),
    "errors": set(),
    "threads": CORE,
    "progress": CORE,
    "files": CORE,
    "processes": CORE,
    "checks": CORE,
    "geometry": CORE | {"threads"},
    "mesh_library": CORE,
    "io": CORE | {"mesh_library", "files", "processes", "checks", "interplay"},
    "max_error": CORE | {"geometry", "metrics", "checks"},
    "paper": CORE | {"geometry", "threads", "checks", "progress"},
    "uniform": CORE | {"geometry", "threads", "checks", "progress", "paper"},
    "estimators": CORE | {"checks", "paper", "uniform"},
    "methods": CORE | {"progress", "geometry", "paper", "uniform"},
    "listing": CORE | {"registry", "models"},
    "testing": CORE | {"registry"},
    "interplay": CORE | {"checks"},
    "simplify": CORE | {"checks", "geometry", "interplay", "max_error", "registry", "benchmark"},
    "large": CORE
    | {"checks", "files", "geometry", "io", "paper", "processes", "progress", "registry", "threads"}
    | {"tiles", "uniform"},
    "tiles": CORE | {"checks", "files", "geometry", "io", "progress"},
    "baselines": CORE | {"mesh_library", "geometry"},
    "metrics": CORE | {"checks", "interplay", "mesh_library", "geometry", "registry"},
    "models": CORE | {"mesh_library", "geometry", "io"},
    "registry": CORE | {"checks"},
    "benchmark": CORE
    | {
        "checks",
        "interplay",
        "geometry",
        "threads",
        "files",
        "io",
        "registry",
        "models",
        "metrics",
        "uniform",
        "report",
        "processes",
    },
    "report": CORE | {"mesh_library", "files", "geometry", "io", "metrics", "registry", "benchmark"},
    "meshlab": CORE | {"files", "simplify", "mesh_library", "io", "geometry", "paper", "uniform", "metrics"},
}


def sources():
    for package, room in (("lpcompare", ""), ("lpcompare_baselines", "baselines")):
        root = Path(find_spec(package).origin).parent
        for path in sorted(root.rglob("*.py")):
            first = path.relative_to(root).parts[0]
            yield pytest.param(
                path, room or first.removesuffix(".py"), id=f"{package}/{path.relative_to(root)}"
            )


def imported(path):
    """Dotted names of every import of a file, TYPE_CHECKING ones left out."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    guarded = {
        n
        for g in ast.walk(tree)
        if isinstance(g, ast.If) and "TYPE_CHECKING" in ast.unparse(g.test)
        for n in ast.walk(g)
    }
    for node in ast.walk(tree):
        if node in guarded:
            continue
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            base = node.module or ""
            yield from (f"{base}.{a.name}" for a in node.names) if base == "lpcompare" else (base,)


@pytest.mark.parametrize(("path", "room"), list(sources()))
def test_a_room_imports_only_the_rooms_below_it(path, room):
    if room in ("__init__", "__main__", "cli"):
        return
    assert room in ALLOWED, f"{path}: {room!r} has no line in the import table"
    used = {name.split(".")[1] for name in imported(path) if name.startswith("lpcompare.")}
    assert used - {room} <= ALLOWED[room]


@pytest.mark.parametrize(("path", "room"), list(sources()))
def test_pymeshlab_is_imported_through_the_one_room_that_explains_what_is_missing(path, room):
    assert room == "mesh_library" or "pymeshlab" not in {name.split(".")[0] for name in imported(path)}


@pytest.mark.parametrize(("path", "room"), list(sources()))
def test_only_the_command_line_prints(path, room):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    prints = [n.lineno for n in ast.walk(tree) if isinstance(n, ast.Call) and ast.unparse(n.func) == "print"]
    assert room == "cli" or not prints
