"""What the paper prints, by model; see published.toml."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any


@cache
def published() -> dict[str, Any]:
    """The paper's figures as they stand in published.toml."""
    return tomllib.loads(Path(__file__).with_name("published.toml").read_text(encoding="utf-8"))


def counterpart(model: str) -> dict[str, Any] | None:
    """The paper's figures for a model, matched by the beginning of its name; None if it has none."""
    return next((entry for name, entry in published()["models"].items() if model.startswith(name)), None)
