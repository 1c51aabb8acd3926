"""The clouds of a run: loaded, checked, perturbed and written once for all child processes."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lpcompare.benchmark.perturbation import CLEAN, Perturbation
from lpcompare.errors import InputError
from lpcompare.io.arrays import digest, save_cloud
from lpcompare.types import PointCloud


@dataclass(frozen=True)
class Input:
    """A cloud on disk that methods are given.

    Attributes
    ----------
    path : Path
        The .npz.
    model : str
    n_points : int
    sha256 : str
        Of all that a method can see.
    """

    path: Path
    model: str
    n_points: int
    sha256: str


def load_models(names: Iterable[str]) -> dict[str, PointCloud]:
    """Every model of a plan, by the name under which the plan asks for it.

    Raises
    ------
    UnknownName, InputError, ModelDataError
        A model does not exist, cannot be read, or is not a cloud of finite points.
    """
    from lpcompare.models import load_model

    clouds = {name: load_model(name) for name in names}
    for name, cloud in clouds.items():
        check_points(cloud, name)
    titles = [cloud.name for cloud in clouds.values()]
    for title in titles:
        if titles.count(title) > 1:
            raise InputError(f"Two models are called {title!r}; rename one of the files.")
    return clouds


def check_points(cloud: PointCloud, name: str) -> None:
    """Refuse a cloud that methods cannot work on; raises `InputError`."""
    points = cloud.points
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"{name} has points of shape {points.shape}; it must be (n, 3).")
    if len(points) == 0:
        raise InputError(f"{name} holds no points; give a cloud with at least one.")
    bad = int((~np.isfinite(points).all(axis=1)).sum())
    if bad:
        raise InputError(f"{name}: {bad} of {len(points)} points are NaN or infinite; remove them first.")


def write_input(folder: Path, cloud: PointCloud, perturbation: Perturbation = CLEAN, seed: int = 0) -> Input:
    """Write the cloud that one group of cases is given."""
    suffix = "" if perturbation == CLEAN else f"~{perturbation.kind}-{perturbation.level:g}-s{seed}"
    path = folder / f"{file_name(cloud.name)}{suffix}.npz"
    save_cloud(path, cloud)
    return Input(path, cloud.name, len(cloud), digest(cloud))


def file_name(text: str) -> str:
    """``text`` as part of a file's name."""
    return re.sub(r"[^\w.=-]+", "-", text).strip("-") or "cloud"
