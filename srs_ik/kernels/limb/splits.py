"""The split of a sum between joints 1 and 3 of a spherical joint whose axes 1 and 3 are parallel, in closed form.

There the rotation fixes toward q1 + q3 alone, but for whole turns: toward is 1.0 for axes that point the same way and
-1.0 for opposite ones. The splits inside the limits are segments, one for each turn of the sum.
"""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import ANCHOR_1, ANCHOR_3, INVERSE_HALF_RANGE, LOWER, SHARE_1, SLACK_LIMIT, UPPER

TURN = 2.0 * math.pi


@kernel
def with_outer(q, first, q1, q3):
    """A posture with joints 1 and 3 of the shoulder (first = 0) or of the wrist (4) replaced."""
    if first == 0:
        return (q1, q[1], q3, q[3], q[4], q[5], q[6])
    return (q[0], q[1], q[2], q[3], q1, q[5], q3)


@kernel
def rest_of(total, toward, q1, q3):
    """What is missing from two angles to the sum, in [-pi, pi]."""
    rest = total - toward * q1 - q3
    return rest - TURN * math.floor(rest / TURN + 0.5)


@kernel
def widest_split(P, k, first, total, toward):
    """The split whose smaller margin to the limits is largest, or whose larger violation is smallest: q1, q3.

    Each joint takes what its range allows of the way from the middles, which leaves both the same margin.
    """
    q1, q3 = P[k + ANCHOR_1], P[k + ANCHOR_3]
    rest = rest_of(total, toward, q1, q3)
    part = P[k + SHARE_1] * rest
    if P[INVERSE_HALF_RANGE + first] > 0.0 and P[INVERSE_HALF_RANGE + first + 2] > 0.0:
        half_1 = 0.5 * (P[UPPER + first] - P[LOWER + first])
        half_3 = 0.5 * (P[UPPER + first + 2] - P[LOWER + first + 2])
        beyond = abs(rest) - half_1 - half_3
        # A joint with hardly any range takes no more than that.
        most = half_1 + 0.5 * max(beyond, 0.0)
        least = abs(rest) - half_3 - 0.5 * max(beyond, 0.0)
        part = math.copysign(min(max(abs(part), least), most), rest)
    return q1 + toward * part, q3 + (rest - part)


@kernel
def split_range(P, first, total, toward):
    """The angles that toward q1 takes inside the limits, where it and q3 make exactly the sum: first and last."""
    low = P[LOWER + first] if toward > 0.0 else -P[UPPER + first]
    high = P[UPPER + first] if toward > 0.0 else -P[LOWER + first]
    return max(low, total - P[UPPER + first + 2]), min(high, total - P[LOWER + first + 2])


@kernel
def nearest_split(P, k, first, total, toward, seed_1, seed_3):
    """The split inside the limits that is nearest to a seed: q1, q3; where there is none, `widest_split`.

    The distance grows with the way of the sum from that of the seed put on the limits. So the nearest sum on either
    side of it, of those that whole turns make, holds the nearest split.
    """
    inside = toward * min(max(seed_1, P[LOWER + first]), P[UPPER + first])
    inside += min(max(seed_3, P[LOWER + first + 2]), P[UPPER + first + 2])
    least = math.inf
    best_1, best_3 = seed_1, seed_3
    for side in range(2):
        whole = total + TURN * (math.floor((inside - total) / TURN) + side)
        low, high = split_range(P, first, whole, toward)
        if low > high + P[SLACK_LIMIT]:
            continue
        # Half of what is missing each, as far as the limits allow.
        x = min(max(0.5 * (whole + toward * seed_1 - seed_3), low), high)
        q1, q3 = toward * x, whole - x
        value = (q1 - seed_1) ** 2 + (q3 - seed_3) ** 2
        if value < least:
            best_1, best_3, least = q1, q3, value
    if least == math.inf:
        return widest_split(P, k, first, total, toward)
    return best_1, best_3
