"""How many clusters: the paper's future work, by the Bayesian information criterion on a subsample.

Schwarz (1978): BIC = -2 log L + p log n, with p = 10 K - 1 parameters for K Gaussians in space. A surface is
no mixture of Gaussians, so a larger sample always supports more of them: the size of the sample is part of
the rule. On 2,000 points the criterion has its minimum between 20 and 60 on scans and modelled meshes alike,
where the paper chose 10 to 35; the candidates end at 40.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lpcompare.checks import check_integer
from lpcompare.errors import InputError
from lpcompare.paper.clustering import cluster_points
from lpcompare.types import Points, Vector

AUTO = "auto"
CANDIDATES = (5, 8, 10, 12, 15, 20, 25, 30, 35, 40)
SAMPLE_SIZE = 2000

ClusterCountSetting = int | Literal["auto"]


@dataclass(frozen=True, eq=False)
class ClusterCount:
    """The number of clusters chosen, and the curve that it was chosen from.

    Attributes
    ----------
    n_clusters : int
        The candidate of least criterion, the smaller among equals.
    candidates : tuple of int
        Numbers of clusters tried, ascending.
    criteria : ndarray, shape (c,)
        BIC of each, divided by the size of the sample.
    """

    n_clusters: int
    candidates: tuple[int, ...]
    criteria: Vector


def choose_n_clusters(points: Points, rng: np.random.Generator) -> ClusterCount:
    """The number of Gaussians of least BIC on `SAMPLE_SIZE` points, among `CANDIDATES`.

    Candidates above a tenth of the distinct points are left out, down to one.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Normalised cloud (mean zero, mean squared radius one).
    rng : numpy.random.Generator
        Draws the sample and the starts.

    Returns
    -------
    ClusterCount

    References
    ----------
    G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6(2), 1978.
    """
    rows = np.sort(rng.choice(len(points), min(SAMPLE_SIZE, len(points)), replace=False))
    sample = points[rows]
    most = max(1, len(np.unique(sample, axis=0)) // 10)
    tried = tuple(k for k in CANDIDATES if k <= most) or (1,)
    seed = int(rng.integers(2**31))
    criteria = np.array([_criterion(sample, k, np.random.default_rng(seed)) for k in tried])
    return ClusterCount(tried[int(np.argmin(criteria))], tried, criteria)


def _criterion(sample: Points, n_clusters: int, rng: np.random.Generator) -> float:
    log_likelihood = float(cluster_points(sample, n_clusters, rng).log_likelihoods[-1])
    n_parameters = 10 * n_clusters - 1
    return (n_parameters * np.log(len(sample)) - 2 * log_likelihood) / len(sample)


def check_n_clusters(value: object) -> ClusterCountSetting:
    """An integer of at least one, or "auto".

    Raises
    ------
    InputError
        It is neither.
    """
    if value == AUTO:
        return AUTO
    if isinstance(value, str):
        raise InputError(f"n_clusters is {value!r}; give an integer of at least 1, or 'auto'.")
    return check_integer("n_clusters", value, 1)
