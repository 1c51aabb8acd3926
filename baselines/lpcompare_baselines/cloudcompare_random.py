"""CloudCompare's random subsampling, by its command line; its generator cannot be seeded.

The call includes starting the program and going through files.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._cloudcompare import subsample

TRAITS = Traits(
    wraps="CloudCompare -SS RANDOM",
    source="CloudCompare, https://www.cloudcompare.org",
    licence="GPL-2.0-or-later",
    family="random",
    repeatable=False,
    programs=("CloudCompare",),
    install="apt install cloudcompare, or from https://www.cloudcompare.org",
)


def cloudcompare_random(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep ``target_count`` rows, drawn without replacement.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: CloudCompare draws for itself.

    Returns
    -------
    Simplification
        A subset of the input.
    """
    indices = subsample(points, "RANDOM", target_count)
    return Simplification(points[indices], indices)
