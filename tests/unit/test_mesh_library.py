"""A missing system library is one sentence that names the package."""

import pytest

from lpcompare import mesh_library
from lpcompare.errors import Unavailable


@pytest.mark.parametrize(
    ("reason", "expected"),
    [
        ("libGL.so.1: cannot open shared object file: No such file or directory", "libgl1"),
        ("libfoo-2.0.so.3: cannot open shared object file", "the package that holds libfoo-2.0.so.3"),
        ("No module named 'pymeshlab'", "pip install pymeshlab"),
    ],
)
def test_the_sentence_names_what_to_install(monkeypatch, reason, expected):
    def fail(name):
        raise ImportError(reason)

    monkeypatch.setattr(mesh_library, "import_module", fail)
    with pytest.raises(Unavailable, match=expected):
        mesh_library.pymeshlab()
