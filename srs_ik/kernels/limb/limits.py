"""Joint limits: how they are packed, the turn of an angle that fits them, and how well it fits."""

import math

from srs_ik.kernels.algebra.pointers import copy
from srs_ik.kernels.algebra.vectors import dot, load3, rotate, store3
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at

LEVEL = 1e-12
"""What is at right angles to the middle of a range counts as ahead of it, but for this: rounding decides."""

TURN = 2.0 * math.pi
PER_TURN = 1.0 / TURN


@kernel
def set_limit(P, joint, lower, upper):
    """Write the limits of one joint (infinite where there is none)."""
    P[at.LOWER + joint] = lower
    P[at.UPPER + joint] = upper
    P[at.COS_LOWER + joint] = 1.0
    P[at.COS_UPPER + joint] = 1.0
    P[at.SIN_LOWER + joint] = 0.0
    P[at.SIN_UPPER + joint] = 0.0
    P[at.INVERSE_HALF_RANGE + joint] = 0.0
    width = upper - lower
    if math.isfinite(width):
        P[at.MIDDLE + joint] = 0.5 * (lower + upper)
        P[at.INVERSE_HALF_RANGE + joint] = 2.0 / max(width, at.SMALLEST_RANGE)
    elif math.isfinite(lower):
        # One limit alone: the turn nearest to half a turn from it keeps it.
        P[at.MIDDLE + joint] = lower + math.pi
    elif math.isfinite(upper):
        P[at.MIDDLE + joint] = upper - math.pi
    else:
        P[at.MIDDLE + joint] = 0.0
    if width >= TURN - P[at.SLACK_LIMIT]:
        P[at.RANGE_KIND + joint] = 0.0
    else:
        P[at.RANGE_KIND + joint] = 1.0 if width <= math.pi else 2.0
        P[at.COS_LOWER + joint] = math.cos(lower)
        P[at.SIN_LOWER + joint] = math.sin(lower)
        P[at.COS_UPPER + joint] = math.cos(upper)
        P[at.SIN_UPPER + joint] = math.sin(upper)


@kernel
def share_of_first(inverse_1, inverse_3):
    """The part of a sum that leaves joints 1 and 3 the same margin, from their inverse half ranges (0: no limits)."""
    both = inverse_1 + inverse_3
    return inverse_3 / both if both > 0.0 else 0.5


@kernel
def set_joint_limits(P, k, first):
    """Write the limits of the spherical joint at block k as linear forms of its rotation, and its anchors."""
    a1 = load3(P, k + at.A1)
    a2 = load3(P, k + at.A2)
    a3 = load3(P, k + at.A3)
    if P[at.RANGE_KIND + first] != 0.0:
        c, s = P[at.COS_LOWER + first], P[at.SIN_LOWER + first]
        store3(P, k + at.BOUND_1_LOWER, rotate(a1, c, s, a2))
        c, s = P[at.COS_UPPER + first], P[at.SIN_UPPER + first]
        store3(P, k + at.BOUND_1_UPPER, rotate(a1, c, s, a2))
    if P[at.RANGE_KIND + first + 1] != 0.0:
        c, s = P[at.COS_LOWER + first + 1], P[at.SIN_LOWER + first + 1]
        P[k + at.BOUND_2_LOWER] = dot(a1, rotate(a2, c, s, a3))
        c, s = P[at.COS_UPPER + first + 1], P[at.SIN_UPPER + first + 1]
        P[k + at.BOUND_2_UPPER] = dot(a1, rotate(a2, c, s, a3))
    if P[at.RANGE_KIND + first + 2] != 0.0:
        c, s = P[at.COS_LOWER + first + 2], P[at.SIN_LOWER + first + 2]
        store3(P, k + at.BOUND_3_LOWER, rotate(a3, c, -s, a2))
        c, s = P[at.COS_UPPER + first + 2], P[at.SIN_UPPER + first + 2]
        store3(P, k + at.BOUND_3_UPPER, rotate(a3, c, -s, a2))
    P[k + at.ANCHOR_1] = P[at.MIDDLE + first]
    P[k + at.ANCHOR_3] = P[at.MIDDLE + first + 2]
    P[k + at.SHARE_1] = share_of_first(P[at.INVERSE_HALF_RANGE + first], P[at.INVERSE_HALF_RANGE + first + 2])


