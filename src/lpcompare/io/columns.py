"""Named columns of a file and the cloud that they are; what a format holds, and the cloud that fits into it.

Every format is read through `cloud_of` and written through `fitted`: what is a coordinate, a normal or a
colour, which types and names a format takes, and what is said of a loss, is decided here for all of them.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, count
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from lpcompare.io.rows import LONGEST_HEADER, Damaged
from lpcompare.types import PointCloud

_Column = TypeVar("_Column")

AXES, NORMALS, COLORS = ("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue", "alpha")
NUMBERS = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")

_AXIS_NAMES = (
    *("{a}", "{a}coord", "{a}coordinate", "coord{a}", "coordinate{a}", "coordinates{a}", "{a}pos", "pos{a}"),
    *(
        "{a}position",
        "position{a}",
        "point{a}",
        "points{a}",
        "cartesian{a}",
        "pointsmxyz{i}",
        "points{i}",
        "xyz{i}",
    ),
)
_NORMAL_NAMES = ("n{a}", "normal{a}", "normals{a}", "normal{i}", "normals{i}", "{a}normal")


def _trios(patterns: Iterable[str]) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(p.format(a=a, i=i) for i, a in enumerate("xyz")) for p in patterns)


_ROLES = {
    "points": (
        *_trios(_AXIS_NAMES),
        *(("easting", "northing", height) for height in ("height", "elevation", "altitude", "z")),
    ),
    "normals": (*_trios(_NORMAL_NAMES), ("normal_x", "normal_y", "normal_z")),
    "colors": (COLORS, ("r", "g", "b", "a"), ("rf", "gf", "bf", "af"), tuple(f"diffuse{c}" for c in COLORS)),
}


@dataclass(frozen=True)
class Holds:
    """What a format can hold beside coordinates.

    Attributes
    ----------
    types : tuple of str
        NumPy types of an attribute; empty where there are none.
    normals, colors : str
        NumPy type of a normal's or a colour's channel, empty where there are none; integers span 0 to 1.
    alpha, faces : bool
        Whether colours have a fourth channel, whether triangles are kept.
    whole : bool
        Attributes of any type that are not lists, with any number of columns.
    vectors : bool
        Attributes with several columns; elsewhere each column is one attribute.
    unfit : str
        Regular expression of what a name cannot have; "_" stands in for it.
    longest : int
        Bytes of a name.
    reserved : tuple of str
        Names that mean something else.
    fields : mapping of str to (str, int, int)
        Attributes with a place of their own: NumPy type, smallest and largest value.
    only : tuple of str
        The only attributes that there are, where they are not free.
    most : int
        Attributes that there can be.
    """

    types: tuple[str, ...] = ()
    normals: str = ""
    colors: str = ""
    alpha: bool = True
    faces: bool = False
    whole: bool = False
    vectors: bool = False
    unfit: str = r"[^!-~]"
    longest: int = 200
    reserved: tuple[str, ...] = (*AXES, *NORMALS, *COLORS)
    fields: Mapping[str, tuple[str, int, int]] = field(default_factory=dict)
    only: tuple[str, ...] = ()
    most: int = 4000


def cloud_of(
    columns: Mapping[str, NDArray[Any]],
    stem: str,
    faces: NDArray[np.intp] | None = None,
    beside: Sequence[str] = (),
) -> PointCloud:
    """The cloud of named columns: coordinates, normals and colours by their names, the others as attributes.

    Parameters
    ----------
    columns : mapping of str to ndarray, each of shape (n, ...)
    stem : str
        The cloud's name.
    faces : ndarray of int, shape (f, 3), or None
    beside : sequence of str
        What the file has beside them.

    Raises
    ------
    Damaged
        No coordinates among the names, or no points.
    """
    roles = find_roles(name for name, values in columns.items() if values.ndim == 1)
    if "points" not in roles:
        names = ", ".join(map(repr, list(columns)[:20]))
        raise Damaged(
            f"none of its columns are named x, y and z, only {names or 'none'}; name the coordinates so"
        )
    wrong = {role: [n for n in names if columns[n].dtype.kind not in "iuf"] for role, names in roles.items()}
    if wrong["points"]:
        raise Damaged(f"its column {wrong['points'][0]!r} is not made of numbers")
    roles = {role: names for role, names in roles.items() if not wrong[role]}
    channels = {role: [columns[name] for name in names] for role, names in roles.items()}
    points = np.column_stack(channels["points"]).astype(np.float64)
    if not len(points):
        raise Damaged("it holds no points")
    used = {name for names in roles.values() for name in names}
    return PointCloud(
        points,
        normals=np.column_stack(channels["normals"]).astype(np.float64) if "normals" in roles else None,
        colors=fractions(*channels["colors"]) if "colors" in roles else None,
        attributes={name: _native(values) for name, values in columns.items() if name not in used},
        faces=faces,
        name=stem,
        beside=(*beside, *lost_digits(*channels["points"])),
    )


def lost_digits(*coordinates: NDArray[Any]) -> tuple[str, ...]:
    """What to say of coordinates, such as integers beyond 2**53, that are other ones as doubles."""
    wide = [values for values in coordinates if values.dtype.kind != "f" or values.dtype.itemsize > 8]
    same = all(exactly(values, np.float64) is not None for values in wide)
    return () if same else ("digits of its coordinates that a double does not hold",)


def find_roles(names: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Which of the names are "points", "normals" and "colors", the usual names before others.

    Raises
    ------
    Damaged
        A coordinate's name comes twice, so that it does not say which column is meant.
    """
    names = list(names)
    exact = {name: name for name in names}
    plain: dict[str, str] = {}
    for name in exact:
        key = re.sub(r"\[.*?\]|\(.*?\)|[\W_]", "", name.lower())
        plain[key] = "" if key in plain else name
    roles = {}
    for role, groups in _ROLES.items():
        for group, known in ((group, known) for known in (exact, plain) for group in groups):
            found = tuple(filter(None, map(known.get, group)))
            if len(found) >= 3 and all(map(known.get, group[:3])):
                roles[role] = found
                break
    if twice := [name for name in roles.get("points", ()) if names.count(name) > 1]:
        raise Damaged(f"it has more than one column {twice[0]!r}; name the others otherwise")
    return roles


