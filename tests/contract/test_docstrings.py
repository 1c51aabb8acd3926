"""Every example of every docstring runs, and every public name says what its reader needs."""

import doctest
import inspect
import pkgutil
from importlib import import_module
from pathlib import Path

import pytest

import lpcompare
import lpcompare_baselines

PUBLIC = [name for name in lpcompare.__all__ if not name.startswith("_")]
FINDER = doctest.DocTestFinder(exclude_empty=True)


def modules():
    for package in (lpcompare, lpcompare_baselines):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            path = Path(found.module_finder.path, *[found.name.rpartition(".")[2]])
            file = path / "__init__.py" if found.ispkg else path.with_suffix(".py")
            if ">>>" in file.read_text(encoding="utf-8"):
                yield found.name


def examples(thing, name):
    return [example for test in FINDER.find(thing, name) for example in test.examples]


@pytest.mark.parametrize("name", list(modules()))
def test_the_examples_of_a_file_run(name):
    said = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for test in FINDER.find(import_module(name), name):
        runner.run(test, out=said.append)
    assert runner.tries > 0
    assert runner.failures == 0, "".join(said)


SOURCED = {"LPSimplifier", "UniformSimplifier", "evaluate", "simplify"}
"""Names that compute what a publication defines: they name it."""

CLOUDS = SOURCED | {"PointCloud", "Simplification", "read", "run", "write"}
"""Names that take or hold coordinates: they say shape and unit."""


def whole_text(thing):
    """The docstring, and those of the public methods of a class."""
    methods = (
        [getattr(thing, n) for n in dir(thing) if not n.startswith("_")] if inspect.isclass(thing) else []
    )
    return "\n".join(inspect.getdoc(t) or "" for t in (thing, *methods))


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_an_example(name):
    assert examples(getattr(lpcompare, name), name)


@pytest.mark.parametrize("name", PUBLIC)
def test_every_parameter_is_explained(name):
    thing = getattr(lpcompare, name)
    explained = {
        word.strip("* ")
        for line in inspect.getdoc(thing).splitlines()
        if not line.startswith("    ")
        for word in line.partition(" : ")[0].split(",")
    }
    assert set(inspect.signature(thing).parameters) - explained == set()


@pytest.mark.parametrize("name", [n for n in PUBLIC if inspect.isfunction(getattr(lpcompare, n))])
def test_a_function_says_what_it_returns_and_raises(name):
    thing = getattr(lpcompare, name)
    text = inspect.getdoc(thing)
    assert "Returns\n-------" in text
    assert "Raises\n------" in text or not inspect.signature(thing).parameters


@pytest.mark.parametrize("name", sorted(CLOUDS))
def test_shape_and_unit_are_said(name):
    text = whole_text(getattr(lpcompare, name))
    assert "(n, 3)" in text or "(m, 3)" in text
    assert "unit" in text


@pytest.mark.parametrize("name", sorted(SOURCED))
def test_the_source_is_named(name):
    text = inspect.getdoc(getattr(lpcompare, name))
    assert "References\n----------" in text
    assert "Leal" in text
