"""Distance of two convex solids, from below: by the planes between them that GJK finds.

For any direction, the least of what one solid reaches along it less the most of what the other does is a lower bound of
their distance, whatever led to that direction. So a distance is never called larger than it is, however the search
ends; where the solids meet, the ball about the origin within their difference tells how deep at least.

Source: E. Gilbert, D. Johnson, S. Keerthi, A fast procedure for computing the distance between complex objects in
three-dimensional space, IEEE J. Robotics and Automation 4(2), 1988.
"""

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import add, along, apply, apply_transposed, cross, dot, load3, norm, scale, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.shapes import AXIS, CENTRE, CYLINDER, FIRST, HALF, KIND, LAST, RADIUS

MOST_STEPS = 40
"""So many corners of the difference are looked at, at most."""

CLOSE = 1e-7
"""Bounds of the distance are taken this near to each other, m."""

NOWHERE = (0.0, 0.0, 0.0)

FACES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
"""Corners of each face of a tetrahedron."""


@kernel
def farthest_point(shapes, i, d):
    """The point of a solid, without its radius where it has points, that lies farthest in a direction."""
    solids = shapes.solids
    if shapes.of_solid[i, KIND] == CYLINDER:
        axis, centre = load3(row(solids, i), AXIS), load3(row(solids, i), CENTRE)
        level = dot(axis, d)
        point = along(centre, solids[i, HALF] if level > 0.0 else -solids[i, HALF], axis)
        beside = along(d, -level, axis)
        length = norm(beside)
        return along(point, solids[i, RADIUS] / length, beside) if length > 1e-12 else point
    points = shapes.points
    x, y, z = d
    best, at = -math.inf, 0
    for k in range(shapes.of_solid[i, FIRST], shapes.of_solid[i, LAST]):
        level = points[k, 0] * x + points[k, 1] * y + points[k, 2] * z
        if level > best:
            best, at = level, k
    return points[at, 0], points[at, 1], points[at, 2]


@kernel
def roundness(shapes, i):
    """The radius all around a solid that is no part of its farthest points."""
    return 0.0 if shapes.of_solid[i, KIND] == CYLINDER else shapes.solids[i, RADIUS]


@kernel
def corner(shapes, i, j, frame, d):
    """The point of the difference of two solids that lies farthest against a direction; `frame` is where i is for j."""
    M, b = frame
    one = add(apply(M, farthest_point(shapes, i, scale(-1.0, apply_transposed(M, d)))), b)
    return sub(one, farthest_point(shapes, j, d))


@kernel
def on_edge(a, b):
    """The point of an edge that is nearest to the origin, and which of its ends it needs, as bits."""
    ab = sub(b, a)
    length = dot(ab, ab)
    t = -dot(a, ab)
    if t <= 0.0 or length <= 0.0:
        return a, 1
    if t >= length:
        return b, 2
    return along(a, t / length, ab), 3


@kernel
def on_triangle(a, b, c):
    """The same of a triangle (after C. Ericson, Real-Time Collision Detection, 2005, 5.1.5)."""
    ab, ac = sub(b, a), sub(c, a)
    d1, d2 = -dot(ab, a), -dot(ac, a)
    if d1 <= 0.0 and d2 <= 0.0:
        return a, 1
    d3, d4 = -dot(ab, b), -dot(ac, b)
    if d3 >= 0.0 and d4 <= d3:
        return b, 2
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return along(a, d1 / (d1 - d3), ab), 3
    d5, d6 = -dot(ab, c), -dot(ac, c)
    if d6 >= 0.0 and d5 <= d6:
        return c, 4
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return along(a, d2 / (d2 - d6), ac), 5
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        return along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), sub(c, b)), 6
    whole = va + vb + vc
    if whole <= 0.0:
        return on_longest(a, b, c)
    return along(along(a, vb / whole, ab), vc / whole, ac), 7


