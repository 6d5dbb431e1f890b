"""Joint limits: how they are packed, the turn of an angle that fits them, and how well it fits."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import copy
from srs_ik.kernels.algebra.vectors import dot, load3, rotate, store3
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    A1,
    A2,
    A3,
    ANCHOR_1,
    ANCHOR_3,
    BOUND_1_LOWER,
    BOUND_1_UPPER,
    BOUND_2_LOWER,
    BOUND_2_UPPER,
    BOUND_3_LOWER,
    BOUND_3_UPPER,
    COS_LOWER,
    COS_UPPER,
    INVERSE_HALF_RANGE,
    LOWER,
    MIDDLE,
    RANGE_KIND,
    SHARE_1,
    SHOULDER,
    SIN_LOWER,
    SIN_UPPER,
    SIZE,
    SLACK_LIMIT,
    SMALLEST_RANGE,
    UPPER,
    WRIST,
)

LEVEL = 1e-12
"""What is at right angles to the middle of a range counts as ahead of it, but for this: rounding decides."""

TURN = 2.0 * math.pi
PER_TURN = 1.0 / TURN


@kernel
def set_limit(P, joint, lower, upper):
    """Write the limits of one joint (infinite where there is none)."""
    P[LOWER + joint] = lower
    P[UPPER + joint] = upper
    P[COS_LOWER + joint] = 1.0
    P[COS_UPPER + joint] = 1.0
    P[SIN_LOWER + joint] = 0.0
    P[SIN_UPPER + joint] = 0.0
    P[INVERSE_HALF_RANGE + joint] = 0.0
    width = upper - lower
    if math.isfinite(width):
        P[MIDDLE + joint] = 0.5 * (lower + upper)
        P[INVERSE_HALF_RANGE + joint] = 2.0 / max(width, SMALLEST_RANGE)
    elif math.isfinite(lower):
        # One limit alone: the turn nearest to half a turn from it keeps it.
        P[MIDDLE + joint] = lower + math.pi
    elif math.isfinite(upper):
        P[MIDDLE + joint] = upper - math.pi
    else:
        P[MIDDLE + joint] = 0.0
    if width >= TURN - P[SLACK_LIMIT]:
        P[RANGE_KIND + joint] = 0.0
    else:
        P[RANGE_KIND + joint] = 1.0 if width <= math.pi else 2.0
        P[COS_LOWER + joint] = math.cos(lower)
        P[SIN_LOWER + joint] = math.sin(lower)
        P[COS_UPPER + joint] = math.cos(upper)
        P[SIN_UPPER + joint] = math.sin(upper)


@kernel
def share_of_first(inverse_1, inverse_3):
    """The part of a sum that leaves joints 1 and 3 the same margin, from their inverse half ranges (0: no limits)."""
    both = inverse_1 + inverse_3
    return inverse_3 / both if both > 0.0 else 0.5


@kernel
def set_joint_limits(P, k, first):
    """Write the limits of the spherical joint at block k as linear forms of its rotation, and its anchors."""
    a1 = load3(P, k + A1)
    a2 = load3(P, k + A2)
    a3 = load3(P, k + A3)
    if P[RANGE_KIND + first] != 0.0:
        c, s = P[COS_LOWER + first], P[SIN_LOWER + first]
        store3(P, k + BOUND_1_LOWER, rotate(a1, c, s, a2))
        c, s = P[COS_UPPER + first], P[SIN_UPPER + first]
        store3(P, k + BOUND_1_UPPER, rotate(a1, c, s, a2))
    if P[RANGE_KIND + first + 1] != 0.0:
        c, s = P[COS_LOWER + first + 1], P[SIN_LOWER + first + 1]
        P[k + BOUND_2_LOWER] = dot(a1, rotate(a2, c, s, a3))
        c, s = P[COS_UPPER + first + 1], P[SIN_UPPER + first + 1]
        P[k + BOUND_2_UPPER] = dot(a1, rotate(a2, c, s, a3))
    if P[RANGE_KIND + first + 2] != 0.0:
        c, s = P[COS_LOWER + first + 2], P[SIN_LOWER + first + 2]
        store3(P, k + BOUND_3_LOWER, rotate(a3, c, -s, a2))
        c, s = P[COS_UPPER + first + 2], P[SIN_UPPER + first + 2]
        store3(P, k + BOUND_3_UPPER, rotate(a3, c, -s, a2))
    P[k + ANCHOR_1] = P[MIDDLE + first]
    P[k + ANCHOR_3] = P[MIDDLE + first + 2]
    P[k + SHARE_1] = share_of_first(P[INVERSE_HALF_RANGE + first], P[INVERSE_HALF_RANGE + first + 2])


@kernel
def set_limits(P, lower, upper):
    """Write all that the packed limb knows of its limits; lower and upper hold 7 angles each."""
    for joint in range(7):
        set_limit(P, joint, lower[joint], upper[joint])
    set_joint_limits(P, SHOULDER, 0)
    set_joint_limits(P, WRIST, 4)


@kernel
def tighten(P, seed, distance, slack, box):
    """Copy the packed limb to `box` with its limits tightened to seed +- distance, then widened by some slack."""
    copy(P, box, SIZE)
    for j in range(7):
        lower = max(P[LOWER + j], seed[j] - distance) - slack
        upper = min(P[UPPER + j], seed[j] + distance) + slack
        set_limit(box, j, min(lower, upper), upper)
    set_joint_limits(box, SHOULDER, 0)
    set_joint_limits(box, WRIST, 4)


@kernel
def is_inside(P, joint, c, s, slack):
    """Whether the angle with cosine c and sine s has a turn inside the limits, or no farther out than some slack, rad.

    Cross products with the directions of the limits decide, so nothing is lost where a range is narrow or nearly a
    turn.
    """
    kind = P[RANGE_KIND + joint]
    if kind == 0.0:
        return True
    cl = P[COS_LOWER + joint]
    sl = P[SIN_LOWER + joint]
    cu = P[COS_UPPER + joint]
    su = P[SIN_UPPER + joint]
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
    inside = min(max(q, P[LOWER + joint]), P[UPPER + joint])
    return inside if abs(q - inside) <= P[SLACK_LIMIT] else q


@kernel
def violation(P, joint, q):
    """How far the angle lies outside its limits, rad; zero inside."""
    return max(P[LOWER + joint] - q, q - P[UPPER + joint], 0.0)


@kernel
def beyond(P, joint, q):
    """How far the angle lies outside its limits, rad; negative inside."""
    return max(P[LOWER + joint] - q, q - P[UPPER + joint])


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
    return 1.0 - abs(q - P[MIDDLE + joint]) * P[INVERSE_HALF_RANGE + joint]


@kernel
def turn_to_middle(P, joint, q):
    """The turn of an angle nearest to the middle of the range (to zero for a joint without limits)."""
    return settle(P, joint, q + TURN * math.floor((P[MIDDLE + joint] - q) * PER_TURN + 0.5))


@kernel
def turn_to_seed(P, joint, q, seed, respect):
    """The turn of an angle nearest to a seed; with limits, the nearest one inside them where there is one."""
    near = q + TURN * math.floor((seed - q) * PER_TURN + 0.5)
    if not respect:
        return near
    if near > P[UPPER + joint] + P[SLACK_LIMIT]:
        near -= TURN * math.ceil((near - P[UPPER + joint] - P[SLACK_LIMIT]) / TURN)
    elif near < P[LOWER + joint] - P[SLACK_LIMIT]:
        near += TURN * math.ceil((P[LOWER + joint] - P[SLACK_LIMIT] - near) / TURN)
    near = settle(P, joint, near)
    if violation(P, joint, near) > 0.0:
        return turn_to_middle(P, joint, q)
    return near


@kernel
def middles(P):
    """The middle of the range of every joint, zero where there is none."""
    k = MIDDLE
    return (P[k], P[k + 1], P[k + 2], P[k + 3], P[k + 4], P[k + 5], P[k + 6])
