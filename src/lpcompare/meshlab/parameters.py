"""Parameters of a filter in MeshLab's style: their types, their checks, their form in a filter script."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

from lpcompare.mesh_library import pymeshlab

LENGTH = "PercentageValue"
_RICH = {int: "RichInt", float: "RichFloat", bool: "RichBool", str: "RichEnum"}


@dataclass(frozen=True)
class Parameter:
    """One parameter: lower-case, without underscores, keyword-only, as MeshLab's are.

    Attributes
    ----------
    name : str
    type : type
        int, float, bool, or str for one of ``choices``.
    default : Any
        None for a layer stands for the current one.
    doc : str
    low, high : float
        Allowed range of a number, both ends included.
    choices : tuple of str
        Of a choice, which may also be given by its number.
    layer : bool
        An int that is the id of a layer.
    length : bool
        A pymeshlab.PercentageValue of the bounding-box diagonal or a pymeshlab.PureValue; 0 or None: none.
    """

    name: str
    type: type
    default: Any
    doc: str
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    layer: bool = False
    length: bool = False

    @property
    def type_name(self) -> str:
        """The type's name in Python."""
        return LENGTH if self.length else self.type.__name__

    @property
    def rich_type(self) -> str:
        """The type's name in a filter script."""
        if self.length:
            return "RichAbsPerc"
        return "RichMesh" if self.layer else _RICH[self.type]

    def checked(self, value: Any, layers: Any) -> Any:
        """The value in its own type; where it has none, pymeshlab's exception."""
        if self.choices:
            return self._choice(value)
        if self.layer:
            return self._layer(value, layers)
        if self.length:
            return self._length(value)
        if self.type is bool:
            if isinstance(value, bool) or type(value).__name__ == "bool_":
                return bool(value)
            raise self._wrong(value, "a bool")
        kind = Integral if self.type is int else Real
        if isinstance(value, bool) or not isinstance(value, kind) or not math.isfinite(float(value)):
            raise self._wrong(value, "an int" if self.type is int else "a finite float")
        if not self.low <= float(value) <= self.high:
            raise self._wrong(value, f"from {self.low:g} to {self.high:g}".replace(" to inf", " up"))
        return int(value) if isinstance(value, Integral) and self.type is int else float(value)

    def parsed(self, text: str) -> Any:
        """The value of its text in a filter script, not yet checked."""
        if self.length:
            return _length_of(text)
        if self.type is bool:
            return {"true": True, "false": False}.get(text.lower(), text)
        try:
            return int(text) if self.type is int or self.choices else float(text)
        except ValueError:
            return text

    def written(self, value: Any) -> str:
        """The text of a value in a filter script; of a choice its number, as MeshLab writes it."""
        if self.choices:
            return str(self.choices.index(value))
        if self.length:
            percent = isinstance(value, pymeshlab().PercentageValue)
            return "0%" if value is None else f"{value.value()!r}{'%' if percent else ''}"
        return str(value).lower() if self.type is bool else repr(value)

    def _choice(self, value: Any) -> str:
        listed = "; ".join(f"'{choice}'" for choice in self.choices)
        if isinstance(value, str):
            if value in self.choices:
                return value
            raise pymeshlab().InvalidEnumException(
                f"Enum '{value}' not found. Possible values are {listed}; "
            )
        if isinstance(value, Integral) and not isinstance(value, bool):
            if 0 <= int(value) < len(self.choices):
                return self.choices[int(value)]
            last = len(self.choices) - 1
            raise pymeshlab().InvalidEnumException(
                f"Enum {value} not valid. Must be a value between 0 and {last}"
            )
        raise self._wrong(value, f"one of {listed}")

    def _length(self, value: Any) -> Any:
        known = pymeshlab()
        if value is not None and not isinstance(value, known.PercentageValue | known.PureValue):
            raise known.PyMeshLabException(
                f"Parameter {self.name}: must be a pymeshlab.PercentageValue object or a "
                "pymeshlab.PureValue object. Other type values are not accepted."
            )
        if value is not None and not 0 <= value.value() < math.inf:
            raise self._wrong(value.value(), "from 0 up")
        return value if value is not None and value.value() > 0 else None

    def _layer(self, value: Any, layers: Any) -> int:
        if value is None:
            return layers.current_mesh_id()
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise self._wrong(value, "the id of a mesh")
        if not layers.mesh_id_exists(int(value)):
            known = ", ".join(str(mesh.id()) for mesh in layers)
            raise self._wrong(value, f"the id of a mesh in the MeshSet ({known})")
        return int(value)

    def _wrong(self, value: Any, allowed: str) -> Exception:
        return pymeshlab().PyMeshLabException(
            f"Parameter {self.name}: must be {allowed}. {value!r} ({type(value).__name__}) is not accepted."
        )


SELECTED = Parameter("selected", bool, False, "Work on the selected vertices only.")


def _length_of(text: str) -> Any:
    """The length of its text, "2.5%" or "0.01"; other text as it is, for the check to refuse."""
    known = pymeshlab()
    try:
        return known.PercentageValue(float(text[:-1])) if text.endswith("%") else known.PureValue(float(text))
    except ValueError:
        return text
