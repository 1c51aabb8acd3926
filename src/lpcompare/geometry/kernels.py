"""Compiled kernels: a k-d tree, and least-squares planes and quadrics over neighbourhoods.

numba compiles each kernel once and keeps the result in the folder of the package, or in the user's cache
where that folder cannot be written. It looks at the file of a kernel only: who edits this file removes the
folders ``__pycache__`` of those that call it. The kernels release the interpreter lock and take one block of
points each, so that `lpcompare.threads.for_blocks` runs them in parallel with the same results on any number
of threads.

The tree is a perfect one: node ``i`` has the children ``2 i + 1`` and ``2 i + 2``, every node halves its
points along the widest side of its box, and the leaves are the last level. It keeps the points in the order of
its leaves, which is also a space-filling order.
"""

from __future__ import annotations

import numpy as np
from numba import njit

LEAF = 16
"""Most points of a leaf."""

_NEWTON_STEPS = 8
_NEWTON_LAST = 1e-9
_ALONE = 0.02
_RIDGE = 1e-10
_NO_SUMS = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@njit(cache=True, nogil=True)
def build_tree(points, order, starts, boxes, node, n_levels):
    """Sort ``points`` and ``order`` in place below one node, whose range is known, over some levels.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    order : ndarray of int32, shape (n,)
        Moved as the points are.
    starts : ndarray of int64, shape (nodes, 2)
        First point of each node and the one after its last.
    boxes : ndarray, shape (nodes, 6)
        Least and largest coordinates of each node.
    node, n_levels : int
    """
    first, width = node, 1
    for _ in range(n_levels):
        for parent in range(first, first + width):
            begin, end = starts[parent]
            box = boxes[parent]
            _bound(points, begin, end, box)
            child = 2 * parent + 1
            if child < len(starts):
                axis = np.argmax(box[3:] - box[:3])
                middle = (begin + end) // 2
                _split(points, order, begin, end, middle, axis)
                starts[child, 0], starts[child, 1] = begin, middle
                starts[child + 1, 0], starts[child + 1, 1] = middle, end
        first, width = 2 * first + 1, 2 * width


@njit(cache=True, nogil=True)
def _bound(points, begin, end, box):
    for i in range(3):
        box[i], box[3 + i] = np.inf, -np.inf
    for row in range(begin, end):
        for i in range(3):
            value = points[row, i]
            box[i] = min(box[i], value)
            box[3 + i] = max(box[3 + i], value)


