"""Particle simulation: particles repel each other on the surface until they are evenly spread.

Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002, section 3.3,
after Turk (SIGGRAPH 1992).

1. Particles are drawn from the points, more of them where the points are sparse.
2. Particles closer than r repel each other: p moves by the sum of k (r - |p - q|) (p - q) (eqs. 7 and 8).
3. After each move a particle is put on the tangent plane of the point that is nearest to it.
4. In the end it is projected onto the moving least squares surface of the points.

So the result does not depend on how dense the input is, and its points are new.

What the publication leaves open, or contradicts itself in, is decided here:

- A point is drawn in proportion to its area a = pi r_k^2 / k, with r_k the distance to its k-th nearest point
  and k = 12: in equal steps of the area, summed over the points in the order of a k-d tree, from a random
  first step. The start is moved by a thousandth of r at random, because particles at one place do not repel
  each other.
- r = 1.2 sqrt(A / m) for m particles, with A the sum of all areas. As printed the force is greatest at r / 2:
  with the 2 sqrt(A / m) of Turk, whose force is not weaker nearby, pairs of particles fall together. The
  factor k is 1 / (2 r): one neighbor at r / 2 moves a particle by r / 8. No move is longer than r / 4. It
  ends when the mean move is below r / 1000, or after 60 rounds. Of the particles closer than r the nearest 16
  count.
- A particle may not leave the nearest point by more than the width of that point's area, sqrt(a): otherwise
  particles would drift over open rims.
- Adaptive: the publication scales r with the inverse of the surface variation, which is 0 on planes. Here r
  is multiplied by f = mean variation / variation of the nearest point, kept from 2/3 to 3/2, with variations
  of 20 neighbors; the sum of the squares of all r stays the same. As printed, the draw would take fewer
  particles from curved places; here a point is drawn in proportion to a / f^2.
- The projection fits a plane to the 16 nearest points in 3 rounds, and then a weighted quadratic height over
  it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lpcompare.geometry.frames import tangents
from lpcompare.geometry.graphs import nearest_others
from lpcompare.geometry.moving_planes import moving_planes
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Indices, Points, Simplification, Traits, Vector
from lpcompare_baselines._hoods import normals_and_variation

TRAITS = Traits(
    source="Pauly, Gross and Kobbelt, Efficient simplification of point-sampled surfaces, Visualization 2002",
    family="surface",
    moves_points=True,
    keeps_attributes=False,
)

_AREA_NEIGHBORS = 12
_VARIATION_NEIGHBORS = 20
_SURFACE_NEIGHBORS = 16
_MOST_REPELLING = 16
_MOST_ROUNDS = 60
_SMALLEST_MOVE = 1e-3
_LARGEST_MOVE = 0.25
_REACH = 1.2
_JITTER = 1e-3
_WIDEST = 1.5
"""Largest factor of the adaptive radius; its inverse is the least one."""
_RIDGE = 1e-9


def pauly_particle(
    points: Points, target_count: int, *, rng: np.random.Generator, adaptive: bool = False
) -> Simplification:
    """Spread particles over the surface of a cloud.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the starts.
    adaptive : bool, optional
        Let particles stand closer where the surface is curved.

    Returns
    -------
    Simplification
        New points; ``info["n_rounds"]`` says how often they moved.
    """
    center = bounding_box_center(points)
    surface = _Surface(points - center, adaptive)
    particles = surface.draw(target_count, rng)
    n_rounds = 0
    while n_rounds < _MOST_ROUNDS and surface.area > 0:
        n_rounds += 1
        moved, radii = surface.repel(particles)
        mean_move = float((np.linalg.norm(moved - particles, axis=1) / radii).mean())
        particles = moved
        if mean_move < _SMALLEST_MOVE:
            break
    return Simplification(surface.project(particles) + center, info={"n_rounds": n_rounds})


class _Surface:
    """The cloud that particles move on: area, normal and factor of the radius at each of its points."""

    def __init__(self, points: Points, adaptive: bool) -> None:
        self.points, self.neighbors = points, Neighbors(points)
        distances, nearest = nearest_others(points, _VARIATION_NEIGHBORS)
        squared = np.square(distances[:, :_AREA_NEIGHBORS])
        self.areas = np.pi * squared.max(axis=1, initial=0.0) / max(squared.shape[1], 1)
        self.area = float(self.areas.sum())
        self.normals = normals_and_variation(points, nearest[:, :_AREA_NEIGHBORS])[0]
        self.factors = np.ones(len(points))
        if adaptive:
            variation = normals_and_variation(points, nearest)[1]
            relative = variation / max(float(variation.mean()), np.finfo(float).tiny)
            self.factors = 1 / np.clip(relative, 1 / _WIDEST, _WIDEST)

    def draw(self, n_particles: int, rng: np.random.Generator) -> Points:
        """Starts, shape (m, 3): points in proportion to their share of the area, moved a little."""
        order = self.neighbors.order.astype(np.intp)
        shares = np.cumsum((self.areas / np.square(self.factors))[order])
        steps = (np.arange(n_particles) + rng.uniform()) / n_particles
        rows = order[np.searchsorted(shares, steps * shares[-1])] if shares[-1] > 0 else order[:n_particles]
        radii = self._radii(rows)
        return self.points[rows] + _JITTER * radii[:, None] * rng.standard_normal((n_particles, 3))

    def _radii(self, nearest: Indices) -> Vector:
        factors = self.factors[nearest]
        return _REACH * np.sqrt(self.area / np.square(factors).sum()) * factors

    def repel(self, particles: Points) -> tuple[Points, Vector]:
        """Where each particle moves in a round, and its radius."""
        radii = self._radii(self.neighbors.query(particles, 1)[1][:, 0])
        distances, others = Neighbors(particles).query(particles, _MOST_REPELLING + 1)
        strengths = np.maximum(radii[:, None] - distances, 0.0) / (2 * radii[:, None])
        moves = strengths.sum(axis=1)[:, None] * particles
        moves -= np.einsum("mk,mki->mi", strengths, particles[others])
        lengths = np.linalg.norm(moves, axis=1)
        longest = _LARGEST_MOVE * radii
        moves *= np.divide(longest, lengths, where=lengths > longest, out=np.ones_like(lengths))[:, None]
        return self._on_tangent_planes(particles + moves), radii

    def _on_tangent_planes(self, particles: Points) -> Points:
        nearest = self.neighbors.query(particles, 1)[1][:, 0]
        offsets, normals = particles - self.points[nearest], self.normals[nearest]
        offsets -= np.einsum("mi,mi->m", offsets, normals)[:, None] * normals
        lengths, widths = np.linalg.norm(offsets, axis=1), np.sqrt(self.areas[nearest])
        offsets *= np.divide(widths, lengths, where=lengths > widths, out=np.ones_like(lengths))[:, None]
        return self.points[nearest] + offsets

    def project(self, particles: Points) -> Points:
        """The moving least squares projection: a plane, and a quadratic height over it."""
        nearest = self.neighbors.query(particles, _SURFACE_NEIGHBORS)[1]
        feet, normals, widths = moving_planes(particles, self.points, nearest, n_rounds=3)
        offsets = self.points[nearest] - feet[:, None]
        return feet + _heights(offsets, normals, widths)[:, None] * normals


def _heights(offsets: NDArray[np.float64], normals: Points, widths: Vector) -> Vector:
    """Height of the weighted quadratic through each neighborhood (m, k, 3) at its origin, along the normal."""
    widths = np.where(widths > 0, widths, 1.0)
    first, second = tangents(normals.T)
    u = np.einsum("mki,im->mk", offsets, first) / widths[:, None]
    v = np.einsum("mki,im->mk", offsets, second) / widths[:, None]
    heights = np.einsum("mki,mi->mk", offsets, normals)
    weights = np.exp(-np.square(offsets / widths[:, None, None]).sum(axis=2))
    terms = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=2)
    weighted = terms * weights[:, :, None]
    matrices = np.matmul(weighted.transpose(0, 2, 1), terms)
    ridge = _RIDGE * np.trace(matrices, axis1=1, axis2=2) + np.finfo(float).tiny
    matrices += ridge[:, None, None] * np.eye(6)
    sums = np.einsum("mkt,mk->mt", weighted, heights)
    return np.linalg.solve(matrices, sums[:, :, None])[:, 0, 0]
