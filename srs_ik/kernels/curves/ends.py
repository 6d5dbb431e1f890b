"""Postures between samples of a curve, and the last one inside the limits.

On an exact limb the curve is a branch and its parameter the arm angle; on a near limb it is a curve that `follow` has
followed on the true chain, its parameter the length along it.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, largest, short_way
from srs_ik.kernels.algebra.lanes import larger, scatter, where, whole_number
from srs_ik.kernels.algebra.minimum import GOLDEN
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.roots import SETTLED, has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.chain.eight import take_ways
from srs_ik.kernels.chain.newton import CLOSED, LEFT, clipped, close_gently
from srs_ik.kernels.curves.follow import arc_between, between, meet, tangent_at, vagueness
from srs_ik.kernels.curves.in_step import SAMPLE, load_end, load_sample
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_CLOSED, LOWER, MIDDLE, SLACK_LIMIT, UPPER
from srs_ik.kernels.layout.search import SPLIT
from srs_ik.kernels.limb.branches import NO_BRANCH, side_posture
from srs_ik.kernels.limb.goal import NO_SEED, turned
from srs_ik.kernels.limb.limits import PER_TURN, TURN, beyond, beyond_any, turn_to_middle

EDGE_STEPS = 100
DIP_STEPS = 40

LIMITS_IN_TURN = 3
ON_LIMIT = 1e-12
"""An edge is looked for on so many limits, one after the other; a posture on one, rad, keeps it."""

SLOWLY = 1e-8
LONGER = 4.0
"""Behind a posture on a limit, a joint that leaves it slowly is followed in steps from this on, each longer by this."""


@kernel
def is_exact(P):
    """Whether the closed form is the answer."""
    return P[IS_CLOSED] == 1.0


@kernel
def joint_beyond(P, j, q):
    """How far a joint of a posture lies outside its limits in the best turn, rad; negative inside."""
    return beyond(P, j, turn_to_middle(P, j, q[j]))


@kernel
def infeasibility(P, q, respect):
    """By how much a posture is not feasible, rad: 0 or less where it is."""
    return beyond_any(P, q) if respect else -1.0


@kernel
def inside_of_blur(P, by, q, blur):
    """A posture, or one inside the limits that rounding does not tell from it, rad, where limits count."""
    if not by.respect:
        return q
    q = turned(P, q, False, NO_SEED, True)
    if beyond_any(P, q) <= 0.0:
        return q
    inside, error = close_gently(P, clipped(P, q), by.target.R, by.target.p, True, by.J, by.A)
    return inside if error < LEFT and largest(difference(q, inside)) < blur else q


@kernel
def closed_inside(P, by, q, most):
    """The posture inside the limits that a pose has next to one barely outside them, and whether there is one.

    Up to an error of the pose, m or rad.
    """
    q = clipped(P, turned(P, q, False, NO_SEED, True))
    q, error = close_gently(P, q, by.target.R, by.target.p, True, by.J, by.A)
    return q, error < most


@kernel
def corner(P, by, q, off):
    """The posture inside the limits where one joint comes in as another goes out, and whether there is one.

    It may be the only one. Rounding turns the outer joints of a shoulder or wrist that is almost singular against each
    other, and hides the bend of an elbow that is almost straight, and so puts the posture of a curve that is closest to
    it so far outside, rad.
    """
    t, sign = tangent_at(P, by, q)
    if sign != 0.0 and off > vagueness(by.J, t, by.A):
        return q, False
    # By what rounding puts a third joint on its limit outside of that, the pose is missed.
    return closed_inside(P, by, q, LEFT if sign != 0.0 else CLOSED)


@kernel
def beyond_limits(P, joint, q):
    """How far eight angles of a joint lie outside its limits in the best turns, rad; negative inside."""
    q = q + TURN * whole_number((P[MIDDLE + joint] - q) * PER_TURN)
    off = larger(P[LOWER + joint] - q, q - P[UPPER + joint])
    return where((off > 0.0) & (off < P[SLACK_LIMIT]), 0.0 * q, off)


@kernel
def beyond_any_of_eight(P, q):
    """How far eight postures lie outside their limits, rad; negative inside, at least minus half a turn."""
    worst = larger(beyond_limits(P, 0, q[0]), beyond_limits(P, 1, q[1]))
    worst = larger(worst, larger(beyond_limits(P, 2, q[2]), beyond_limits(P, 3, q[3])))
    worst = larger(worst, larger(beyond_limits(P, 4, q[4]), beyond_limits(P, 5, q[5])))
    return larger(larger(worst, beyond_limits(P, 6, q[6])), 0.0 * q[0] - math.pi)


@kernel
def put_infeasibilities(P, curve, respect, out):
    """Write the infeasibility of the samples of a curve, eight at a time, each where its row is."""
    rows, first, last = curve
    for i in range(first, last, 8):
        # The last eight rows there are may begin before.
        k = min(i, rows.shape[0] - 8)
        worst = beyond_any_of_eight(P, take_ways(row(rows, k), 1, SAMPLE))
        scatter(row(out, k), 0, 1, worst if respect else 0.0 * worst - 1.0)


@kernel
def sample_before(curve, x):
    """The row of the sample before a parameter; never the last one."""
    rows, low, last = curve
    high = last - 1
    while high - low > 1:
        middle = (low + high) // 2
        if rows[middle, 0] <= x:
            low = middle
        else:
            high = middle
    return low


@kernel
def on_chord(rows, low, x):
    """The point at a parameter of the straight way between two samples."""
    start = load_sample(rows[low])
    share = (x - rows[low, 0]) / (rows[low + 1, 0] - rows[low, 0])
    return along7(start, share, difference(start, load_sample(rows[low + 1])))


@kernel
def on_curve(P, by, branch, curve, x):
    """Posture at a parameter, and its infeasibility; samples tell the curve if no branch gives it."""
    rows = curve.rows
    if is_exact(P) and branch < SPLIT:
        q, _, value = side_posture(P, by.side, x, (branch >> 1) & 1, branch & 1, False, NO_SEED, by.respect)
        return q, (NO_BRANCH if value >= NO_BRANCH else infeasibility(P, q, by.respect))
    low = sample_before(curve, x)
    high = min(low + 1, curve.last - 1)
    if x in (rows[low, 0], rows[high, 0]):
        # The sample itself: the end of a run keeps the limits to the last bit.
        q = load_sample(rows[low if x == rows[low, 0] else high])
    else:
        if is_exact(P):
            # A free split is the chord. Where another sum is free at once, it stays as it is: steps would turn it, too.
            q, error = close_gently(P, on_chord(rows, low, x), by.target.R, by.target.p, False, by.J, by.A)
            met = error <= CLOSED
        else:
            share = (x - rows[low, 0]) / (rows[high, 0] - rows[low, 0])
            q, met = between(P, by, load_end(rows[low]), load_end(rows[high]), share)
        if not met:
            return q, NO_BRANCH
    q = turned(P, q, False, NO_SEED, by.respect)
    return q, infeasibility(P, q, by.respect)


@kernel
def first_limit(P, a, b):
    """The limit that is met first on the straight way from a posture inside to one outside: joint, limit, share."""
    joint = -1
    limit = 0.0
    least = 2.0
    for j in range(7):
        at_a = turn_to_middle(P, j, a[j])
        if joint_beyond(P, j, b) > 0.0:
            # Across the middle of a narrow gap, the closest turn is outside the limit on its other side.
            at_b = at_a + short_way(b[j] - at_a)
            inside, off = max(-beyond(P, j, at_a), 0.0), beyond(P, j, at_b)
            if inside < least * (inside + off):
                joint, least = j, inside / (inside + off)
                limit = P[UPPER + j] if at_b > P[UPPER + j] else P[LOWER + j]
    return joint, limit, least


@kernel
def edge_on_limit(P, by, curve, x, y):
    """`edge` by Newton's method for the pose and the limit together, and whether that is met between two samples."""
    rows = curve.rows
    low = sample_before(curve, 0.5 * (x + y))
    none = (x, NO_SEED)
    if min(x, y) < rows[low, 0] or max(x, y) > rows[low + 1, 0]:
        return none, False
    a, b = on_chord(rows, low, x), on_chord(rows, low, y)
    start, end = load_end(rows[low]), load_end(rows[low + 1])
    way = difference(start[0], end[0])
    for _ in range(LIMITS_IN_TURN):
        joint, limit, share = first_limit(P, a, b)
        if joint < 0:
            return none, False
        q = along7(a, share, difference(a, b))
        q = arc_between(P, by, start, end, dot7(difference(start[0], q), way) / dot7(way, way))
        # The same limit, a whole turn away or not.
        limit = q[joint] + short_way(limit - q[joint])
        q, share, met = meet(P, by, (start[0], end[0]), q, joint, limit)
        found = rows[low, 0] + share * (rows[low + 1, 0] - rows[low, 0])
        if not met or (found - x) * (found - y) > 0.0:
            return none, False
        if infeasibility(P, turned(P, q, False, NO_SEED, True), True) < ON_LIMIT:
            return (found, q), True
        b = q
    return none, False


