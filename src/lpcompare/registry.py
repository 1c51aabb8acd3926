"""Methods and metrics, found by file name and imported only when they are asked for.

A plug-in is one file that holds one public function of the file's name. Its one-line summary and its
`Traits` are read from the source text, so that a list of methods costs no import of a rival's library.
Packages outside lpcompare add methods through the entry point group ``lpcompare.methods``.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterator
from functools import cached_property
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from lpcompare.errors import InputError, Unavailable, UnknownName
from lpcompare.types import Traits

_RESERVED = frozenset({"rng", "cloud"})
_NO_PLUGINS = frozenset({"comparison"})


class Registry:
    """The plug-ins of one kind.

    Parameters
    ----------
    kind : str
        "method" or "metric", for messages.
    packages : tuple of str
        Packages whose files are plug-ins; names that begin with an underscore are not.
    group : str, optional
        Entry point group that adds plug-ins from other distributions.
    """

    def __init__(self, kind: str, packages: tuple[str, ...], group: str = "") -> None:
        self.kind = kind
        self._packages = packages
        self._group = group

    @cached_property
    def _modules(self) -> dict[str, str]:
        """Plug-in name -> dotted module name."""
        found = {p.stem: f"{package}.{p.stem}" for package in self._packages for p in _files(package)}
        if self._group:
            found |= {e.name: e.module for e in entry_points(group=self._group)}
        return dict(sorted(found.items()))

    def names(self) -> tuple[str, ...]:
        """Every registered name, sorted."""
        return tuple(self._modules)

    def __iter__(self) -> Iterator[str]:
        return iter(self._modules)

    def __contains__(self, name: object) -> bool:
        return name in self._modules

    def module(self, name: str) -> ModuleType:
        """Import the file of a plug-in.

        Raises
        ------
        UnknownName
            There is no plug-in of that name.
        Unavailable
            The file needs a package that is not installed.
        """
        dotted = self._dotted(name)
        try:
            return import_module(dotted)
        except ImportError as error:
            raise Unavailable(
                f"{self.kind} {name!r} cannot be loaded: {error}.{self._remedy(name)}"
            ) from error

    def get(self, name: str) -> Callable[..., Any]:
        """Import a plug-in and return its function; raises as `module` does."""
        return getattr(self.module(name), name)

    def summary(self, name: str) -> str:
        """First line of the file's docstring, without importing it."""
        return (ast.get_docstring(self._tree(name)) or "").partition("\n")[0]

    def documentation(self, name: str) -> str:
        """The whole docstring of the file, without importing it."""
        return ast.get_docstring(self._tree(name)) or ""

    def traits(self, name: str) -> Traits:
        """What the method needs, loses and promises, without importing it."""
        for node in self._tree(name).body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "TRAITS":
                call = node.value
                if not isinstance(call, ast.Call):
                    break
                return Traits(**{str(k.arg): ast.literal_eval(k.value) for k in call.keywords})
        raise InputError(f"{self.kind} {name!r} has no line 'TRAITS = Traits(...)'; add one to its file.")

    def missing(self, name: str) -> str:
        """Why a method cannot run here, or an empty string; imports nothing of the method's."""
        absent = [m for m in self.traits(name).requires if find_spec(m) is None]
        return f"{', '.join(absent)} is not installed.{self._remedy(name)}" if absent else ""

    def source(self, name: str) -> bytes:
        """The source text of a plug-in's file."""
        return self.path(name).read_bytes()

    def path(self, name: str) -> Path:
        """The file of a plug-in, found without importing it."""
        spec = find_spec(self._dotted(name))
        if spec is None or spec.origin is None:
            raise Unavailable(f"The file of {self.kind} {name!r} cannot be found; reinstall its package.")
        return Path(spec.origin)

    def settings(self, name: str) -> dict[str, Any]:
        """Import a plug-in and return its settings with their defaults, read from the signature."""
        parameters = inspect.signature(self.get(name)).parameters.values()
        return {
            p.name: p.default
            for p in parameters
            if p.kind is p.KEYWORD_ONLY and p.name not in _RESERVED and p.default is not p.empty
        }

    def _dotted(self, name: str) -> str:
        if name not in self._modules:
            raise UnknownName(self.kind, name, self._modules)
        return self._modules[name]

    def _remedy(self, name: str) -> str:
        extra = self.traits(name).extra if self.kind == "method" else ""
        return f" Install it with: pip install 'lpcompare[{extra}]'." if extra else ""

    def _tree(self, name: str) -> ast.Module:
        return ast.parse(self.source(name))


def _files(package: str) -> list[Path]:
    spec = find_spec(package)
    folders = spec.submodule_search_locations if spec else None
    files = (p for f in folders or () for p in Path(f).glob("*.py"))
    return [p for p in files if not p.stem.startswith("_") and p.stem not in _NO_PLUGINS]


METHODS = Registry("method", ("lpcompare.methods", "lpcompare_baselines"), "lpcompare.methods")
METRICS = Registry("metric", ("lpcompare.metrics",))
