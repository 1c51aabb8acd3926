"""Methods and metrics, found by file name and imported only when they are asked for.

A plug-in is one file that holds one public function of the file's name. Its one-line summary and its
`Traits` are read from the source text, so that a list of methods costs no import of a rival's library.
Packages outside lpcompare add methods through the entry point group ``lpcompare.methods``.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from time import perf_counter
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, get_type_hints

from lpcompare.errors import InputError, MethodError, Unavailable, UnknownName
from lpcompare.types import Column, PointCloud, Simplification, Traits

if TYPE_CHECKING:
    import numpy as np

_RESERVED = frozenset(
    {"rng", "cloud", "callback", "target_count", "target_reduction", "random_state", "method", "placed"}
)
"""Arguments that are no settings: the registry or the method's file gives them."""

_NO_PLUGINS = frozenset({"comparison"})
_FORGIVEN = 0.01
"""Share of a promised count that may be missing: a broken mesh can withhold the last points."""

_Kind = TypeVar("_Kind")
Seed: TypeAlias = "int | np.random.SeedSequence | np.random.Generator | None"


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

    Attributes
    ----------
    notes : tuple of str
        Which plug-ins of other distributions were left out, and why: they are broken, or take a name that is
        taken. Filled when the names are first asked for.
    """

    def __init__(self, kind: str, packages: tuple[str, ...], group: str = "") -> None:
        self.kind = kind
        self._packages = packages
        self._group = group
        self._trees: dict[Path, tuple[int, ast.Module]] = {}
        self.notes: tuple[str, ...] = ()

    @cached_property
    def _modules(self) -> dict[str, _Home]:
        """Plug-in name -> where it lives."""
        own = [(path.stem, package) for package in self._packages for path in _files(package)]
        homes = [(name, _Home(f"{package}.{name}", package)) for name, package in own]
        homes += [(e.name, self._guest(e)) for e in sorted(entry_points(group=self._group or "none"))]
        found: dict[str, _Home] = {}
        for name, home in homes:
            if name in found:
                taken = f"the name is taken by {found[name].origin}"
                self.notes += (f"The {self.kind} {name!r} of {home.origin} is left out: {taken}.",)
            elif home.fault:
                self.notes += (f"The {self.kind} {name!r} of {home.origin} is left out: {home.fault}.",)
            else:
                found[name] = home
        return dict(sorted(found.items()))

    def origin(self, name: str) -> str:
        """The package or the distribution that a plug-in comes from."""
        return self._home(name).origin

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
        home = self._home(name)
        try:
            module = import_module(home.module)
        except (Exception, SystemExit) as error:
            reason = str(error) if isinstance(error, ImportError) else f"{type(error).__name__}: {error}"
            raise Unavailable(
                f"The {self.kind} {name!r} of {home.origin} cannot be loaded: {reason}.{self._remedy(name)}"
            ) from error
        if not callable(getattr(module, name, None)):
            raise Unavailable(f"The {self.kind} {name!r} of {home.origin} has no function of that name.")
        return module

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
        if (traits := _traits(self._tree(name))) is not None:
            return traits
        raise InputError(f"{self.kind} {name!r} has no line 'TRAITS = Traits(...)'; add one to its file.")

    @cached_property
    def quick(self) -> tuple[str, ...]:
        """The names whose files have no line ``COST = "slow"``; nothing is imported."""
        return tuple(name for name in self if not self._is_slow(name))

    def _is_slow(self, name: str) -> bool:
        cost = _assigned(self._tree(name), "COST")
        return isinstance(cost, ast.Constant) and cost.value == "slow"

    def columns(self, name: str) -> Mapping[str, Column]:
        """The columns of a metric by key; its file is imported only where they are not literal.

        Raises
        ------
        UnknownName
            There is no metric of that name.
        Unavailable
            The file computes its columns and cannot be imported.
        """
        table = _assigned(self._tree(name), "COLUMNS")
        calls = table.values if isinstance(table, ast.Dict) else []
        if isinstance(table, ast.Dict) and all(ast.unparse(call).startswith("Column(") for call in calls):
            with suppress(ValueError):
                keys = [ast.literal_eval(key or "") for key in table.keys]
                return dict(zip(keys, (_record(call, Column) for call in calls), strict=True))
        return self.module(name).COLUMNS

    def check_names(self, names: Iterable[str]) -> None:
        """Refuse names of plug-ins that do not exist; raises `UnknownName`."""
        for name in names:
            self._home(name)

    def missing(self, name: str) -> str:
        """Why a method cannot run here, or an empty string; imports nothing of the method's."""
        traits = self.traits(name)
        absent = [m for m in traits.requires if find_spec(m) is None]
        absent += [f"the program {p}" for p in traits.programs if which(p) is None]
        return f"{', '.join(absent)} is not installed.{self._remedy(name)}" if absent else ""

    def source(self, name: str) -> bytes:
        """The source text of a plug-in's file."""
        return self.path(name).read_bytes()

    def path(self, name: str) -> Path:
        """The file of a plug-in, found without importing it."""
        spec = find_spec(self._home(name).module)
        if spec is None or spec.origin is None:
            raise Unavailable(f"The file of {self.kind} {name!r} cannot be found; reinstall its package.")
        return Path(spec.origin)

    def settings(self, name: str) -> dict[str, Any]:
        """Import a plug-in and return its settings with their defaults, read from the signature."""
        return {
            p.name: None if p.default is p.empty else p.default
            for p in _keywords(self.get(name), self.module(name))
            if p.name not in _RESERVED
        }

    def check_settings(self, name: str, settings: Mapping[str, Any]) -> None:
        """Check names and types of settings against the method's signature.

        Raises
        ------
        UnknownName
            The method has no such setting.
        InputError
            The value is of another type.
        """
        if not settings:
            return
        import msgspec

        module, known = self.module(name), self.settings(name)
        hints = get_type_hints(getattr(module, name))
        hints |= get_type_hints(module.THINNING.__init__) if hasattr(module, "THINNING") else {}
        for setting, value in settings.items():
            if setting not in known:
                raise UnknownName(f"setting of {name}", setting, known)
            try:
                msgspec.convert(getattr(value, "item", lambda v=value: v)(), hints.get(setting, Any))
            except msgspec.ValidationError as error:
                raise InputError(
                    f"{name}.{setting} is {value!r}, a {type(value).__name__} ({error}; default "
                    f"{known[setting]!r}); give a value of that type."
                ) from None

    def _guest(self, entry: EntryPoint) -> _Home:
        """The home of another distribution's plug-in; its text is read, so that a broken one ends nothing."""
        origin = f"the package {entry.dist.name}" if entry.dist else "another package"
        try:
            spec = find_spec(entry.module)
            if spec is None or spec.origin is None:
                return _Home(entry.module, origin, f"there is no module {entry.module}")
            tree = ast.parse(Path(spec.origin).read_bytes())
            if self.kind == "method" and _traits(tree) is None:
                return _Home(entry.module, origin, "its file has no line 'TRAITS = Traits(...)'")
        except (Exception, SystemExit) as error:
            return _Home(entry.module, origin, f"{type(error).__name__}: {error}")
        return _Home(entry.module, origin)

    def _home(self, name: str) -> _Home:
        if name not in self._modules:
            raise UnknownName(self.kind, name, self._modules)
        return self._modules[name]

    def _remedy(self, name: str) -> str:
        if self.kind != "method":
            return ""
        traits = self.traits(name)
        how = traits.install or (f"pip install 'lpcompare[{traits.extra}]'" if traits.extra else "")
        return f" Install it with: {how}." if how else ""

    def _tree(self, name: str) -> ast.Module:
        """The source text of a plug-in's file, parsed again only where the file has changed."""
        path = self.path(name)
        changed = path.stat().st_mtime_ns
        if self._trees.get(path, (0,))[0] != changed:
            self._trees[path] = changed, ast.parse(path.read_bytes())
        return self._trees[path][1]


