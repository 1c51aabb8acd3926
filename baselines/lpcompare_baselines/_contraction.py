"""Contraction of point pairs in the order of their quadric error, compiled; `pauly_iterative` explains it.

The quadric of a point is the function Q(x) = x'Ax + 2 b'x + c of the place x relative to the point itself, so
that large coordinates cost no digits. It is kept as ten numbers: xx, xy, xz, yy, yz, zz of A, then b, then c.
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np
from numba import njit

ROUNDING = 1e-12
"""Share of the largest eigenvalue, and of the mean squared length of a pair, that is rounding."""


@njit(cache=True)
def tangent_quadrics(points, normals, neighbors):
    """Sum of the squared distances to the planes through a point that hold an edge and stand on the surface.

    The plane of the edge e to a neighbor is spanned by e and e x n; its unit normal is the part of the
    point's normal n that is orthogonal to e (Pauly, Gross and Kobbelt 2002, section 3.2). An edge along n has
    no such plane.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    normals : ndarray, shape (n, 3)
        Unit length, the sign does not matter.
    neighbors : ndarray of int, shape (n, k)

    Returns
    -------
    ndarray, shape (n, 10)
    """
    quadrics = np.zeros((len(points), 10))
    for row in range(len(points)):
        for other in neighbors[row]:
            edge = points[other] - points[row]
            length = np.dot(edge, edge)
            if length == 0.0:
                continue
            plane = normals[row] - (normals[row] * edge).sum() / length * edge
            size = np.dot(plane, plane)
            if size < ROUNDING:
                continue
            entry = 0
            for i in range(3):
                for j in range(i, 3):
                    quadrics[row, entry] += plane[i] * plane[j] / size
                    entry += 1
    return quadrics


@njit(cache=True)
def shifted(quadric, offset):
    """The quadric relative to a place that lies at ``offset`` (3,) from the one that it is relative to."""
    moved = quadric.copy()
    xx, xy, xz, yy, yz, zz = quadric[0], quadric[1], quadric[2], quadric[3], quadric[4], quadric[5]
    x, y, z = offset[0], offset[1], offset[2]
    ax, ay, az = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
    moved[6], moved[7], moved[8] = quadric[6] + ax, quadric[7] + ay, quadric[8] + az
    # c + 2 b'x + x'Ax
    moved[9] += x * (quadric[6] + moved[6]) + y * (quadric[7] + moved[7]) + z * (quadric[8] + moved[8])
    return moved


@njit(cache=True)
def least(quadric, smallest, place):
    """Least value of a quadric, 0 or more; fills in the place of it that is nearest to the origin.

    Eigenvalues of A up to ``smallest`` times the largest count as zero: along them the place does not move.
    """
    matrix = np.zeros((3, 3))
    matrix[0, 0], matrix[1, 0], matrix[2, 0] = quadric[0], quadric[1], quadric[2]
    matrix[1, 1], matrix[2, 1], matrix[2, 2] = quadric[3], quadric[4], quadric[5]
    values, vectors = np.linalg.eigh(matrix)
    value = quadric[9]
    place[:] = 0.0
    for i in range(3):
        if values[i] > smallest * values[2]:
            slope = quadric[6] * vectors[0, i] + quadric[7] * vectors[1, i] + quadric[8] * vectors[2, i]
            value -= slope * slope / values[i]
            for j in range(3):
                place[j] -= slope / values[i] * vectors[j, i]
    return max(value, 0.0)


@njit(cache=True)
def _end_values(points, quadrics, first, second):
    """Value of the sum of two rows' quadrics at the first row and at the second."""
    step = points[second] - points[first]
    at_first = quadrics[first, 9] + shifted(quadrics[second], -step)[9]
    return at_first, quadrics[second, 9] + shifted(quadrics[first], step)[9]


@njit(cache=True)
def _at_middle(points, quadrics, first, second):
    """Sum of two rows' quadrics, relative to the middle of the pair."""
    half = (points[second] - points[first]) / 2
    return shifted(quadrics[first], half) + shifted(quadrics[second], -half)


@njit(cache=True)
def _entry(points, quadrics, stamps, first, second, subset, floor):
    """What the heap holds of a pair: cost, squared length, both rows and when they last changed."""
    if subset:
        cost = min(_end_values(points, quadrics, first, second))
    else:
        cost = least(_at_middle(points, quadrics, first, second), ROUNDING, np.empty(3))
    step = points[second] - points[first]
    return max(cost, floor), np.dot(step, step), first, second, stamps[first], stamps[second]


