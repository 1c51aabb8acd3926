"""One colour and one symbol per method, the same in every chart of a report."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

_COLORS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
    "#882255", "#999933", "#332288", "#aa4499", "#44aa99", "#737373",
)  # fmt: skip
"""Told apart by the colour-blind: eight of Okabe and Ito, the rest of Tol's "muted"; on light and dark."""

_ON_DARK = {"#882255": "#cf1745", "#332288": "#8f80e0"}
"""Lighter doubles of the colours that vanish on a dark page, away from the other eleven."""

CLUSTER_COLORS = (
    "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9",
    "#d55e00", "#f0e442", "#882255", "#44aa99", "#999933",
)  # fmt: skip
MARK_COLORS = ("#b5bac1", "#0072b2")
"""Removed, kept."""

_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "cross", "x")
_MARKERS = {"circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "triangle-down": "v",
            "cross": "P", "x": "X"}  # fmt: skip


@dataclass(frozen=True)
class Style:
    """How a method is drawn.

    Attributes
    ----------
    color, dark : str
        On a light page and on paper, and on a dark page.
    symbol : str
        Plotly's name.
    """

    color: str
    dark: str
    symbol: str

    @property
    def marker(self) -> str:
        """Matplotlib's name of the symbol."""
        return _MARKERS[self.symbol]


def method_styles(methods: Iterable[str]) -> dict[str, Style]:
    """A style for every method, by its place in the list; no two share both colour and symbol below 84."""
    return {
        method: _style(i, _SYMBOLS[(i + i // len(_COLORS)) % len(_SYMBOLS)])
        for i, method in enumerate(methods)
    }


def stage_styles(stages: Iterable[str]) -> dict[str, Style]:
    """A style for every stage of a method's time; no two share a colour below 13."""
    return {stage: _style(i, _SYMBOLS[0]) for i, stage in enumerate(stages)}


def _style(place: int, symbol: str) -> Style:
    color = _COLORS[place % len(_COLORS)]
    return Style(color, _ON_DARK.get(color, color), symbol)