@njit(cache=True, nogil=True)
def _split(points, order, begin, end, middle, axis):
    """Hoare's selection: no point before ``middle`` lies above one from there on along the axis."""
    low, high = begin, end - 1
    while low < high:
        a, b, c = points[low, axis], points[(low + high) // 2, axis], points[high, axis]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while points[i, axis] < pivot:
                i += 1
            while points[j, axis] > pivot:
                j -= 1
            if i <= j:
                for k in range(3):
                    points[i, k], points[j, k] = points[j, k], points[i, k]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@njit(cache=True, nogil=True)
def _box_distance(box, x, y, z):
    """Squared distance of a place to a box."""
    dx = max(box[0] - x, x - box[3], 0.0)
    dy = max(box[1] - y, y - box[4], 0.0)
    dz = max(box[2] - z, z - box[5], 0.0)
    return dx * dx + dy * dy + dz * dz


@njit(cache=True, nogil=True)
def nearest_of(x, y, z, points, starts, boxes, distances, rows):
    """The nearest points of a place, ascending: squared ``distances`` (k,) and ``rows`` (k,) are filled.

    ``distances`` bounds the search: only points closer than its last entry are found.
    """
    n_inner = len(starts) // 2
    last = len(distances) - 1
    stack = np.empty(64, np.int32)
    gaps = np.empty(64)
    stack[0], gaps[0], depth = 0, _box_distance(boxes[0], x, y, z), 1
    while depth:
        depth -= 1
        node = stack[depth]
        if gaps[depth] >= distances[last]:
            continue
        while node < n_inner:
            left = 2 * node + 1
            near, far = _box_distance(boxes[left], x, y, z), _box_distance(boxes[left + 1], x, y, z)
            node = left
            if far < near:
                near, far = far, near
                node = left + 1
            if far < distances[last]:
                stack[depth], gaps[depth] = (2 * left + 1) - node, far
                depth += 1
            if near >= distances[last]:
                node = -1
                break
        if node < 0:
            continue
        for row in range(starts[node, 0], starts[node, 1]):
            dx, dy, dz = points[row, 0] - x, points[row, 1] - y, points[row, 2] - z
            distance = dx * dx + dy * dy + dz * dz
            if distance < distances[last]:
                i = last
                while i > 0 and distances[i - 1] > distance:
                    distances[i], rows[i] = distances[i - 1], rows[i - 1]
                    i -= 1
                distances[i], rows[i] = distance, row


@njit(cache=True, nogil=True)
def query_block(queries, points, starts, boxes, distances, rows):
    """`nearest_of` for every query of a block."""
    for q in range(len(queries)):
        distances[q] = np.inf
        nearest_of(queries[q, 0], queries[q, 1], queries[q, 2], points, starts, boxes, distances[q], rows[q])


@njit(cache=True, nogil=True)
def gather(low, high, radius, points, starts, boxes, found):
    """Fill ``found`` with the points closer to a box than ``radius``; their number.

    ``radius`` is squared; at least as many places as the tree has points are needed.
    """
    n_inner = len(starts) // 2
    stack = np.empty(64, np.int32)
    stack[0], depth, count = 0, 1, 0
    while depth:
        depth -= 1
        node = stack[depth]
        if _box_to_box(boxes[node], low, high) >= radius:
            continue
        if node < n_inner:
            stack[depth], stack[depth + 1] = 2 * node + 2, 2 * node + 1
            depth += 2
            continue
        for row in range(starts[node, 0], starts[node, 1]):
            distance = 0.0
            for i in range(3):
                distance += max(low[i] - points[row, i], points[row, i] - high[i], 0.0) ** 2
            if distance < radius:
                found[count] = row
                count += 1
    return count


@njit(cache=True, nogil=True)
def _box_to_box(box, low, high):
    distance = 0.0
    for i in range(3):
        distance += max(low[i] - box[3 + i], box[i] - high[i], 0.0) ** 2
    return distance


@njit(cache=True, nogil=True)
def least_direction(xx, yy, zz, xy, xz, yz):
    """Unit eigenvector of the least eigenvalue of a symmetric 3 x 3 matrix; the sign is arbitrary.

    Newton's iteration from zero finds the least root of the characteristic cubic; where that root stands
    alone, its eigenvector is a cross product of two rows. Else all roots come from the trigonometric solution
    (Smith, CACM 4(4), 1961): of the two outer ones, the one that stands alone is treated so, and if it is the
    largest, the least direction is found in the plane across it, where the matrix is 2 x 2.
    """
    trace = xx + yy + zz
    if not trace > 0.0:
        return 0.0, 0.0, 1.0
    xx, yy, zz, xy, xz, yz = xx / trace, yy / trace, zz / trace, xy / trace, xz / trace, yz / trace
    minors = xx * yy + xx * zz + yy * zz - xy * xy - xz * xz - yz * yz
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    root = 0.0
    for _ in range(_NEWTON_STEPS):
        slope = (3 * root - 2) * root + minors
        if slope < _ALONE:
            break
        step = (determinant - ((root - 1) * root + minors) * root) / slope
        root += step
        if abs(step) < _NEWTON_LAST:
            return _null_direction(xx - root, yy - root, zz - root, xy, xz, yz)
    return _least_direction_of_three(xx, yy, zz, xy, xz, yz)


@njit(cache=True, nogil=True)
def _least_direction_of_three(xx, yy, zz, xy, xz, yz):
    """`least_direction` of a matrix of trace one, from all its eigenvalues."""
    a, b, c = xx - 1 / 3, yy - 1 / 3, zz - 1 / 3
    spread = np.sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    if spread == 0.0:
        return 0.0, 0.0, 1.0
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    angle = np.arccos(min(max(determinant / (2 * spread**3), -1.0), 1.0)) / 3
    if determinant < 0:
        root = 2 * spread * np.cos(angle + 2 * np.pi / 3)
        return _null_direction(a - root, b - root, c - root, xy, xz, yz)
    root = 2 * spread * np.cos(angle)
    ux, uy, uz, vx, vy, vz = tangents(*_null_direction(a - root, b - root, c - root, xy, xz, yz))
    ax, ay, az = xx * ux + xy * uy + xz * uz, xy * ux + yy * uy + yz * uz, xz * ux + yz * uy + zz * uz
    bx, by, bz = xx * vx + xy * vy + xz * vz, xy * vx + yy * vy + yz * vz, xz * vx + yz * vy + zz * vz
    across, along = (
        2 * (vx * ax + vy * ay + vz * az),
        ux * ax + uy * ay + uz * az - vx * bx - vy * by - vz * bz,
    )
    turn = 0.5 * np.arctan2(across, along)
    p, q = -np.sin(turn), np.cos(turn)
    return p * ux + q * vx, p * uy + q * vy, p * uz + q * vz


@njit(cache=True, nogil=True)
def _null_direction(xx, yy, zz, xy, xz, yz):
    """Unit vector across the rows of a singular symmetric matrix of rank two: their longest cross product."""
    ax, ay, az = xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy
    bx, by, bz = xy * zz - xz * yz, xz * xz - xx * zz, xx * yz - xy * xz
    cx, cy, cz = yy * zz - yz * yz, yz * xz - xy * zz, xy * yz - yy * xz
    aa, bb, cc = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
    if bb > aa and bb >= cc:
        ax, ay, az, aa = bx, by, bz, bb
    elif cc > aa:
        ax, ay, az, aa = cx, cy, cz, cc
    if aa == 0.0:
        return 0.0, 0.0, 1.0
    length = np.sqrt(aa)
    return ax / length, ay / length, az / length


@njit(cache=True, nogil=True)
def tangents(x, y, z):
    """Two unit vectors that make a right-handed frame with a unit vector.

    Duff and others, Building an orthonormal basis, revisited, JCGT 6(1), 2017.
    """
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return 1.0 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y


@njit(cache=True, nogil=True)
def _moments(points, rows, begin, end, sums):
    """Add offsets from the first of the points ``rows``, and their products, to nine sums."""
    ox, oy, oz = points[rows[0], 0], points[rows[0], 1], points[rows[0], 2]
    sx, sy, sz, sxx, syy, szz, sxy, sxz, syz = sums
    for j in range(begin, end):
        row = rows[j]
        dx, dy, dz = points[row, 0] - ox, points[row, 1] - oy, points[row, 2] - oz
        sx, sy, sz = sx + dx, sy + dy, sz + dz
        sxx, syy, szz = sxx + dx * dx, syy + dy * dy, szz + dz * dz
        sxy, sxz, syz = sxy + dx * dy, sxz + dx * dz, syz + dy * dz
    return sx, sy, sz, sxx, syy, szz, sxy, sxz, syz


@njit(cache=True, nogil=True)
def _plane(sums, size):
    """Centroid, as an offset, and unit normal of the plane through the points of `_moments`."""
    sx, sy, sz, sxx, syy, szz, sxy, sxz, syz = sums
    x, y, z = sx / size, sy / size, sz / size
    xx, yy, zz = sxx / size - x * x, syy / size - y * y, szz / size - z * z
    xy, xz, yz = sxy / size - x * y, sxz / size - x * z, syz / size - y * z
    return (x, y, z), least_direction(xx, yy, zz, xy, xz, yz)


@njit(cache=True, nogil=True)
def principal_direction(points, rows):
    """Unit direction in which the points ``rows`` (k,) spread most: the least direction of what is left."""
    size = len(rows)
    x, y, z, xx, yy, zz, xy, xz, yz = _moments(points, rows, 0, size, _NO_SUMS)
    xx, yy, zz = xx - x * x / size, yy - y * y / size, zz - z * z / size
    xy, xz, yz = xy - x * y / size, xz - x * z / size, yz - y * z / size
    return least_direction(yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)


@njit(cache=True, nogil=True)
def mean_plane_distance(x, y, z, points, rows, sizes):
    """Distance of a place to the planes through its nearest points, averaged over neighbourhood sizes.

    ``rows`` (k,) are nearest first; ``sizes`` ascend from 3 to k.
    """
    first = rows[0]
    x, y, z = x - points[first, 0], y - points[first, 1], z - points[first, 2]
    sums, taken, total = _NO_SUMS, 0, 0.0
    for size in sizes:
        sums = _moments(points, rows, taken, size, sums)
        taken = size
        (cx, cy, cz), (nx, ny, nz) = _plane(sums, size)
        total += abs((x - cx) * nx + (y - cy) * ny + (z - cz) * nz)
    return total / len(sizes)


@njit(cache=True, nogil=True)
def plane_distance_block(queries, points, rows, sizes, distances):
    """`mean_plane_distance` of every query (q, 3) to the planes through the points ``rows`` (q, k)."""
    for q in range(len(queries)):
        x, y, z = queries[q]
        distances[q] = mean_plane_distance(x, y, z, points, rows[q], sizes)


@njit(cache=True, nogil=True)
def plane_block(points, rows, centroids, normals):
    """Planes through the points ``rows`` (q, k): ``centroids`` and ``normals`` (q, 3) are filled."""
    size = rows.shape[1]
    for q in range(len(rows)):
        center, normal = _plane(_moments(points, rows[q], 0, size, _NO_SUMS), size)
        for i in range(3):
            centroids[q, i] = points[rows[q, 0], i] + center[i]
            normals[q, i] = normal[i]


@njit(cache=True, nogil=True)
def quadric_block(points, queries, rows, curvatures):
    """Mean and Gaussian curvature (q, 2) at each query of the quadric fitted to the points ``rows`` (q, k).

    The offsets are scaled to a root mean square of one and written in the frame of their PCA plane, where
    ``w = c + p u + q v + r uu/2 + s uv + t vv/2`` is fitted by the normal equations.
    """
    size = rows.shape[1]
    offsets, all_rows = np.empty((size, 3)), np.arange(size)
    basis, system = np.ones(7), np.empty((6, 7))
    for query in range(len(queries)):
        total = 0.0
        for j in range(size):
            for i in range(3):
                offsets[j, i] = points[rows[query, j], i] - queries[query, i]
                total += offsets[j, i] * offsets[j, i]
        length = np.sqrt(total / size) if total > 0 else 1.0
        offsets /= length
        _, (nx, ny, nz) = _plane(_moments(offsets, all_rows, 0, size, _NO_SUMS), size)
        ux, uy, uz, vx, vy, vz = tangents(nx, ny, nz)
        system[:] = 0.0
        for j in range(size):
            x, y, z = offsets[j]
            u, v = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz
            basis[1], basis[2], basis[3], basis[4], basis[5] = u, v, u * u / 2, u * v, v * v / 2
            basis[6] = x * nx + y * ny + z * nz
            for a in range(6):
                for b in range(a, 7):
                    system[a, b] += basis[a] * basis[b]
        # s counts twice in the norm of a quadratic form, which keeps the ridge independent of the tangents
        for a in range(6):
            system[a, a] += _RIDGE * size * (2 if a == 4 else 1)
        _eliminate(system)
        p, q, r, s, t = system[1, 6], system[2, 6], system[3, 6], system[4, 6], system[5, 6]
        steep = 1.0 + p * p + q * q
        mean = ((1 + q * q) * r - 2 * p * q * s + (1 + p * p) * t) / (2 * steep * np.sqrt(steep))
        curvatures[query, 0] = mean / length
        curvatures[query, 1] = (r * t - s * s) / (steep * steep) / length**2


@njit(cache=True, nogil=True)
def _eliminate(system):
    """Solve a positive definite system (m, m + 1), given above its diagonal, into its last column."""
    size = len(system)
    for a in range(size):
        for b in range(a + 1, size):
            factor = system[a, b] / system[a, a]
            for c in range(b, size + 1):
                system[b, c] -= factor * system[a, c]
    for a in range(size - 1, -1, -1):
        for b in range(a + 1, size):
            system[a, size] -= system[a, b] * system[b, size]
        system[a, size] /= system[a, a]