@kernel
def last_on_limit(P, by, branch, curve, x, y):
    """The last feasible parameter behind one on a limit, towards one that is not feasible.

    Where a joint hardly moves, as an elbow does that the arm angle turns only by what axes miss, what rounding leaves
    of its angle is a long way along the curve.
    """
    step = SLOWLY
    while abs(y - x) > SLOWLY:
        m = x + math.copysign(min(step, 0.5 * abs(y - x)), y - x)
        _, f = on_curve(P, by, branch, curve, m)
        if f > 0.0:
            y = m
        else:
            x = m
            step *= LONGER
    return x


@kernel
def edge(P, by, branch, curve, inside, outside):
    """The last feasible parameter from a feasible one towards one that is not, each with its infeasibility.

    Its posture too.
    """
    x, fx = inside
    y, fy = outside
    if not is_exact(P):
        found, met = edge_on_limit(P, by, curve, x, y)
        if met:
            return found
    # Behind a joint that stands on its limit all along, figures hide how far another is from its own.
    hidden = fx > -SETTLED
    crossing = start_crossing(x, -1.0, y, 1.0) if hidden else start_crossing(x, fx, y, fy)
    for _ in range(EDGE_STEPS):
        if has_settled(crossing):
            break
        m = next_parameter(crossing)
        _, f = on_curve(P, by, branch, curve, m)
        if hidden:
            f = 1.0 if f > 0.0 else -1.0
        crossing = tell_figure(crossing, m, f)
    x = crossing[0]
    if not is_exact(P) and by.respect:
        x = last_on_limit(P, by, branch, curve, x, crossing[3])
    q, _ = on_curve(P, by, branch, curve, x)
    return x, q


@kernel
def dip(P, by, branch, curve, a, b):
    """The least infeasible parameter between two, or any feasible one: parameter and infeasibility."""
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    wanted = x
    fx = NO_BRANCH
    fy = NO_BRANCH
    for i in range(DIP_STEPS):
        _, f = on_curve(P, by, branch, curve, wanted)
        if f <= 0.0:
            return wanted, f
        if wanted == x:
            fx = f
        else:
            fy = f
        if i == 0:
            wanted = y
        elif fx <= fy:
            b, y, fy = y, x, fx
            x = b - GOLDEN * (b - a)
            wanted = x
        else:
            a, x, fx = x, y, fy
            y = a + GOLDEN * (b - a)
            wanted = y
    return wanted, 1.0
