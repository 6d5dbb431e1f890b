"""The largest margin near an arm angle: each joint's margin is smooth, and the smallest of them has its top on a ridge.

On the way, the joint angles and their rates are known exactly, so a step goes where the margins of two joints meet if
each goes on as it does (Newton's method on their difference), or to where the rate of one vanishes (secants). Four or
five steps leave rounding. Between limits that cannot be kept, the way leads to the least violation.
"""

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import cross, dot, load3, rotate, scale
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import search as at
from srs_ik.kernels.layout.limb import A1, A2, FIRST_JOINT, INVERSE_HALF_RANGE, LOWER, MIDDLE, SHOULDER, UPPER, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, anchor
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.limits import turn_to_middle
from srs_ik.kernels.limb.spherical import angles, columns_at, middle_angle

MOST_STEPS = 60
"""Steps to a summit, at most."""

CLOSED_IN = 1e-7
"""A step this short, as a part of the span, is the last if the cost changes by less on it: they shrink like squares."""

STEADY = 6
"""So many steps are free to go; of those behind them every other one halves what is left, where joints jump."""

FINEST = 1e-15
"""No closer than this, rad."""

STEEP = 1e3
"""Joints are close to a jump where a margin changes by more than this times the arm angle."""

PARALLEL = 1e-12
"""Sine of the angle between axes 1 and 3 of a spherical joint under which its joints have no rates."""


@kernel
def put_joint(P, joint, q, rate, outside, point):
    """Write the cost of a joint and its rate: minus its margin, or how far it is beyond its limits, rad."""
    q = turn_to_middle(P, joint, q)
    if outside:
        above, below = q - P[UPPER + joint], P[LOWER + joint] - q
        point[at.CLIMB_COSTS + joint] = max(above, below)
        point[at.CLIMB_RATES + joint] = rate if above > below else -rate
        return
    off = q - P[MIDDLE + joint]
    inverse = P[INVERSE_HALF_RANGE + joint]
    point[at.CLIMB_COSTS + joint] = abs(off) * inverse - 1.0
    point[at.CLIMB_RATES + joint] = math.copysign(inverse, off) * rate


@kernel
def put_half(P, k, turning, turn, sign, outside, point):
    """Write what the three joints of a spherical joint cost at an arm angle; whether it can be so.

    `turning` holds the circles of its motion and the axis about which its rotation turns with the arm angle:
    axis = a1 q1' + e2 q2' + v q3', with e2 and v the axes 2 and 3 as they are turned.
    """
    motion, axis = turning
    first = int(P[k + FIRST_JOINT])
    v, y = columns_at(motion, turn[0], turn[1])
    c, s, reached = middle_angle(P, k, v)
    q = angles(P, k, v, y, c, s, sign, anchor(first, False, NO_SEED, True))
    a1 = load3(P, k + A1)
    e2 = rotate(a1, math.cos(q[0]), math.sin(q[0]), load3(P, k + A2))
    normal = cross(e2, v)
    volume = dot(a1, normal)
    share = 1.0 / volume if abs(volume) > PARALLEL else 0.0
    put_joint(P, first, q[0], dot(axis, normal) * share, outside, point)
    put_joint(P, first + 1, q[1], dot(axis, cross(v, a1)) * share, outside, point)
    put_joint(P, first + 2, q[2], dot(axis, cross(a1, e2)) * share, outside, point)
    return reached


@kernel
def look(P, side, axes, branch, psi, outside, point):
    """Write a point of the way: what the joints but the elbow cost at an arm angle of a branch."""
    turn = (math.cos(psi), math.sin(psi))
    shoulder = put_half(P, SHOULDER, (side[1], axes[0]), turn, (branch >> 1) & 1, outside, point)
    wrist = put_half(P, WRIST, (side[2], axes[1]), turn, branch & 1, outside, point)
    point[at.CLIMB_COSTS + 3], point[at.CLIMB_RATES + 3] = -math.inf, 0.0
    active = 0
    for j in range(1, 7):
        if point[at.CLIMB_COSTS + j] > point[at.CLIMB_COSTS + active]:
            active = j
    point[at.CLIMB_PSI], point[at.CLIMB_ACTIVE] = psi, active
    point[at.CLIMB_COST] = point[at.CLIMB_COSTS + active] if shoulder and wrist else NO_BRANCH
    point[at.CLIMB_RATE] = point[at.CLIMB_RATES + active]


