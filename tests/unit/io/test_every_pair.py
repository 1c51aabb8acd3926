"""From every writable format to every other: each value comes back equal, or a note names what does not."""

import re
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from lpcompare.io import read, write
from lpcompare.types import PointCloud

FORMATS = (
    ".ply",
    ".obj",
    ".off",
    ".xyz",
    ".txt",
    ".asc",
    ".pts",
    ".csv",
    ".npy",
    ".npz",
    ".pcd",
    ".las",
    ".laz",
)
QUICK = settings(
    deadline=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8", "?")
ODD_NAMES = (
    *(
        "x",
        "X",
        "y",
        "points",
        "file",
        "normals",
        "faces",
        "a:b",
        "a/b",
        "a b",
        "..",
        "#",
        "%a",
        "=1+1",
        "_",
        "",
    ),
    *("red", "green", "blue", "r", "g", "b", "nx", "ny", "nz", "normal_x", "rgba", "intensity", "Intensity"),
    *(
        "return_number",
        "classification",
        "bit_fields",
        "gps_time",
        "Höhe",
        "高さ",
        "tab\tname",
        "new\nline",
        "nul\0",
    ),
    *(
        "'",
        '"',
        ",",
        ";",
        "name.npy",
        "columns",
        "column_4",
        "self",
        "allow_pickle",
        "\ud800",
        "a" * 300,
        "é" * 40,
    ),
)


@st.composite
def clouds(draw):
    """A cloud with an attribute of every type, at its ends and with NaN, under odd names."""
    n = draw(st.integers(4, 6))
    names = draw(
        st.lists(st.sampled_from(ODD_NAMES) | st.text(max_size=40), min_size=13, max_size=13, unique=True)
    )
    attributes = {names[0]: draw(hnp.arrays("f4", (n, 3), elements=st.floats(width=32)))}
    for name, kind in zip(names[1:], TYPES, strict=True):
        attributes[name] = draw(hnp.arrays(kind, n, elements=_at_the_ends(np.dtype(kind))))
    points = draw(hnp.arrays("f8", (n, 3), elements=st.floats(-1e7, 1e7)))
    colors = draw(st.none() | hnp.arrays("f8", (n, 4), elements=st.integers(0, 255).map(lambda v: v / 255)))
    normals = draw(st.none() | hnp.arrays("f8", (n, 3), elements=st.floats(-1, 1) | st.just(np.nan)))
    return PointCloud(
        points, normals, colors, attributes, draw(st.sampled_from([None, np.array([[0, 1, 2]])]))
    )


def _at_the_ends(kind):
    if kind.kind == "f":
        return st.floats(width=8 * kind.itemsize)
    if kind.kind == "b":
        return st.booleans()
    info = np.iinfo(kind)
    ends = [info.min, info.max, *(v for v in (2**53, 2**53 + 1, 255, 256) if v <= info.max)]
    return st.integers(info.min, info.max) | st.sampled_from(ends)


def same(first, second):
    """Whether two arrays hold the same numbers, whatever their types are; NaN equals NaN."""
    first, second = np.ravel(first).tolist(), np.ravel(second).tolist()
    return len(first) == len(second) and all(
        a == b or (np.isnan(a) and np.isnan(b)) for a, b in zip(first, second, strict=True)
    )


def check(before, after, notes, suffix):
    """Each part of a cloud is in the other, or a note names it."""
    said = "; ".join(notes)
    step = np.ptp(before.points, axis=0).max() * 10 / 2**31 if suffix in (".las", ".laz") else 0
    assert np.allclose(after.points, before.points, rtol=0, atol=max(step, 1e-9 * (step > 0)))
    for part in ("normals", "colors"):
        old, new = getattr(before, part), getattr(after, part)
        assert (
            old is None
            or part in said
            or (new is not None and np.allclose(old, new, rtol=0, atol=1e-9, equal_nan=True))
        )
        assert old is not None or new is None, "nothing becomes a normal or a colour"
    assert before.faces is None or "faces" in said or np.array_equal(after.faces, before.faces)
    for name, values in before.attributes.items():
        own = [note for note in notes if repr(name) in note or "attributes" in note]
        if not own:
            assert same(after.attributes[name], values), (name, notes)
        elif (new := re.fullmatch(r"attribute .* is named ('.*'|\".*\")", own[0], re.DOTALL)) and len(
            own
        ) == 1:
            assert same(after.attributes[eval(new[1])], values), (name, notes)


def there_and_back(cloud, path):
    notes = write(path, cloud)
    assert all("\n" not in note for note in notes)
    again = read(path)
    check(cloud, again, notes, path.suffix)
    return again


@pytest.mark.parametrize("suffix", FORMATS)
@settings(QUICK, max_examples=25)
@given(clouds())
def test_every_format_gives_back_what_it_took_or_says_what_it_did_not(suffix, cloud):
    with tempfile.TemporaryDirectory() as folder:
        there_and_back(cloud, Path(folder) / f"a{suffix}")


ALIKE = (".txt", ".asc")  # as .xyz
PAIRS = [
    pair
    for pair in product(FORMATS, FORMATS)
    if not set(pair) & {*ALIKE} and (".laz" not in pair or ".las" in pair or ".ply" in pair)
]


@pytest.mark.parametrize(("first", "second"), PAIRS)
@settings(QUICK, max_examples=2)
@given(clouds())
def test_every_pair_of_formats(first, second, cloud):
    with tempfile.TemporaryDirectory() as folder:
        again = there_and_back(cloud, Path(folder) / f"a{first}")
        there_and_back(again, Path(folder) / f"b{second}")