@dataclass(frozen=True)
class _Home:
    """Where a plug-in lives: its module, the package or distribution, and what is wrong with it."""

    module: str
    origin: str
    fault: str = ""


def _traits(tree: ast.Module) -> Traits | None:
    """The literal ``TRAITS = Traits(...)`` of a file."""
    traits = _assigned(tree, "TRAITS")
    return _record(traits, Traits) if isinstance(traits, ast.Call) else None


def _assigned(tree: ast.Module, name: str) -> ast.expr | None:
    """What a line ``name = ...`` of a file assigns."""
    assignments = (node for node in tree.body if isinstance(node, ast.Assign))
    return next((node.value for node in assignments if ast.unparse(node.targets[0]) == name), None)


def _record(call: ast.expr, kind: type[_Kind]) -> _Kind:
    """The record that a call with literal arguments makes; raises ValueError for other arguments."""
    assert isinstance(call, ast.Call)
    named = {str(k.arg): ast.literal_eval(k.value) for k in call.keywords}
    return kind(*map(ast.literal_eval, call.args), **named)


def _keywords(function: Callable[..., Any], module: ModuleType) -> list[inspect.Parameter]:
    """The keyword arguments of a plug-in; ``**settings`` stand for those of the file's ``THINNING``."""
    parameters = list(inspect.signature(function).parameters.values())
    if any(p.kind is p.VAR_KEYWORD for p in parameters) and hasattr(module, "THINNING"):
        parameters += inspect.signature(module.THINNING).parameters.values()
    return [p for p in parameters if p.kind is p.KEYWORD_ONLY]


