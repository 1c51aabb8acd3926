"""Parameters of a filter in MeshLab's style: their types, their checks, their form in a filter script."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

from lpcompare.mesh_library import pymeshlab

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
    """

    name: str
    type: type
    default: Any
    doc: str
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    layer: bool = False

    @property
    def rich_type(self) -> str:
        """The type's name in a filter script."""
        return "RichMesh" if self.layer else _RICH[self.type]

    def checked(self, value: Any, layers: Any) -> Any:
        """The value in its own type; where it has none, pymeshlab's exception."""
        if self.choices:
            return self._choice(value)
        if self.layer:
            return self._layer(value, layers)
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