@kernel
def set_limits(P, lower, upper):
    """Write all that the packed limb knows of its limits; lower and upper hold 7 angles each."""
    for joint in range(7):
        set_limit(P, joint, lower[joint], upper[joint])
    set_joint_limits(P, at.SHOULDER, 0)
    set_joint_limits(P, at.WRIST, 4)


@kernel
def tighten(P, seed, distance, slack, box):
    """Copy the packed limb to `box` with its limits tightened to seed +- distance, then widened by some slack."""
    copy(P, box, at.SIZE)
    for j in range(7):
        lower = max(P[at.LOWER + j], seed[j] - distance) - slack
        upper = min(P[at.UPPER + j], seed[j] + distance) + slack
        set_limit(box, j, min(lower, upper), upper)
    set_joint_limits(box, at.SHOULDER, 0)
    set_joint_limits(box, at.WRIST, 4)


@kernel
def is_inside(P, joint, c, s, slack):
    """Whether the angle with cosine c and sine s has a turn inside the limits, or no farther out than some slack, rad.

    Cross products with the directions of the limits decide, so nothing is lost where a range is narrow or nearly a
    turn.
    """
    kind = P[at.RANGE_KIND + joint]
    if kind == 0.0:
        return True
    cl = P[at.COS_LOWER + joint]
    sl = P[at.SIN_LOWER + joint]
    cu = P[at.COS_UPPER + joint]
    su = P[at.SIN_UPPER + joint]
    above_lower = cl * s - sl * c
    below_upper = su * c - cu * s
    if kind == 1.0:
        x, y = cl + cu, sl + su
        # What is behind has sines like those of what is ahead, and counts where the slack joins both.
        ahead = x * c + y * s >= -LEVEL or (slack >= 0.0 and 4.0 * slack * slack >= x * x + y * y)
        return above_lower >= -slack and below_upper >= -slack and ahead
    return not (above_lower < -slack and below_upper < -slack)


@kernel
def settle(P, joint, q):
    """The angle itself, or the limit where it lies outside by no more than rounding."""
    inside = min(max(q, P[at.LOWER + joint]), P[at.UPPER + joint])
    return inside if abs(q - inside) <= P[at.SLACK_LIMIT] else q


@kernel
def violation(P, joint, q):
    """How far the angle lies outside its limits, rad; zero inside."""
    return max(P[at.LOWER + joint] - q, q - P[at.UPPER + joint], 0.0)


@kernel
def beyond(P, joint, q):
    """How far the angle lies outside its limits, rad; negative inside."""
    return max(P[at.LOWER + joint] - q, q - P[at.UPPER + joint])


@kernel
def beyond_any(P, q):
    """How far a posture lies outside its limits, rad; negative inside, at least minus half a turn."""
    worst = -math.pi
    for joint in range(7):
        worst = max(worst, beyond(P, joint, q[joint]))
    return worst


@kernel
def margin(P, joint, q):
    """1 in the middle of the range, 0 on a limit, negative outside, always 1 for a joint without limits."""
    return 1.0 - abs(q - P[at.MIDDLE + joint]) * P[at.INVERSE_HALF_RANGE + joint]


@kernel
def turn_to_middle(P, joint, q):
    """The turn of an angle nearest to the middle of the range (to zero for a joint without limits)."""
    return settle(P, joint, q + TURN * math.floor((P[at.MIDDLE + joint] - q) * PER_TURN + 0.5))


@kernel
def turn_to_seed(P, joint, q, seed, respect):
    """The turn of an angle nearest to a seed; with limits, the nearest one inside them where there is one."""
    near = q + TURN * math.floor((seed - q) * PER_TURN + 0.5)
    if not respect:
        return near
    if near > P[at.UPPER + joint] + P[at.SLACK_LIMIT]:
        near -= TURN * math.ceil((near - P[at.UPPER + joint] - P[at.SLACK_LIMIT]) / TURN)
    elif near < P[at.LOWER + joint] - P[at.SLACK_LIMIT]:
        near += TURN * math.ceil((P[at.LOWER + joint] - P[at.SLACK_LIMIT] - near) / TURN)
    near = settle(P, joint, near)
    if violation(P, joint, near) > 0.0:
        return turn_to_middle(P, joint, q)
    return near


@kernel
def middles(P):
    """The middle of the range of every joint, zero where there is none."""
    k = at.MIDDLE
    return (P[k], P[k + 1], P[k + 2], P[k + 3], P[k + 4], P[k + 5], P[k + 6])
