"""Joint limits: the turn of an angle that fits them, and how well it fits."""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import INVERSE_HALF_RANGE, LOWER, MIDDLE, SLACK_LIMIT, UPPER

TURN = 2.0 * math.pi


@kernel
def clip(P, joint, q):
    """The nearest angle inside the limits."""
    return min(max(q, P[LOWER + joint]), P[UPPER + joint])


@kernel
def settle(P, joint, q):
    """The angle itself, or the limit where it lies outside by no more than rounding."""
    lower = P[LOWER + joint]
    upper = P[UPPER + joint]
    if lower - P[SLACK_LIMIT] <= q < lower:
        return lower
    if upper < q <= upper + P[SLACK_LIMIT]:
        return upper
    return q


@kernel
def violation(P, joint, q):
    """How far the angle lies outside its limits, rad; zero inside."""
    return max(P[LOWER + joint] - q, q - P[UPPER + joint], 0.0)


@kernel
def margin(P, joint, q):
    """1 in the middle of the range, 0 on a limit, negative outside, always 1 for a joint without limits."""
    return 1.0 - abs(q - P[MIDDLE + joint]) * P[INVERSE_HALF_RANGE + joint]


@kernel
def turn_to_middle(P, joint, q):
    """The turn of an angle nearest to the middle of the range (to zero for a joint without limits)."""
    return settle(P, joint, q + TURN * math.floor((P[MIDDLE + joint] - q) / TURN + 0.5))


@kernel
def turn_to_seed(P, joint, q, seed, respect):
    """The turn of an angle nearest to a seed; with limits, the nearest one inside them where there is one."""
    near = q + TURN * math.floor((seed - q) / TURN + 0.5)
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
