"""MeshLab filter scripts (.mlx) that mix MeshLab's filters with those of lpcompare.

A MeshSet records the filters of MeshLab that were applied to it. Ours are noted beside it, each with its
place in that record, and both are put together when a script is saved.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from lpcompare.files import whole_file
from lpcompare.mesh_library import pymeshlab
from lpcompare.meshlab.layers import ATTRIBUTE_NAMES

if TYPE_CHECKING:
    from lpcompare.meshlab.filters import Filter

_NEW_ATTRIBUTE = "Define New Per Vertex Custom"
_ORDER = ("type", "name", "value", "min", "max", "description", "tooltip")
_HEADER = b"<!DOCTYPE FilterScript>\n"


@dataclass(frozen=True)
class _Entry:
    """One of our filters as it was applied.

    MeshLab's records ``start`` to ``end`` are steps that it took itself; ``before`` is what the record held
    up to ``end``, so that a record that was cleared or replaced since is noticed.
    """

    start: int
    end: int
    before: tuple[str, ...]
    element: str


_JOURNAL: WeakKeyDictionary[Any, list[_Entry]] = WeakKeyDictionary()
_LOCK = Lock()


@contextmanager
def recorded(layers: Any, filter_: Filter, values: Mapping[str, Any]) -> Iterator[None]:
    """Note a filter of ours when the block has ended well."""
    before = _native(layers)
    ATTRIBUTE_NAMES.update(_new_attributes(before))
    yield
    after = _native(layers)
    entry = _Entry(len(before), len(after), tuple(after), _element(filter_, values))
    with _LOCK:
        _JOURNAL.setdefault(layers, []).append(entry)


def save_filter_script(layers: Any, path: str | Path) -> None:
    """Write the filters that were applied to a MeshSet, MeshLab's and ours, in their order.

    Parameters
    ----------
    layers : pymeshlab.MeshSet
    path : str or path
        The .mlx file. MeshLab itself reads it too if it holds no filter of lpcompare.
    """
    with whole_file(Path(path)) as part:
        part.write_bytes(_document(_mixed(layers)))


def apply_filter_script(layers: Any, path: str | Path) -> None:
    """Load a filter script and apply it: MeshLab's filters by MeshLab, ours by lpcompare.

    Parameters
    ----------
    layers : pymeshlab.MeshSet
        Its current script becomes the loaded one.
    path : str or path
        An .mlx file.

    Raises
    ------
    pymeshlab.PyMeshLabException
        The file is no filter script, or a filter cannot be applied.
    """
    from lpcompare.meshlab.application import apply_filter
    from lpcompare.meshlab.filters import FILTERS

    elements = _read(Path(path))
    for ours, group in groupby(elements, key=lambda e: e.get("name") in FILTERS):
        batch = list(group)
        if ours:
            for element in batch:
                filter_ = FILTERS[element.get("name", "")]
                apply_filter(layers, filter_.name, **_values(filter_, element))
        else:
            _apply_native(layers, [_text(element) for element in batch], path)
    _adopt(layers, elements, set(FILTERS))


def clear_filter_script(layers: Any) -> None:
    """Forget the filters that were applied so far, MeshLab's and ours."""
    layers.clear_filter_script()
    with _LOCK:
        _JOURNAL.pop(layers, None)


def _mixed(layers: Any) -> list[str]:
    """MeshLab's record with our filters in place of the steps that they took."""
    native, mixed, position = _native(layers), list[str](), 0
    with _LOCK:
        entries = list(_JOURNAL.get(layers, ()))
    for entry in entries:
        if tuple(native[: entry.end]) == entry.before and entry.start >= position:
            mixed += [*native[position : entry.start], entry.element]
            position = entry.end
    return mixed + native[position:]


def _adopt(layers: Any, elements: list[ET.Element], ours: set[str]) -> None:
    """Make a script the current one of a MeshSet."""
    native: list[str] = []
    entries = []
    for element in elements:
        text = _text(element)
        if element.get("name") in ours:
            entries.append((len(native), text))
        else:
            native.append(text)
    _load(layers, native)
    held = _native(layers)
    with _LOCK:
        _JOURNAL[layers] = [_Entry(at, at, tuple(held[:at]), text) for at, text in entries]


def _native(layers: Any) -> list[str]:
    """MeshLab's own record of a MeshSet, one text per filter."""
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
        path = Path(folder) / "record.mlx"
        layers.save_filter_script(str(path))
        return [_text(element) for element in _read(path)]


def _apply_native(layers: Any, elements: list[str], path: str | Path) -> None:
    refusal = pymeshlab().PyMeshLabException
    try:
        _load(layers, elements)
        layers.apply_filter_script()
    except refusal as error:
        names = "', '".join(ET.fromstring(text).get("name", "") for text in elements)
        raise refusal(
            f"Failed to apply filter script: {path}\nDetails: MeshLab refused '{names}': {error}"
        ) from error


def _text(element: ET.Element) -> str:
    """A filter of a script; MeshLab writes the fields of a parameter in an order of chance."""
    for param in element:
        ordered = {key: param.attrib[key] for key in _ORDER if key in param.attrib}
        rest = dict(sorted(param.attrib.items()))
        param.attrib.clear()
        param.attrib.update(ordered | rest)
    ET.indent(element, " ", level=1)
    return ET.tostring(element, encoding="unicode").strip()


def _new_attributes(native: list[str]) -> Iterator[str]:
    """Names of the custom attributes that filters of MeshLab have defined."""
    for text in native:
        element = ET.fromstring(text)
        if element.get("name", "").startswith(_NEW_ATTRIBUTE):
            yield from (p.get("value", "") for p in element if p.get("name") == "name")


def _load(layers: Any, elements: list[str]) -> None:
    layers.clear_filter_script()
    if elements:
        with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
            path = Path(folder) / "script.mlx"
            path.write_bytes(_document(elements))
            layers.load_filter_script(str(path))


def _read(path: Path) -> list[ET.Element]:
    """The filters of a script; anything else is a `pymeshlab.PyMeshLabException`."""
    refusal = pymeshlab().PyMeshLabException
    try:
        root = ET.fromstring(path.read_bytes())
    except OSError as error:
        raise refusal(f"Failed to load filter script: {path}\nDetails: {error.strerror}.") from error
    except ET.ParseError as error:
        raise refusal(f"Failed to load filter script: {path}\nDetails: not XML, {error}.") from error
    if root.tag != "FilterScript":
        raise refusal(f"Failed to load filter script: {path}\nDetails: it holds <{root.tag}>.")
    return list(root)


def _document(elements: list[str]) -> bytes:
    body = "".join(f" {element.strip()}\n" for element in elements)
    return _HEADER + f"<FilterScript>\n{body}</FilterScript>\n".encode()


def _element(filter_: Filter, values: Mapping[str, Any]) -> str:
    element = ET.Element("filter", name=filter_.name)
    for parameter in filter_.parameters:
        text = parameter.written(values[parameter.name])
        ET.SubElement(element, "Param", type=parameter.rich_type, name=parameter.name, value=text)
    return _text(element)


def _values(filter_: Filter, element: ET.Element) -> dict[str, Any]:
    """Parameters of a script's entry; `apply_filter` checks them."""
    known = {parameter.name: parameter for parameter in filter_.parameters}
    texts = {param.get("name", ""): param.get("value", "") for param in element}
    return {name: known[name].parsed(text) if name in known else text for name, text in texts.items()}