@kernel
def on_longest(a, b, c):
    """The same of a triangle that is flat to a line."""
    best, used = on_edge(a, b)
    other, bits = on_edge(a, c)
    if dot(other, other) < dot(best, best):
        best, used = other, (bits & 1) | ((bits & 2) << 1)
    other, bits = on_edge(b, c)
    if dot(other, other) < dot(best, best):
        best, used = other, bits << 1
    return best, used


@kernel
def side(a, b, c, d):
    """Distance of the origin from the plane of a triangle, positive on the side away from d; 0 for a flat one."""
    n = cross(sub(b, a), sub(c, a))
    length = norm(n)
    if length <= 0.0:
        return 0.0
    away = dot(n, sub(d, a))
    return (dot(n, a) if away > 0.0 else -dot(n, a)) / length


@kernel
def on_tetrahedron(a, b, c, d):
    """The same of a tetrahedron, and how far the origin is inside of it (0 outside)."""
    faces = (side(a, b, c, d), side(a, b, d, c), side(a, c, d, b), side(b, c, d, a))
    outside = max(max(faces[0], faces[1]), max(faces[2], faces[3]))
    if outside < 0.0:
        return NOWHERE, 15, -outside
    corners = (a, b, c, d)
    best, used, least = a, 1, math.inf
    for face in range(4):
        if faces[face] >= 0.0:
            i, j, k = FACES[face]
            point, bits = on_triangle(corners[i], corners[j], corners[k])
            if dot(point, point) < least:
                best, least = point, dot(point, point)
                used = (bits & 1) << i | (bits >> 1 & 1) << j | (bits >> 2) << k
    return best, used, 0.0


@kernel
def on_simplex(corners, n):
    """The point of the first n of four corners' hull that is nearest to the origin, the corners it needs, and depth."""
    a, b, c, d = corners
    if n == 1:
        return a, 1, 0.0
    if n == 2:
        point, used = on_edge(a, b)
        return point, used, 0.0
    if n == 3:
        point, used = on_triangle(a, b, c)
        return point, used, 0.0
    return on_tetrahedron(a, b, c, d)


@kernel
def with_corner(corners, k, w):
    """Four corners with number k replaced."""
    a, b, c, d = corners
    return (w if k == 0 else a, w if k == 1 else b, w if k == 2 else c, w if k == 3 else d)


@kernel
def apart(shapes, i, j, frame, start, enough):
    """How far two solids are apart at least, m, and the unit normal of a plane between them, pointing from j to i.

    All is told in the frame of j; `frame` is where i is for it, matrix and shift. The search begins at `start`, the
    normal that was found before, and ends where it is `enough`, m. Where they meet, it is minus a depth that they have
    at least.
    """
    round_ = roundness(shapes, i) + roundness(shapes, j)
    v, normal = start, start
    best, nearest = -math.inf, math.inf
    corners, n = (NOWHERE, NOWHERE, NOWHERE, NOWHERE), 0
    for _ in range(MOST_STEPS):
        length = norm(v)
        if length <= 1e-12:
            return -round_, normal
        w = corner(shapes, i, j, frame, v)
        level = dot(v, w) / length - round_
        if level > best:
            best, normal = level, scale(1.0 / length, v)
        if best >= enough or nearest - round_ - best <= CLOSE:
            break
        corners = with_corner(corners, n, w)
        v, used, depth = on_simplex(corners, n + 1)
        if depth > 0.0:
            return -depth - round_, normal
        reached = norm(v)
        if reached >= nearest - 1e-12 and n > 0:
            # No step brings the origin nearer: as near as rounding allows.
            break
        nearest = reached
        # Corners that the nearest point needs, first.
        known, n = corners, 0
        for k in range(4):
            if used >> k & 1:
                corners, n = with_corner(corners, n, known[k]), n + 1
        if n == 4:
            return -round_, normal
    # They meet within their radii, or rounding hides whether they do.
    return (best if best > 0.0 else min(nearest - round_, 0.0)), normal
