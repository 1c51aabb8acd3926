"""Plug-ins: found by file, read without being imported, added by other distributions."""

import sys

import pytest

from lpcompare.errors import InputError, Unavailable, UnknownName
from lpcompare.registry import METHODS, Registry
from lpcompare.types import Column, Traits

PLUG_IN = '''"""A method for this test.

More about it.
"""
import nosuchlibrary
from lpcompare.types import Column, Traits
TRAITS = Traits(wraps="nosuchlibrary.f", moves_points=True, requires=("nosuchlibrary",), extra="nosuch")
def shaky(points, target_count, *, rng, cloud, radius=2.0): ...
'''


@pytest.fixture
def registry(tmp_path, monkeypatch):
    folder = tmp_path / "shelf"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "_shared.py").touch()
    (folder / "shaky.py").write_text(PLUG_IN, encoding="utf-8")
    (folder / "bare.py").write_text('"""No traits."""\n', encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield Registry("method", ("shelf",))
    for name in [m for m in sys.modules if m.startswith("shelf")]:
        del sys.modules[name]


def test_files_are_names_and_underscored_files_are_not(registry):
    assert registry.names() == ("bare", "shaky")
    assert "shaky" in registry
    assert "_shared" not in registry


def test_summary_and_traits_are_read_without_importing(registry):
    assert registry.summary("shaky") == "A method for this test."
    assert registry.documentation("shaky").endswith("More about it.")
    assert registry.traits("shaky") == Traits(
        wraps="nosuchlibrary.f", moves_points=True, requires=("nosuchlibrary",), extra="nosuch"
    )
    assert "shelf.shaky" not in sys.modules


@pytest.mark.parametrize(
    ("table", "is_imported"),
    [
        ('{"depth": Column("m", "Depth", better="higher")}', False),
        ('{name: Column("m", "Depth", better="higher") for name in ("depth",)}', True),
        ('{"depth": Column("m", "De" + "pth", better="higher")}', True),
        ('{**{"depth": Column("m", "Depth", better="higher")}}', True),
    ],
)
def test_literal_columns_are_read_without_importing(tmp_path, monkeypatch, table, is_imported):
    (tmp_path / "gauges").mkdir()
    (tmp_path / "gauges" / "__init__.py").touch()
    text = f"from lpcompare.types import Column\nCOLUMNS = {table}\ndef sounding(comparison): ...\n"
    (tmp_path / "gauges" / "sounding.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("gauges", "gauges.sounding"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    metrics = Registry("metric", ("gauges",))
    assert metrics.columns("sounding") == {"depth": Column("m", "Depth", better="higher")}
    assert ("gauges.sounding" in sys.modules) is is_imported
    for name in ("gauges", "gauges.sounding"):
        sys.modules.pop(name, None)


def test_missing_library_is_said_with_the_line_that_installs_it(registry):
    sentence = registry.missing("shaky")
    assert sentence.startswith("nosuchlibrary is not installed.")
    assert "pip install 'lpcompare[nosuch]'" in sentence
    with pytest.raises(Unavailable, match="nosuchlibrary"):
        registry.get("shaky")


def test_a_file_without_traits_is_told_what_to_add(registry):
    with pytest.raises(InputError, match="TRAITS = Traits"):
        registry.traits("bare")


def test_unknown_name_lists_the_known(registry):
    with pytest.raises(UnknownName, match="bare, shaky"):
        registry.get("nosuch")


def test_another_distribution_adds_a_method_through_its_entry_point(tmp_path, monkeypatch):
    info = tmp_path / "guest-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: guest\nVersion: 1.0\n", encoding="utf-8")
    entry = "[lpcompare.methods]\nguest_method = guest_method:guest_method\n"
    (info / "entry_points.txt").write_text(entry, encoding="utf-8")
    text = PLUG_IN.replace("import nosuchlibrary\n", "").replace("def shaky", "def guest_method")
    (tmp_path / "guest_method.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    registry = Registry("method", (), "lpcompare.methods")
    assert "guest_method" in registry
    assert registry.summary("guest_method") == "A method for this test."
    assert registry.settings("guest_method") == {"radius": 2.0}
    del sys.modules["guest_method"]


def test_settings_are_the_keywords_beside_the_generator_and_the_cloud():
    assert METHODS.settings("random_sample") == {}
