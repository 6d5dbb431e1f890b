"""How far bodies are from each other at an arm angle, and the arm angle at which that is most, over all of them.

A body that turns about the line S-W moves no farther than its distance from it times the angle: so between two arm
angles the clearance is known within bounds, and what cannot hold the largest is left out.
"""

import math

from srs_ik.kernels.collision.forbidden import distance_of, fixed_clearance
from srs_ik.kernels.collision.seen import is_turning, see_group
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import EXTENT, FIRST, KIND, LAST, NO_GROUP, PLANES, RHO, U, X, Y

MOST_PARTS = 512
"""Room for the parts of an interval that may hold the largest clearance."""


@kernel
def turned_distance(local, i, j, turn):
    """Distance of the turning sphere i, at an arm angle given by cosine and sine, and the still sphere j."""
    c, s = turn
    u = local[i, U] - local[j, U]
    x = c * local[i, X] - s * local[i, Y] - local[j, X]
    y = s * local[i, X] + c * local[i, Y] - local[j, Y]
    return math.sqrt(u * u + x * x + y * y) - local[i, EXTENT] - local[j, EXTENT]


@kernel
def turned_height(world, i, g, turn, enough):
    """How far the turning sphere i lies outside of a convex solid at an arm angle, at least, or no less than enough."""
    local = world.local
    c, s = turn
    u = local[i, U]
    x = c * local[i, X] - s * local[i, Y]
    y = s * local[i, X] + c * local[i, Y]
    best = -math.inf
    enough += local[i, EXTENT]
    for j in range(world.groups[g, FIRST], world.groups[g, LAST]):
        best = max(best, local[j, U] * u + local[j, X] * x + local[j, Y] * y - local[j, EXTENT])
        if best >= enough:
            break
    return best - local[i, EXTENT]


@kernel
def pair_clearance(world, a, b, turn, least):
    """Clearance of two groups, the first of which turns, or `least` where it is no less."""
    groups, local = world.groups, world.local
    planes = groups[b, KIND] == PLANES
    for i in range(groups[a, FIRST], groups[a, LAST]):
        if planes:
            least = min(least, turned_height(world, i, b, turn, least))
        elif turned_distance(local, i, b, turn) < least:
            for j in range(groups[b, FIRST], groups[b, LAST]):
                least = min(least, turned_distance(local, i, j, turn))
    return least


@kernel
def turning_clearance(world, elbow, frames, psi, begin, bounds):
    """Least clearance at an arm angle of all pairs that it moves against each other, and the pair: m, row of pairs.

    Pairs are looked at from row `begin` on. `bounds` are two clearances: no more pairs are looked at once the least is
    as small as the first, and those farther apart than the second count as so far apart, as no pair.
    """
    still, turning = frames
    groups, pairs, local = world.groups, world.pairs, world.local
    turn = (math.cos(psi), math.sin(psi))
    enough, least = bounds
    pair = NO_GROUP
    for step in range(pairs.shape[0]):
        k = begin + step if begin + step < pairs.shape[0] else begin + step - pairs.shape[0]
        a, b = pairs[k, 0], pairs[k, 1]
        if not is_turning(world, a) or is_turning(world, b):
            continue
        if turned_distance(local, a, b, turn) >= least:
            continue
        see_group(world, b, elbow, still, turning)
        if groups[b, KIND] == PLANES and turned_height(world, a, b, turn, least) >= least:
            continue
        see_group(world, a, elbow, still, turning)
        value = pair_clearance(world, a, b, turn, least)
        if value < least:
            least, pair = value, k
            if least <= enough:
                break
    return least, pair


@kernel
def resting_clearance(world, elbow, frames, most):
    """Least clearance, `most` if none is less, of pairs that no arm angle moves against each other: m, row of pairs."""
    still, turning = frames
    pairs = world.pairs
    least, pair = most, NO_GROUP
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        if is_turning(world, a) and not is_turning(world, b):
            continue
        if distance_of(world.local, a, b) >= least:
            continue
        see_group(world, a, elbow, still, turning)
        see_group(world, b, elbow, still, turning)
        value = fixed_clearance(world, a, b, least)
        if value < least:
            least, pair = value, k
    return least, pair


@kernel
def farthest_from_line(world):
    """A distance from the line S-W that no centre of a turning sphere exceeds, m."""
    largest = 0.0
    for g in range(world.groups.shape[0]):
        if is_turning(world, g):
            largest = max(largest, world.local[g, RHO] + world.local[g, EXTENT])
    return largest


@kernel
def pair_rate(world, pair, rate):
    """How fast the clearance of a pair changes at most with the arm angle, m/rad, no more than a rate."""
    if pair < 0:
        return rate
    local = world.local
    a, b = world.pairs[pair, 0], world.pairs[pair, 1]
    return min(rate, min(local[a, RHO] + local[a, EXTENT], local[b, RHO] + local[b, EXTENT]))


@kernel
def put_part(parts, n, lower, upper, most, pair):
    """Append a part of an interval: its ends, what the clearance in it may be at most, and the pair that says so."""
    parts[n, 0], parts[n, 1], parts[n, 2], parts[n, 3] = lower, upper, most, max(pair, 0)
    return n + 1


@kernel
def widest_within(world, elbow, frames, ends, best, tolerance, parts):
    """The arm angle of largest clearance between two: arm angle and clearance, m; those of `best` where none is larger.

    Only pairs that the arm angle moves count. A clearance within the tolerance, m, of the largest is as good.
    """
    rate = farthest_from_line(world)
    lower, upper = ends
    best_psi, largest = best
    middle = 0.5 * (lower + upper)
    value, pair = turning_clearance(world, elbow, frames, middle, 0, (-math.inf, math.inf))
    if value > largest:
        best_psi, largest = middle, value
    most = value + 0.5 * pair_rate(world, pair, rate) * (upper - lower)
    n = put_part(parts, 0, lower, upper, most, pair)
    while n > 0:
        top = 0
        for i in range(n):
            if parts[i, 2] > parts[top, 2]:
                top = i
        if not parts[top, 2] > largest + tolerance or n + 1 >= parts.shape[0]:
            break
        lower, upper, begin = parts[top, 0], parts[top, 1], int(parts[top, 3])
        n -= 1
        for i in range(4):
            parts[top, i] = parts[n, i]
        half = 0.5 * (lower + upper)
        for side in range(2):
            a = lower if side == 0 else half
            b = half if side == 0 else upper
            middle = 0.5 * (a + b)
            more = 0.5 * rate * (b - a)
            # Where one pair is so near that no angle of this half is better, no other pair matters.
            value, pair = turning_clearance(world, elbow, frames, middle, begin, (largest + tolerance - more, math.inf))
            if value > largest:
                best_psi, largest = middle, value
            most = value + 0.5 * pair_rate(world, pair, rate) * (b - a)
            if most > largest + tolerance:
                n = put_part(parts, n, a, b, most, pair)
    return best_psi, largest
