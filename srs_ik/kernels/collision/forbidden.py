"""The arm angles that bodies forbid, for one elbow: exact for spheres, and no less than all for convex solids.

A sphere at the distance a from the line S-W, which turns about it, and one at the distance c that stands still, d apart
along the line, come closer than r where cos(psi - phi) > (a^2 + c^2 + d^2 - r^2) / (2 a c): one arc. Whether there is
any is told by (a - c)^2 + d^2 alone, the distance of two points of a half-plane.
"""

import math

from srs_ik.kernels.collision.arcs import add_all, add_arc, add_complement, is_all
from srs_ik.kernels.collision.seen import is_turning, see_group
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import EXTENT, FIRST, KIND, LAST, PLANES, RHO, U, X, Y


@kernel
def forbid_sphere(local, i, j, reach, arcs, n):
    """Add the arc that the turning sphere i and the still sphere j forbid."""
    along = local[i, U] - local[j, U]
    apart = local[i, RHO] - local[j, RHO]
    both = local[i, RHO] + local[j, RHO]
    rest = along * along - reach * reach
    near = rest + apart * apart
    far = rest + both * both
    if near >= 0.0:
        return n
    if far <= 0.0:
        return add_all(arcs)
    half = math.atan2(math.sqrt(-near * far), 0.5 * (near + far))
    xa, ya, xc, yc = local[i, X], local[i, Y], local[j, X], local[j, Y]
    return add_arc(arcs, n, math.atan2(xa * yc - ya * xc, xa * xc + ya * yc), half)


@kernel
def may_meet(local, i, j, more):
    """Whether a turning sphere meets a still one at any arm angle."""
    along = local[i, U] - local[j, U]
    apart = local[i, RHO] - local[j, RHO]
    reach = local[i, EXTENT] + local[j, EXTENT] + more
    return along * along + apart * apart < reach * reach


@kernel
def forbid_solid(world, i, g, more, arcs, n, free):
    """Add arcs at which the turning sphere i may meet the convex solid g: where no plane of it is far enough away."""
    local = world.local
    reach = local[i, EXTENT] + more
    u, rho = local[i, U], local[i, RHO]
    first, last = world.groups[g, FIRST], world.groups[g, LAST]
    for j in range(first, last):
        if local[j, U] * u - rho * local[j, RHO] >= local[j, EXTENT] + reach:
            return n
    count = 0
    for j in range(first, last):
        level = local[j, EXTENT] + reach - local[j, U] * u
        swing = rho * local[j, RHO]
        # Beyond the plane where the cosine is larger than level / swing; nowhere if that is 1 or more.
        if level >= swing:
            continue
        half = math.atan2(math.sqrt((swing - level) * (swing + level)), level)
        xa, ya, xn, yn = local[i, X], local[i, Y], local[j, X], local[j, Y]
        count = add_arc(free, count, math.atan2(xa * yn - ya * xn, xa * xn + ya * yn), half)
    return add_complement(arcs, n, free, count)


@kernel
def never_meets(world, i, g, more):
    """Whether one plane of a convex solid always lies between it and a turning sphere."""
    local = world.local
    for j in range(world.groups[g, FIRST], world.groups[g, LAST]):
        swing = local[i, RHO] * local[j, RHO]
        if local[j, U] * local[i, U] - swing >= local[j, EXTENT] + local[i, EXTENT] + more:
            return True
    return False


@kernel
def distance_of(local, i, j):
    """Distance of two rows that do not move against each other."""
    u, x, y = local[i, U] - local[j, U], local[i, X] - local[j, X], local[i, Y] - local[j, Y]
    return math.sqrt(u * u + x * x + y * y) - local[i, EXTENT] - local[j, EXTENT]


@kernel
def height_over(world, i, g):
    """How far a sphere, as it is seen, lies outside of a convex solid, at least."""
    local = world.local
    best = -math.inf
    for j in range(world.groups[g, FIRST], world.groups[g, LAST]):
        value = local[j, U] * local[i, U] + local[j, X] * local[i, X] + local[j, Y] * local[i, Y] - local[j, EXTENT]
        best = max(best, value)
    return best - local[i, EXTENT]


@kernel
def fixed_clearance(world, a, b, least):
    """Clearance of two groups that do not move against each other, or `least` where it is no less."""
    groups, local = world.groups, world.local
    for i in range(groups[a, FIRST], groups[a, LAST]):
        if groups[b, KIND] == PLANES:
            least = min(least, height_over(world, i, b))
        elif distance_of(local, i, b) < least:
            for j in range(groups[b, FIRST], groups[b, LAST]):
                least = min(least, distance_of(local, i, j))
    return least


@kernel
def forbid_spheres(world, a, b, more, arcs, n):
    """Add the arcs that two groups of spheres forbid, the first of which turns."""
    groups, local = world.groups, world.local
    for i in range(groups[a, FIRST], groups[a, LAST]):
        if may_meet(local, i, b, more):
            for j in range(groups[b, FIRST], groups[b, LAST]):
                if may_meet(local, i, j, more):
                    n = forbid_sphere(local, i, j, local[i, EXTENT] + local[j, EXTENT] + more, arcs, n)
    return n


@kernel
def forbid_planes(world, a, b, more, arcs, n, free):
    """Add the arcs that a group of spheres, which turns, and a convex solid may forbid."""
    for i in range(world.groups[a, FIRST], world.groups[a, LAST]):
        if may_meet(world.local, i, b, more):
            n = forbid_solid(world, i, b, more, arcs, n, free)
    return n


@kernel
def forbid_pair(world, k, elbow, frames, more, arcs, n, free):
    """Add the arm angles that row k of pairs forbids; the arguments are those of `forbid`, n pieces are there."""
    still, turning = frames
    a, b = world.pairs[k, 0], world.pairs[k, 1]
    if is_turning(world, a) and not is_turning(world, b):
        if not may_meet(world.local, a, b, more):
            return n
        see_group(world, b, elbow, still, turning)
        planes = world.groups[b, KIND] == PLANES
        if planes and never_meets(world, a, b, more):
            return n
        see_group(world, a, elbow, still, turning)
        return forbid_planes(world, a, b, more, arcs, n, free) if planes else forbid_spheres(world, a, b, more, arcs, n)
    if distance_of(world.local, a, b) < more:
        see_group(world, a, elbow, still, turning)
        see_group(world, b, elbow, still, turning)
        if fixed_clearance(world, a, b, more) < more:
            return add_all(arcs)
    return n


@kernel
def forbid(world, elbow, frames, more, arcs, free):
    """Write the forbidden arm angles of one elbow into arcs (MOST_ARCS, 2); return how many pieces they are.

    The balls of the world are seen, rows by `frames`, those of `seen.still_frames` and `seen.turning_frames`; `more` is
    what has to be left between two bodies, m, and `free` (MOST_ARCS, 2) work space.
    """
    n = 0
    for k in range(world.pairs.shape[0]):
        n = forbid_pair(world, k, elbow, frames, more, arcs, n, free)
        if is_all(arcs, n):
            return 1
    return n
