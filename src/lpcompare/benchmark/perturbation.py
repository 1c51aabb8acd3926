"""What is done to the input before the methods see it; errors are measured against the clean cloud.

Each kind takes one level:

============  ==============================================================================================
noise         standard deviation of a Gaussian shift of every coordinate, as a share of the mean spacing
outliers      points added uniformly in the bounding box, grown by a tenth on each side, as a share of n
uneven        how uneven: the chance to stay falls linearly along the longest axis from 1 to 1 - level
missing       share of n that is cut out, as one ball around a random point of the cloud
============  ==============================================================================================
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from lpcompare.errors import InputError, UnknownName
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.types import Mask, PointCloud, Points


@dataclass(frozen=True)
class Perturbation:
    """A kind of damage and how much of it.

    Attributes
    ----------
    kind : str
        ``none``, ``noise``, ``outliers``, ``uneven`` or ``missing``.
    level : float
        See the head of this file; 0 for ``none``.
    """

    kind: str = "none"
    level: float = 0.0

    @property
    def label(self) -> str:
        """Empty for the clean cloud, else for example ``noise 0.5``."""
        return "" if self.kind == "none" else f"{self.kind} {self.level:g}"

    def check(self) -> None:
        """Refuse a kind or a level that does not exist; raises `UnknownName`, `InputError`."""
        if self.kind not in LARGEST_LEVEL:
            raise UnknownName("perturbation", self.kind, LARGEST_LEVEL)
        top = LARGEST_LEVEL[self.kind]
        if not 0 <= self.level <= top:
            raise InputError(f"The level of {self.kind} is {self.level}; it must be from 0 to {top:g}.")


CLEAN = Perturbation()
LARGEST_LEVEL = {"none": 0.0, "noise": 10.0, "outliers": 1.0, "uneven": 1.0, "missing": 0.9}


def perturb(cloud: PointCloud, perturbation: Perturbation, seed: int) -> PointCloud:
    """The cloud after the damage; the same for every method, reduction and repeat of a seed.

    Faces follow the points that stay; added points carry zeros in every attribute and belong to no face, so
    that a method that works on the mesh alone never sees them.

    Parameters
    ----------
    cloud : PointCloud
    perturbation : Perturbation
    seed : int

    Returns
    -------
    PointCloud
        Of the same name.
    """
    kind = int.from_bytes(hashlib.sha256(perturbation.kind.encode()).digest()[:8], "big")
    rng = np.random.default_rng(np.random.SeedSequence([seed, kind]))
    if perturbation.level == 0:
        return cloud
    if perturbation.kind == "noise":
        shift = perturbation.level * mean_spacing(cloud.points)
        return replace(cloud, points=cloud.points + rng.normal(scale=shift, size=cloud.points.shape))
    if perturbation.kind == "outliers":
        return _with_points(cloud, _in_the_box(cloud.points, perturbation.level, rng))
    keeps = _uneven if perturbation.kind == "uneven" else _outside_a_ball
    return keep_points(cloud, keeps(cloud.points, perturbation.level, rng))


def mean_spacing(points: Points) -> float:
    """Mean distance of a point to its nearest neighbour, in model units; 0 for a single point."""
    distances, _ = Neighbors(points).query(points, 2)
    return float(distances[:, -1].mean())


def _in_the_box(points: Points, share: float, rng: np.random.Generator) -> Points:
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.1 * (high - low)
    return rng.uniform(low - margin, high + margin, size=(round(share * len(points)), 3))


def _uneven(points: Points, level: float, rng: np.random.Generator) -> Mask:
    extent = np.ptp(points, axis=0)
    axis = int(extent.argmax())
    along = (points[:, axis] - points[:, axis].min()) / (extent[axis] or 1.0)
    return rng.random(len(points)) <= 1 - level * along


def _outside_a_ball(points: Points, share: float, rng: np.random.Generator) -> Mask:
    distances = np.linalg.norm(points - points[rng.integers(len(points))], axis=1)
    mask = np.ones(len(points), dtype=bool)
    mask[np.argsort(distances, kind="stable")[: round(share * len(points))]] = False
    return mask


def keep_points(cloud: PointCloud, mask: Mask) -> PointCloud:
    """The points of ``mask`` with all that they carry, and the faces whose three corners all stay."""
    faces = cloud.faces
    if faces is not None:
        faces = (np.cumsum(mask) - 1)[faces[mask[faces].all(axis=1)]]
    return replace(cloud.take(mask), faces=faces)


def _with_points(cloud: PointCloud, added: Points) -> PointCloud:
    def grown(array):
        return np.concatenate([array, np.zeros((len(added), *array.shape[1:]), dtype=array.dtype)])

    kept = {name: None if (a := getattr(cloud, name)) is None else grown(a) for name in ("normals", "colors")}
    attributes = {name: grown(values) for name, values in cloud.attributes.items()}
    points = np.concatenate([cloud.points, added])
    return replace(cloud, points=points, attributes=attributes, **kept)