@njit(cache=True)
def _drop(neighbors, degrees, row, other):
    """Take a row out of another one's list."""
    for slot in range(degrees[other]):
        if neighbors[other, slot] == row:
            degrees[other] -= 1
            neighbors[other, slot] = neighbors[other, degrees[other]]
            return


@njit(cache=True)
def link(pairs, neighbors, degrees):
    """Enter pairs into both rows' lists, in the given order, as long as both have room."""
    room = neighbors.shape[1]
    for first, second in pairs:
        if degrees[first] < room and degrees[second] < room:
            neighbors[first, degrees[first]], neighbors[second, degrees[second]] = second, first
            degrees[first] += 1
            degrees[second] += 1


@njit(cache=True)
def _inherit(points, neighbors, degrees, kept, gone):
    """Give the kept row the neighbors of both, at most as many as fit, the nearest ones."""
    room = neighbors.shape[1]
    found = np.empty(2 * room, dtype=np.intp)
    n_found = 0
    for row, other in ((kept, gone), (gone, kept)):
        for slot in range(degrees[row]):
            neighbor = neighbors[row, slot]
            if neighbor != other and neighbor not in found[:n_found]:
                found[n_found] = neighbor
                n_found += 1
    for neighbor in found[:n_found]:
        _drop(neighbors, degrees, kept, neighbor)
        _drop(neighbors, degrees, gone, neighbor)
    lengths = np.empty(n_found)
    for i in range(n_found):
        step = points[found[i]] - points[kept]
        lengths[i] = np.dot(step, step)
    degrees[kept] = degrees[gone] = 0
    for i in np.argsort(lengths)[:room]:
        neighbor = found[i]
        neighbors[kept, degrees[kept]], neighbors[neighbor, degrees[neighbor]] = neighbor, kept
        degrees[kept] += 1
        degrees[neighbor] += 1


@njit(cache=True)
def contract(points, quadrics, neighbors, degrees, alive, costs, subset, smallest, floor):
    """Contract the cheapest pair of neighbors, again and again; everything is changed in place.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    quadrics : ndarray, shape (n, 10)
        Those of the rows; the one that is kept of a pair gets the sum.
    neighbors : ndarray of int, shape (n, room)
        Each row stands in the lists of its neighbors.
    degrees : ndarray of int, shape (n,)
        Length of each list.
    alive : ndarray of bool, shape (n,)
    costs : ndarray, shape (m,)
        Filled with the cost of each contraction; its length is how many are wanted.
    subset : bool
        A pair moves to one of its ends, else to the place of least cost.
    smallest : float
        Share of the largest eigenvalue up to which a direction counts as flat, for that place.
    floor : float
        Costs below it are rounding: equal, so that the length of the pair decides.

    Returns
    -------
    int
        Contractions made: fewer than wanted when no pair is left.
    """
    stamps = np.zeros(len(points), dtype=np.intp)
    waiting = [
        _entry(points, quadrics, stamps, row, other, subset, floor)
        for row in range(len(points))
        for other in neighbors[row, : degrees[row]]
        if row < other
    ]
    heapify(waiting)
    done, place = 0, np.zeros(3)
    while waiting and done < len(costs):
        cost, _, kept, gone, stamp, other_stamp = heappop(waiting)
        if not (alive[kept] and alive[gone] and stamps[kept] == stamp and stamps[gone] == other_stamp):
            continue
        place[:] = 0.0
        if subset:
            at_kept, at_gone = _end_values(points, quadrics, kept, gone)
            if at_gone < at_kept:
                kept, gone = gone, kept
        else:
            least(_at_middle(points, quadrics, kept, gone), smallest, place)
            place += (points[gone] - points[kept]) / 2
        rest = points[kept] + place - points[gone]
        quadrics[kept] = shifted(quadrics[kept], place) + shifted(quadrics[gone], rest)
        points[kept] += place
        alive[gone] = False
        stamps[kept] += 1
        costs[done] = cost
        done += 1
        _inherit(points, neighbors, degrees, kept, gone)
        for other in neighbors[kept, : degrees[kept]]:
            heappush(waiting, _entry(points, quadrics, stamps, kept, other, subset, floor))
    return done
