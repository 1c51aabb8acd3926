"""Radii from the saliency of a sparse code: a reading of Leal and others 2021.

Leal, Sanchez-Torres, Branch-Bedoya, Abad and Leal, A saliency-based sparse representation method for point
cloud simplification, Sensors 21(13), 2021: the authors' successor of the 2017 paper. Only the abstract could be
read: normals, positions and curvature make a feature vector per point; a dictionary is learned on them; a
point's saliency combines the number of nonzeros of its sparse code with its reconstruction error, and is "a
dynamic clusterization radius".

1. Features: normal (3), position (3), surface variation (1) of the 16 nearest, each of mean 0 and variance 1.
2. A dictionary of 32 atoms by the method of optimal directions (Engan and others 1999), 10 rounds; codes by
   orthogonal matching pursuit, at most 3 atoms, until the error is below a tenth of the features' length.
3. Saliency s is the mean of the nonzeros, as a share of 3, and of the rank of the error, from 0 to 1.
4. R = r_max (1 - 3/4 s). Points are visited by falling saliency; each that is not covered is kept and covers
   those within its R.
5. r_max is the largest, to 1e-3, that keeps as many points as are asked for; the least salient of what is too
   much go.

Decisions: all the numbers; ranks in place of errors, because a few errors are very large; normals point away
from the centroid, because their sign changes the code.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.geometry.graphs import nearest_others
from lpcompare.types import Indices, Mask, Points, Simplification, Traits, Vector
from lpcompare_baselines._calibration import surface_spacing
from lpcompare_baselines._grid import CellGrid
from lpcompare_baselines._hoods import planes_and_variation

TRAITS = Traits(
    wraps="numpy, numba",
    source="Leal, Sanchez-Torres, Branch-Bedoya, Abad and Leal, A saliency-based sparse representation method "
    "for point cloud simplification, Sensors 21(13), 2021",
    licence="GPL-3.0-or-later",
    family="curvature",
    reading=True,
)

_ATOMS, _ROUNDS, _NONZEROS, _TOLERANCE = 32, 10, 3, 0.1
_HALVINGS = 24
_SHRINK = 0.75

Array = NDArray[np.float64]


def leal_saliency(
    points: Points, target_count: int, *, rng: np.random.Generator, n_neighbors: int = 16
) -> Simplification:
    """Keep ``target_count`` points, nearer to each other where the saliency is high.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the first atoms.
    n_neighbors : int, optional
        Points of a neighborhood.

    Returns
    -------
    Simplification
        A subset of the input; ``info["saliency"]`` has s of every input point, shape (n,).
    """
    saliency = sparse_saliency(point_features(points, n_neighbors), rng)
    order = np.argsort(-saliency, kind="stable")
    shrink = 1 - _SHRINK * saliency
    low, high = 0.0, 4 * surface_spacing(points, target_count)
    kept = np.ones(len(points), dtype=bool)
    for _ in range(_HALVINGS):
        radius = (low + high) / 2
        trial = cover(points, order, radius * shrink)
        low, high = (radius, high) if trial.sum() >= target_count else (low, radius)
        kept = trial if trial.sum() >= target_count else kept
        if kept.sum() == target_count or high - low < 1e-3 * high:
            break
    indices = np.sort(order[kept[order]][:target_count])
    return Simplification(points[indices], indices, info={"saliency": saliency})


def point_features(points: Points, n_neighbors: int) -> Array:
    """Normal, position and surface variation of each point, shape (n, 7), each column standardised."""
    _, near = nearest_others(points, n_neighbors)
    rows = np.column_stack([np.arange(len(points)), near])
    normals, variation = planes_and_variation(points, rows)
    outward = points - points.mean(axis=0)
    normals = normals * np.where(np.einsum("ij,ij->i", normals, outward) < 0, -1.0, 1.0)[:, None]
    features = np.column_stack([normals, outward, variation])
    features -= features.mean(axis=0)
    deviations = features.std(axis=0)
    return features / np.where(deviations > 1e-12, deviations, 1.0)


def sparse_saliency(features: Array, rng: np.random.Generator) -> Vector:
    """Steps 2 and 3: the saliency of each row of features, shape (n,), from 0 to 1."""
    n = len(features)
    atoms = _unit(features[rng.choice(n, _ATOMS, replace=n < _ATOMS)])
    for _ in range(_ROUNDS):
        codes = sparse_codes(features, atoms)
        ridge = 1e-6 * n * np.eye(_ATOMS)
        fitted = np.asarray(np.linalg.solve(codes.T @ codes + ridge, codes.T @ features), dtype=np.float64)
        used = (codes != 0).any(axis=0)
        atoms = np.where(used[:, None], _unit(fitted), atoms)
    codes = sparse_codes(features, atoms)
    errors = np.linalg.norm(features - codes @ atoms, axis=1)
    ranks = np.searchsorted(np.sort(errors), errors, side="left") / max(n - 1, 1)
    return ((codes != 0).sum(axis=1) / _NONZEROS + ranks) / 2


def sparse_codes(features: Array, atoms: Array) -> Array:
    """Orthogonal matching pursuit of all rows together, shape (n, atoms)."""
    n = len(features)
    codes, residuals, chosen = np.zeros((n, len(atoms))), features.copy(), np.empty((n, 0), dtype=np.intp)
    lengths = np.linalg.norm(features, axis=1)
    for _ in range(_NONZEROS):
        open_rows = np.flatnonzero(np.linalg.norm(residuals, axis=1) > _TOLERANCE * lengths)
        best = np.zeros(n, dtype=np.intp)
        best[open_rows] = np.abs(residuals[open_rows] @ atoms.T).argmax(axis=1)
        chosen = np.column_stack([chosen, best])
        basis = atoms[chosen[open_rows]]
        gram = np.einsum("nad,nbd->nab", basis, basis) + 1e-9 * np.eye(chosen.shape[1])
        right = np.einsum("nad,nd->na", basis, features[open_rows])
        weights = np.linalg.solve(gram, right[..., None])[..., 0]
        codes[open_rows] = 0.0
        rows = np.repeat(open_rows, chosen.shape[1])
        codes[rows, chosen[open_rows].ravel()] = weights.ravel()
        residuals[open_rows] = features[open_rows] - codes[open_rows] @ atoms
    return codes


def cover(points: Points, order: Indices, radii: Vector) -> Mask:
    """The points that are kept when each, in an order, covers those within its radius, shape (n,)."""
    grid = CellGrid.over(points, float(radii.max()))
    places = np.argsort(grid.order)
    kept = _cover(points[grid.order], places[order], radii[grid.order], grid.cells, grid.starts, grid.around)
    return kept[places]


@njit(cache=True)
def _cover(
    points: Points, order: Indices, radii: Vector, cells: Indices, starts: Indices, around: NDArray[np.intp]
) -> Mask:
    kept, covered = np.zeros(len(points), np.bool_), np.zeros(len(points), np.bool_)
    for row in order:
        if covered[row]:
            continue
        kept[row] = True
        for cell in around[cells[row]]:
            if cell < 0:
                continue
            for other in range(starts[cell], starts[cell + 1]):
                squared = 0.0
                for axis in range(3):
                    squared += (points[row, axis] - points[other, axis]) ** 2
                if squared <= radii[row] * radii[row]:
                    covered[other] = True
    return kept


def _unit(rows: Array) -> Array:
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    return rows / np.where(lengths > 0, lengths, 1.0)