@kernel
def downhill(point, costs, rates, active):
    """The way from a point to the least of the largest of its joints' costs, if each goes on as it goes there.

    In the point's columns from `costs` and `rates` on are the costs of the joints and their rates with the arm angle;
    `active` is the joint of the largest. Infinite where no other joint stops it.
    """
    if active < 0 or point[rates + active] == 0.0:
        return 0.0
    sign = -1.0 if point[rates + active] > 0.0 else 1.0
    way = 0.0
    for _ in range(7):
        height, slope = point[costs + active], sign * point[rates + active]
        nearest, following = math.inf, -1
        for j in range(7):
            other = sign * point[rates + j]
            if j != active and other > slope:
                crossing = (height - point[costs + j]) / (other - slope)
                if way <= crossing < nearest:
                    nearest, following = crossing, j
        if following < 0:
            return sign * math.inf
        way, active = nearest, following
        if sign * point[rates + active] >= 0.0:
            break
    return sign * way


@kernel
def between(a, b):
    """Where the minimum between two points is: where the rate of one joint vanishes, or the tangents of two meet."""
    width = b[at.CLIMB_PSI] - a[at.CLIMB_PSI]
    slope = b[at.CLIMB_RATE] - a[at.CLIMB_RATE]
    if slope <= 0.0:
        return a[at.CLIMB_PSI] + 0.5 * width
    if a[at.CLIMB_ACTIVE] == b[at.CLIMB_ACTIVE]:
        return a[at.CLIMB_PSI] - a[at.CLIMB_RATE] * width / slope
    return a[at.CLIMB_PSI] + (a[at.CLIMB_COST] - b[at.CLIMB_COST] + b[at.CLIMB_RATE] * width) / slope


@kernel
def copy_point(source, target):
    """Copy a point."""
    for i in range(at.CLIMB):
        target[i] = source[i]


@kernel
def next_step(points, span, step):
    """Where to look next: inside of a span that is known to hold a summit, or at an end of it."""
    a, b, x = row(points, 0), row(points, 1), row(points, 2)
    lower, upper, below, above = span
    to = x[at.CLIMB_PSI] + downhill(x, at.CLIMB_COSTS, at.CLIMB_RATES, int(x[at.CLIMB_ACTIVE]))
    if below and above:
        if not lower < to < upper:
            to = between(a, b)
        if not lower < to < upper or (step > STEADY and step % 2 == 0):
            to = 0.5 * (lower + upper)
        return to
    return min(max(to, lower), upper)


@kernel
def summit(P, side, axes, branch, span, outside, points):
    """Where the joints but the elbow are farthest from their limits between two arm angles, from one between them on.

    `axes` are those of `turning_axes`, `span` lower, middle and upper arm angle, `points` (3, CLIMB) work space. Where
    limits cannot be kept, the least violation is wanted: `outside`. Returns the arm angle, and whether no joint was
    close to a jump on the way: else there may be more elsewhere.
    """
    lower, psi, upper = span
    a, b, x = row(points, 0), row(points, 1), row(points, 2)
    look(P, side, axes, branch, psi, outside, x)
    best, lowest = psi, x[at.CLIMB_COST]
    below, above, width, fastest = False, False, upper - lower, 0.0
    for step in range(MOST_STEPS):
        if x[at.CLIMB_RATE] == 0.0:
            return best, False
        fastest = max(fastest, abs(x[at.CLIMB_RATE]))
        if x[at.CLIMB_RATE] < 0.0:
            copy_point(x, a)
            lower, below = psi, True
        else:
            copy_point(x, b)
            upper, above = psi, True
        if upper - lower <= FINEST:
            return best, fastest < STEEP
        to = next_step(points, (lower, upper, below, above), step)
        way = abs(to - psi)
        psi = to
        look(P, side, axes, branch, psi, outside, x)
        if x[at.CLIMB_COST] < lowest:
            best, lowest = psi, x[at.CLIMB_COST]
        if way < CLOSED_IN * width and way * abs(x[at.CLIMB_RATE]) < CLOSED_IN:
            return best, fastest < STEEP
    return best, False


@kernel
def turning_axes(place_, side):
    """The axes about which the rotations of shoulder and wrist turn with the arm angle."""
    return place_[0], scale(-1.0, side[3])