def _files(package: str) -> list[Path]:
    spec = find_spec(package)
    folders = spec.submodule_search_locations if spec else None
    files = (p for f in folders or () for p in Path(f).glob("*.py"))
    return [p for p in files if not p.stem.startswith("_") and p.stem not in _NO_PLUGINS]


METHODS = Registry("method", ("lpcompare.methods", "lpcompare_baselines"), "lpcompare.methods")
METRICS = Registry("metric", ("lpcompare.metrics",), "lpcompare.metrics")


class Invocation:
    """One method with its settings, about to be called on one cloud.

    The three steps are apart, so that a harness can time them: `calibrate`, `call`, `verify`.

    Parameters
    ----------
    name : str
        A registered method.
    cloud : PointCloud
        Finite coordinates; it is never changed.
    target_count : int
        Points to keep.
    random_state : int, SeedSequence, Generator or None
        Seed of every random draw. Calibration and call begin with the same state, unless it is a generator.
    settings : mapping, optional
        Settings of the method.
    callback : callable, optional
        Called with (stage, done, total) by the methods that report their progress.

    Raises
    ------
    UnknownName
        There is no such method or setting.
    Unavailable
        The method needs a package or a program that is not installed.
    InputError
        A coordinate is not finite, or the count is not from 1 to n.
    """

    def __init__(
        self,
        name: str,
        cloud: PointCloud,
        target_count: int,
        *,
        random_state: Seed = 0,
        settings: Mapping[str, Any] | None = None,
        callback: Callable[[str, int, int], None] | None = None,
    ) -> None:
        from lpcompare.checks import check_points

        self.name, self.target_count = name, target_count
        self.cloud = replace(cloud, points=check_points(cloud.points))
        self.module, self.traits = METHODS.module(name), METHODS.traits(name)
        if self.traits.programs and (missing := METHODS.missing(name)):
            raise Unavailable(f"The method {name!r} cannot run: {missing}")
        self.settings = dict(settings or {})
        METHODS.check_settings(name, self.settings)
        if not 1 <= target_count <= len(cloud):
            raise InputError(f"target_count is {target_count}; it must be from 1 to the {len(cloud)} points.")
        self._exact = self.traits.exact_count and not self.settings
        self._random_state, self._callback = random_state, callback

    @property
    def has_calibration(self) -> bool:
        """Whether the method searches for a setting that gives the count."""
        return hasattr(self.module, "calibrate")

    def calibrate(self) -> None:
        """Search for the settings that give the count, if the method has such a search."""
        if self.has_calibration:
            self.settings = self._apply(self.module.calibrate) | self.settings

    def call(self) -> Simplification:
        """What the method returns, not yet verified."""
        return self._apply(getattr(self.module, self.name))

    def verify(self, result: object, before: PointCloud) -> str:
        """Check count, subset, finiteness, and that the input is as it was.

        Parameters
        ----------
        result : object
            What the method returned.
        before : PointCloud
            A copy of the input from before the call.

        Returns
        -------
        str
            A word on up to 1 % fewer points than promised; empty where there is none.

        Raises
        ------
        MethodError
            The method broke a promise of its traits.
        """
        if fault := self._input_fault(before) or self._count_fault(result) or self._row_fault(result, before):
            raise MethodError(f"{self.name}: {fault}")
        n_kept = len(result)  # type: ignore[arg-type]
        if self._exact and n_kept < self.target_count:
            return f"The method returned {n_kept} points and promises exactly {self.target_count}."
        return ""

    def effective_settings(self) -> dict[str, Any]:
        """Every setting as it is used: the defaults, what calibration found, what was given."""
        return METHODS.settings(self.name) | self.settings

    def _input_fault(self, before: PointCloud) -> str:
        import numpy as np

        parts = ("points", "normals", "faces")
        pairs = [(getattr(before, part), getattr(self.cloud, part)) for part in parts]
        same = all(a is None or np.array_equal(a, b, equal_nan=True) for a, b in pairs)
        return "" if same else "The method changed its input."

    def _count_fault(self, result: object) -> str:
        import numpy as np

        if not isinstance(result, Simplification):
            return f"The method returned a {type(result).__name__}, not a Simplification."
        points, given, target = result.points, len(self.cloud), self.target_count
        if not isinstance(points, np.ndarray) or points.ndim != 2 or points.shape[1] != 3:
            return f"The points have shape {np.shape(points)}; it must be (m, 3)."
        if len(points) == 0:
            return "The method returned no points."
        if len(points) > given:
            return f"The method returned {len(points)} points, more than the {given} that it was given."
        if self._exact and not (1 - _FORGIVEN) * target <= len(points) <= target:
            return f"The method returned {len(points)} points and promises exactly {target}."
        return ""

    def _row_fault(self, result: Any, before: PointCloud) -> str:
        import numpy as np

        if result.points.dtype != np.float64:
            return f"The points are {result.points.dtype}; they must be float64."
        bad = int((~np.isfinite(result.points).all(axis=1)).sum())
        if bad:
            return f"{bad} of the {len(result)} points returned are NaN or infinite."
        if result.indices is None:
            return "The method names no rows and promises a subset." if self.traits.keeps_indices else ""
        return self._index_fault(result, before)

    def _index_fault(self, result: Simplification, before: PointCloud) -> str:
        import numpy as np

        indices = np.asarray(result.indices)
        if indices.shape != (len(result),) or indices.dtype.kind != "i":
            wanted = f"({len(result)},) integers"
            return f"The indices are {indices.dtype} of shape {indices.shape}; they must be {wanted}."
        if indices[0] < 0 or indices[-1] >= len(before) or (np.diff(indices) <= 0).any():
            return "The indices are not ascending, distinct rows of the input."
        if not np.array_equal(result.points, before.points[indices]):
            return "The points are not the rows of the input that the indices name."
        return ""

    def _apply(self, function: Callable[..., Any]) -> Any:
        import numpy as np

        known = {p.name for p in _keywords(function, self.module)}
        offered = {"cloud": self.cloud, "callback": self._callback} | self.settings
        chosen = {key: value for key, value in offered.items() if key in known}
        rng = np.random.default_rng(self._random_state)
        return function(self.cloud.points, self.target_count, rng=rng, **chosen)


def call(
    name: str,
    cloud: PointCloud,
    target_count: int,
    *,
    random_state: Seed = 0,
    settings: Mapping[str, Any] | None = None,
    callback: Callable[[str, int, int], None] | None = None,
) -> Simplification:
    """Call a method: calibrate it, call it, verify what it returns; parameters and errors of `Invocation`.

    Returns
    -------
    Simplification
        With the method's name, its settings and the seconds of the call and of the calibration.
    """
    invocation = Invocation(
        name, cloud, target_count, random_state=random_state, settings=settings, callback=callback
    )
    before = replace(cloud, points=cloud.points.copy())
    begin = perf_counter()
    invocation.calibrate()
    calibrated = perf_counter()
    result = invocation.call()
    end = perf_counter()
    note = invocation.verify(result, before)
    return replace(
        result,
        method=name,
        settings=invocation.effective_settings(),
        runtime_s=end - calibrated,
        calibration_s=calibrated - begin if invocation.has_calibration else None,
        note=note,
    )
