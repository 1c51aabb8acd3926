"""Triangles around every point of a cloud: its star in the tangential Delaunay complex, and distances to it.

The Voronoi cell of a point, cut by the tangent plane of the point, is a polygon. Each of its sides lies
between the point and one neighbour, and two sides that follow each other make a triangle. So the stars of
all points cover the surface without one radius for the whole cloud: they follow the local spacing. At a rim
the polygon is open, and so is the star. Stars are the cocones of Amenta, Choi, Dey and Leekha (A simple
algorithm for homeomorphic surface reconstruction, 2000) and the tangential complex of Boissonnat and Ghosh
(Manifold reconstruction using tangential Delaunay complexes, 2014), with one difference: stars that
contradict each other are all kept, so the triangles need not form a manifold.

The polygon is found by duality: with ``t`` the offset of a neighbour along the tangent plane and ``d`` its
distance, the sides are the corners of the convex hull of the points ``t / d**2`` and the origin.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpcompare.threads import for_blocks
from lpcompare.types import Indices, Mask, Points, Vector

_WIDTH = 16
"""Most neighbours of a star: 6 is the mean of a closed one."""


class Stars:
    """The stars of points.

    Parameters
    ----------
    sites : ndarray, shape (m, 3)
        The points, in model units. None has a star before `find`.

    Attributes
    ----------
    sites : ndarray, shape (m, 3)
    corners : ndarray of int, shape (m, 16)
        Neighbours of each point in the order of their angle; those after the first ``counts`` mean nothing.
    counts : ndarray of int, shape (m,)
    closed : ndarray of bool, shape (m,)
        Whether the last neighbour and the first make a triangle as well: false at a rim.
    """

    def __init__(self, sites: Points) -> None:
        self.sites = sites
        self.corners = np.zeros((len(sites), _WIDTH), dtype=np.int32)
        self.counts = np.zeros(len(sites), dtype=np.int32)
        self.closed = np.zeros(len(sites), dtype=np.bool_)

    def find(self, rows: Indices, normals: Points, nearest: NDArray[np.integer]) -> Mask:
        """Find the stars of some points.

        Parameters
        ----------
        rows : ndarray of int, shape (r,)
            The points.
        normals : ndarray, shape (m, 3)
            Unit normals; their sign does not matter.
        nearest : ndarray of int, shape (r, k)
            Neighbours of each that may be corners; 16 to 24 are enough. A point at the same place, and so
            the point itself, is passed over.

        Returns
        -------
        ndarray of bool, shape (m,)
            The points whose stars are others than before.
        """
        changed = np.zeros(len(self.sites), dtype=np.bool_)
        nearest = np.ascontiguousarray(nearest, dtype=np.int32)
        state = self.corners, self.counts, self.closed, changed
        for_blocks(
            len(rows), lambda block: find_stars(self.sites, normals, rows[block], nearest[block], *state)
        )
        return changed

    def take(self, rows: Indices) -> tuple[NDArray[np.int32], NDArray[np.int32], Mask]:
        """Copies of ``corners``, ``counts`` and ``closed`` of some points, for `put`."""
        return self.corners[rows], self.counts[rows], self.closed[rows]

    def put(self, rows: Indices, stars: tuple[NDArray[np.int32], NDArray[np.int32], Mask]) -> None:
        """Give some points the stars that `take` copied."""
        self.corners[rows], self.counts[rows], self.closed[rows] = stars

    def distances(self, queries: Points, nearest: NDArray[np.integer]) -> Vector:
        """Distance of each query to the triangles of some stars.

        Parameters
        ----------
        queries : ndarray, shape (q, 3)
        nearest : ndarray of int, shape (q, k)
            The points whose stars are looked at; without a triangle, the points themselves count.

        Returns
        -------
        ndarray, shape (q,)
            In model units.
        """
        result, everyone = np.empty(len(queries)), np.ones(len(queries), dtype=np.bool_)
        self.renew(queries, np.ascontiguousarray(nearest, dtype=np.int32), everyone, self.closed, result)
        return result

    def renew(
        self, queries: Points, nearest: NDArray[np.int32], moved: Mask, changed: Mask, distances: Vector
    ) -> None:
        """Bring ``distances`` (q,) up to date where ``moved`` (q,), or where one of the stars ``changed`` (m,)."""
        stars = self.sites, self.corners, self.counts, self.closed
        star_distances(queries, nearest, moved, changed, *stars, distances)


def make_stars(sites: Points, normals: Points, nearest: NDArray[np.integer]) -> Stars:
    """Find the star of every point; `Stars.find` says what is given."""
    stars = Stars(sites)
    stars.find(np.arange(len(sites)), normals, nearest)
    return stars


@njit(cache=True, nogil=True)
def find_stars(sites, normals, rows, nearest, corners, counts, closed, changed):
    """`Stars.find` of one block."""
    size, width = nearest.shape[1], corners.shape[1]
    duals, around = np.empty((size + 1, 2)), np.empty(size + 1, np.int32)
    hull, star = np.empty(2 * size + 4, np.int32), np.empty(width, np.int32)
    for i in range(len(rows)):
        site = rows[i]
        count = _dual_points(sites, site, normals[site], nearest[i], duals, around)
        n_found, is_closed = 0, False
        if count >= 3:
            n_corners = _convex_hull(duals, count, hull)
            first, is_closed = 0, True
            for j in range(n_corners):
                if around[hull[j]] < 0:  # the origin is a corner: the polygon is open
                    first, is_closed = j + 1, False
            for j in range(n_corners):
                row = around[hull[(first + j) % n_corners]]
                if row >= 0 and n_found < width:
                    star[n_found] = row
                    n_found += 1
        changed[site] = counts[site] != n_found or closed[site] != is_closed
        counts[site], closed[site] = n_found, is_closed
        for j in range(n_found):
            changed[site] |= corners[site, j] != star[j]
            corners[site, j] = star[j]


@njit(cache=True, nogil=True)
def _dual_points(sites, site, normal, nearest, duals, rows):
    """The points ``t / d**2`` of the neighbours, and the origin with the row -1; how many there are."""
    axis = 0
    for i in range(1, 3):
        if abs(normal[i]) < abs(normal[axis]):
            axis = i
    u, v = np.empty(3), np.empty(3)
    for i in range(3):
        u[i] = (1.0 if i == axis else 0.0) - normal[axis] * normal[i]
    u /= np.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    for i in range(3):
        v[i] = normal[(i + 1) % 3] * u[(i + 2) % 3] - normal[(i + 2) % 3] * u[(i + 1) % 3]
    count = 0
    for row in nearest:
        along, across, square = 0.0, 0.0, 0.0
        for i in range(3):
            offset = sites[row, i] - sites[site, i]
            along, across, square = along + offset * u[i], across + offset * v[i], square + offset * offset
        if square > 0:
            duals[count, 0], duals[count, 1], rows[count] = along / square, across / square, row
            count += 1
    duals[count], rows[count] = 0.0, -1
    return count + 1


@njit(cache=True, nogil=True)
def _convex_hull(points, count, hull):
    """Corners of the convex hull, counterclockwise (Andrew's monotone chain); how many there are."""
    order = np.argsort(points[:count, 0])
    size = 0
    for i in range(count):
        size = _append(points, hull, size, 1, order[i])
    lower = size
    for i in range(count - 2, -1, -1):
        size = _append(points, hull, size, lower, order[i])
    return size - 1


@njit(cache=True, nogil=True)
def _append(points, hull, size, least, corner):
    """Put a corner on the chain, after taking off those that it leaves inside."""
    while size > least:
        a, b = hull[size - 2], hull[size - 1]
        turn = (points[b, 0] - points[a, 0]) * (points[corner, 1] - points[a, 1])
        if turn - (points[b, 1] - points[a, 1]) * (points[corner, 0] - points[a, 0]) > 0:
            break
        size -= 1
    hull[size] = corner
    return size + 1


@njit(cache=True, nogil=True)
def star_distances(queries, nearest, moved, changed, sites, corners, counts, closed, distances):
    """`Stars.renew`."""
    for q in range(len(queries)):
        stale = moved[q]
        for site in nearest[q]:
            stale |= changed[site]
        if not stale:
            continue
        best = np.inf
        for site in nearest[q]:
            best = min(
                best, _star_distance(queries[q], sites, site, corners[site, : counts[site]], closed[site])
            )
        distances[q] = np.sqrt(best)


@njit(cache=True, nogil=True)
def _star_distance(p, sites, site, corners, closed):
    """Squared distance of a place to a star."""
    a, count = sites[site], len(corners)
    ap = _offset(a, p)
    best = _dot(ap, ap)
    if count < 2:
        return best
    ab = _offset(a, sites[corners[0]])
    d1 = _dot(ab, ap)
    for i in range(count if closed else count - 1):
        ac = _offset(a, sites[corners[(i + 1) % count]])
        d2 = _dot(ac, ap)
        if d1 > 0 or d2 > 0:  # else the site is the nearest place of the triangle
            best = min(best, _triangle_distance(p, ap, ab, ac, d1, d2, sites[corners[i]]))
        ab, d1 = ac, d2
    return best if closed else min(best, _edge_distance(ap, ab))


@njit(cache=True, nogil=True)
def _triangle_distance(p, ap, ab, ac, d1, d2, b):
    """Squared distance of a place to a triangle of a star (Ericson, Real-time collision detection, 5.1.5).

    The edge ac is left to the next triangle of the star, whose edge ab it is.
    """
    bp = _offset(b, p)
    cp = ap[0] - ac[0], ap[1] - ac[1], ap[2] - ac[2]
    d3, d4, d5, d6 = _dot(ab, bp), _dot(ac, bp), _dot(ab, cp), _dot(ac, cp)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if va > 0 and vb > 0 and vc > 0:
        x = ap[0] * (ab[1] * ac[2] - ab[2] * ac[1]) + ap[1] * (ab[2] * ac[0] - ab[0] * ac[2])
        height = x + ap[2] * (ab[0] * ac[1] - ab[1] * ac[0])
        return height * height / (va + vb + vc)
    return min(_edge_distance(ap, ab), _edge_distance(bp, (ac[0] - ab[0], ac[1] - ab[1], ac[2] - ab[2])))


@njit(cache=True, nogil=True)
def _edge_distance(ap, ab):
    """Squared distance of a place to an edge; both as offsets from the first end of the edge."""
    square = _dot(ab, ab)
    share = min(max(_dot(ap, ab) / square, 0.0), 1.0) if square > 0 else 0.0
    x, y, z = ap[0] - share * ab[0], ap[1] - share * ab[1], ap[2] - share * ab[2]
    return x * x + y * y + z * z


@njit(cache=True, nogil=True)
def _offset(a, b):
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@njit(cache=True, nogil=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