def by_name(names: Iterable[str], columns: Iterable[_Column]) -> dict[str, _Column]:
    """The columns of a file by their names; a name that comes again is numbered.

    Raises
    ------
    Damaged
        As `find_roles`.
    """
    names, named = list(names), dict[str, _Column]()
    find_roles(names)
    for name, column in zip(names, columns, strict=True):
        named[free_name(name, named, longest=LONGEST_HEADER)] = column
    return named


def fractions(*channels: ArrayLike) -> NDArray[np.float64]:
    """Red, green, blue and alpha from 0 to 1, shape (n, 4), from channels of any scale.

    The scale follows from the type and from the largest value of the three colours in the whole file: bytes,
    16 bits, whole numbers up to 255 or 65535 in any type, or fractions.
    """
    colors = [np.asarray(channel) for channel in channels]
    scales = [_scale(np.column_stack(colors[:3]))] * 3 + [_scale(channel) for channel in colors[3:]]
    columns = [np.asarray(c, dtype=np.float64) / s for c, s in zip(colors, scales, strict=True)]
    return np.column_stack(columns if len(columns) > 3 else [*columns, np.ones(len(columns[0]))])


def with_bytes(columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """The columns with colours from 0 to 255 in that type, so that a dark cloud is not taken for fractions."""
    fits = {name: exactly(columns[name], np.uint8) for name in COLORS if name in columns}
    return columns | {name: fit for name, fit in fits.items() if fit is not None}


def columns_of(cloud: PointCloud, normals: Sequence[str] = NORMALS) -> dict[str, NDArray[Any]]:
    """The columns of a `fitted` cloud by the usual names; ``normals`` are those of the normals."""
    columns = dict(zip(AXES, cloud.points.T, strict=True))
    if cloud.normals is not None:
        columns |= dict(zip(normals, cloud.normals.T, strict=True))
    if cloud.colors is not None:
        columns |= dict(zip(COLORS, cloud.colors.T, strict=False))
    return columns | dict(cloud.attributes)


def records(columns: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
    """The columns as one array of records without gaps, in the byte order of files."""
    kinds = [(name, values.dtype.newbyteorder("<"), values.shape[1:]) for name, values in columns.items()]
    table = np.empty(len(next(iter(columns.values()))), kinds)
    for name, values in columns.items():
        table[name] = values
    return table


def fitted(cloud: PointCloud, holds: Holds, ending: str) -> tuple[PointCloud, tuple[str, ...]]:
    """The cloud as a format can hold it, and a note of each thing that is not as it was.

    Parameters
    ----------
    cloud : PointCloud
    holds : Holds
    ending : str
        The format's, for the notes.

    Returns
    -------
    PointCloud
        Names, types and columns as the format has them; colours in the format's own scale.
    tuple of str
        Empty where all was kept.
    """
    notes: list[str] = []
    held = {"normals": holds.normals, "colors": holds.colors, "attributes": holds.types, "faces": holds.faces}
    notes += [f"{thing} left out" for thing in cloud.beside]
    lost = [part for part in held if not held[part] and _has(cloud, part)]
    if lost:
        notes.append(f"{ending} holds no {' and no '.join(lost)}")
    normals = cloud.normals if holds.normals else None
    return PointCloud(
        np.asarray(np.ma.filled(cloud.points, np.nan), dtype=np.float64),
        normals=None if normals is None else _typed("normals", normals, (holds.normals,), notes),
        colors=_quantised(cloud.colors, holds, notes) if cloud.colors is not None and holds.colors else None,
        attributes=_attributes(cloud, holds, ending, notes) if holds.types else {},
        faces=cloud.faces if holds.faces else None,
        name=cloud.name,
    ), tuple(notes)


def _has(cloud: PointCloud, part: str) -> bool:
    value = getattr(cloud, part)
    return bool(value) if part == "attributes" else value is not None


def _attributes(cloud: PointCloud, holds: Holds, ending: str, notes: list[str]) -> dict[str, NDArray[Any]]:
    """The attributes with types, names and columns that the format has."""
    flat: dict[str, NDArray[Any]] = {}
    for name, values in cloud.attributes.items():
        array = _unmasked(name, values, notes)
        if holds.only and name not in holds.only:
            notes.append(f"attribute {name!r} is left out, {ending} holds only {' and '.join(holds.only)}")
        elif array.dtype.hasobject or (array.dtype.kind not in "biuf" and not holds.whole):
            kind = "lists" if array.dtype.hasobject else f"values of type {array.dtype}"
            notes.append(f"attribute {name!r} is left out, {ending} holds no {kind}")
        else:
            flat |= _split(name, array, holds, notes)
    return _placed(flat, holds, notes)


def _unmasked(name: str, values: NDArray[Any], notes: list[str]) -> NDArray[Any]:
    """The attribute as a plain array; masked numbers become NaN."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        notes.append(f"masked values of attribute {name!r} are NaN")
        return np.ma.filled(values.astype(np.float64), np.nan)
    return _native(np.asarray(values))


def _native(array: NDArray[Any]) -> NDArray[Any]:
    """The array in one piece and in this machine's byte order."""
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("="))


def _split(name: str, array: NDArray[Any], holds: Holds, notes: list[str]) -> dict[str, NDArray[Any]]:
    """The columns of an attribute one by one where the format has no others: name_0, name_1, ..."""
    if array.ndim == 1 or holds.whole or (holds.vectors and array.ndim == 2 and array.shape[1]):
        return {name: array}
    flat = array.reshape(len(array), -1)
    notes.append(f"attribute {name!r} is split into {flat.shape[1]} columns")
    return {f"{name}_{i}": column for i, column in enumerate(flat.T)}


def _placed(flat: Mapping[str, NDArray[Any]], holds: Holds, notes: list[str]) -> dict[str, NDArray[Any]]:
    """Each attribute in its field of the format if its values fit there, else under a name that is free."""
    clean = {name: _clean(name, holds) for name in flat}
    taken = {*holds.reserved, *holds.fields}
    while not holds.whole and (claimed := _claimed(set(clean.values()) - taken)):
        taken |= claimed
    placed: dict[str, NDArray[Any]] = {}
    if len(flat) > holds.most:
        first = list(flat)[holds.most]
        notes.append(f"the attributes from {first!r} on are left out, at most {holds.most} are held")
    for name, values in list(flat.items())[: holds.most]:
        own = name.lower().replace(" ", "_")
        fit = exactly(values, *holds.fields[own]) if own in holds.fields and own not in placed else None
        if fit is None:
            own = free_name(clean[name], taken, holds.longest)
            fit = values if holds.whole else _typed(f"attribute {name!r}", values, holds.types, notes)
        placed[own] = fit
        taken.add(own)
        if own != name:
            notes.append(f"attribute {name!r} is named {own!r}")
    return placed


def _clean(name: str, holds: Holds) -> str:
    """The name without what the format cannot spell."""
    return re.sub(holds.unfit, "_", name).encode("utf-8", "replace").decode() or "_"


def _claimed(names: Iterable[str]) -> set[str]:
    """Names that `cloud_of` would take for normals or colours."""
    return {n for found in find_roles([*AXES, *sorted(names)]).values() for n in found} - {*AXES}


def free_name(name: str, taken: Container[str], longest: int = 200) -> str:
    """The name, cut to its longest and numbered where it is taken."""
    endings = chain([""], map("_{}".format, count(2)))
    shorter = (name.encode()[: longest - len(end)].decode(errors="ignore") + end for end in endings)
    return next(new for new in shorter if new not in taken)


def _typed(what: str, values: NDArray[Any], types: Sequence[str], notes: list[str]) -> NDArray[Any]:
    """The values in their own type, or the next of the format's that holds each of them, or rounded."""
    kinds = sorted(map(np.dtype, types), key=lambda kind: (kind.kind != values.dtype.kind, kind.itemsize))
    for kind in (k for k in kinds if k.itemsize >= values.dtype.itemsize):
        if (fit := exactly(values, kind)) is not None:
            return fit
    widest = np.dtype(types[-1])
    if exactly(values, widest) is None:
        notes.append(f"{what} is rounded to {widest}")
    return values.astype(widest)


def exactly(
    values: NDArray[Any], kind: DTypeLike, low: int | None = None, high: int | None = None
) -> NDArray[Any] | None:
    """The values in another type, or None where one would change or is outside ``low`` .. ``high``."""
    kind = np.dtype(kind)
    if values.dtype == kind and low is None:
        return values
    if kind.kind in "iu":
        info = np.iinfo(kind)
        low, high = info.min if low is None else low, info.max if high is None else high
        whole = values.dtype.kind != "f" or bool((np.isfinite(values) & (values == np.rint(values))).all())
        return values.astype(kind) if whole and _within(values, low, high) else None
    if values.dtype.kind in "biu":
        largest = 2 ** (np.finfo(kind).nmant + 1)
        return values.astype(kind) if _within(values, -largest, largest) else None
    new = values.astype(kind)
    return new if np.array_equal(new.astype(values.dtype), values, equal_nan=True) else None


def _within(values: NDArray[Any], low: int, high: int) -> bool:
    return not values.size or (int(values.min()) >= low and int(values.max()) <= high)


def _quantised(colors: NDArray[np.float64], holds: Holds, notes: list[str]) -> NDArray[Any]:
    """Colours in the format's scale, with or without alpha."""
    kind, colors = np.dtype(holds.colors), np.asarray(np.ma.filled(colors, np.nan))
    if not holds.alpha and not np.array_equal(colors[:, 3:], np.ones_like(colors[:, 3:])):
        notes.append("the alpha of colors is left out")
    channels = colors if holds.alpha else colors[:, :3]
    if ((channels < 0) | (channels > 1)).any():
        notes.append("colors outside 0 to 1 are cut off")
        channels = np.clip(channels, 0, 1)
    if kind.kind == "f":
        return channels
    if unknown := int(np.isnan(channels).any(axis=1).sum()):
        notes.append(f"colors of {unknown} point{'s' * (unknown > 1)} are not known and become 0")
        channels = np.nan_to_num(channels)
    largest = np.iinfo(kind).max
    steps = np.rint(channels * largest)
    if not np.allclose(steps / largest, channels, rtol=0, atol=1e-9):
        notes.append(f"colors are rounded to {8 * kind.itemsize} bits")
    return steps.astype(kind)


def _scale(channels: NDArray[Any]) -> float:
    """The value that means 1."""
    largest = float(np.nanmax(channels, initial=0))
    if channels.dtype == np.uint8:
        return 255.0
    if channels.dtype.kind == "f" and (
        largest <= 1 or (largest < 2 and (channels != np.rint(channels)).any())
    ):
        return 1.0
    if largest > 65535 and channels.dtype.kind != "f":
        return float(np.iinfo(channels.dtype).max)
    return 255.0 if largest <= 255 else 65535.0
