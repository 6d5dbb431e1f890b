"""A spherical joint made of three axes in any directions: from a rotation to three angles.

R = rot(a1, q1) rot(a2, q2) rot(a3, q3). The cosine a1' R a3 depends on q2 alone and gives two of them; q1 and q3 follow
as one angle about an axis each. (Elias and Wen 2022 decompose inverse kinematics in the same spirit; the forms used
here keep all digits near the singular rotations.) Of R only two columns are needed: v = R a3 and y = R ACROSS_3.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import across, add, cross, dot, load3, rotate, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    A1,
    A2,
    A2_A3,
    A3,
    ACROSS_3,
    ANCHOR_1,
    ANCHOR_3,
    BOTTOM_GAP,
    COS_PHASE,
    CROSS_3,
    CROSS_23,
    LOWER,
    PHASE,
    SHARE_1,
    SIN_PHASE,
    SLACK_LIMIT,
    SLACK_REACH,
    SLACK_SINGULAR,
    TOP_GAP,
    UPPER,
)


@kernel
def wrap(angle):
    """The angle in [-pi, pi]."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def middle_angle(P, k, v):
    """Cosine and sine of x = |q2 - PHASE|, and whether v can be reached at all (else x is the nearest)."""
    a1 = load3(P, k + A1)
    up = sub(v, a1)
    down = add(v, a1)
    # 1 - m and 1 + m for m = a1'v, as squares of differences: full precision where v is near +-a1.
    top2 = dot(up, up)
    bottom2 = dot(down, down)
    top = 0.5 * top2 - P[k + TOP_GAP]
    bottom = 0.5 * bottom2 - P[k + BOTTOM_GAP]
    # Beyond an end by an angle e, the gap is negative by e times the sine of the angle between a1 and v.
    reached = True
    if min(top, bottom) < 0.0:
        slack = P[SLACK_REACH]
        reached = top >= -slack * math.sqrt(top2) and bottom >= -slack * math.sqrt(bottom2)
        top = max(top, 0.0)
        bottom = max(bottom, 0.0)
    share = 1.0 / (top + bottom)
    return (bottom - top) * share, 2.0 * math.sqrt(top * bottom) * share, reached


@kernel
def sines(P, k, v, y, c, s, sign):
    """One solution as unscaled cosines and sines: (c1, s1, c2, s2, c3, s3) and the common length of (c1, s1).

    q2 lies above (sign 0) or below (1) its phase; c and s come from `middle_angle`. Where axes 1 and 3 are parallel the
    length is 0, q1 is taken as zero, and (c3, s3) belong to the sum or difference of q1 and q3.
    """
    if sign == 1:
        s = -s
    c2 = P[k + COS_PHASE] * c - P[k + SIN_PHASE] * s
    s2 = P[k + SIN_PHASE] * c + P[k + COS_PHASE] * s
    a1 = load3(P, k + A1)
    a2 = load3(P, k + A2)
    a3 = load3(P, k + A3)
    t = (1.0 - c2) * P[k + A2_A3]
    cross_23 = load3(P, k + CROSS_23)
    u = (
        c2 * a3[0] + s2 * cross_23[0] + t * a2[0],
        c2 * a3[1] + s2 * cross_23[1] + t * a2[1],
        c2 * a3[2] + s2 * cross_23[2] + t * a2[2],
    )
    # Project before multiplying: u and v may both be almost a1, and the small parts across a1 hold the answer.
    u_across = across(u, a1)
    v_across = across(v, a1)
    size2 = dot(u_across, u_across)
    c1 = 1.0
    s1 = 0.0
    length = 0.0
    if size2 > P[SLACK_SINGULAR] * P[SLACK_SINGULAR]:
        s1 = dot(a1, cross(u_across, v_across))
        c1 = dot(u_across, v_across)
        length = math.sqrt(s1 * s1 + c1 * c1)
        if length > 0.0:
            share = 1.0 / length
            c1 *= share
            s1 *= share
        else:
            c1 = 1.0
            s1 = 0.0
    z = rotate(a2, c2, -s2, rotate(a1, c1, -s1, y))
    return c1, s1, c2, s2, dot(load3(P, k + ACROSS_3), z), dot(load3(P, k + CROSS_3), z), length


@kernel
def angles(P, k, v, y, c, s, sign, anchor):
    """One solution as angles (q1, q2, q3).

    Where axes 1 and 3 are parallel, q1 and q3 are free but for one sum: `anchor` = (q1, q3, share, first) says where
    they like to be and which share of the way from there joint 1 takes; with `first`, the index of q1 among the joints,
    they stay inside their limits as far as the sum allows, and nowhere in particular with -1.
    """
    c1, s1, c2, s2, c3, s3, length = sines(P, k, v, y, c, s, sign)
    q2 = math.atan2(s2, c2)
    if length > 0.0:
        return math.atan2(s1, c1), q2, math.atan2(s3, c3)
    upright = c > 0.0
    toward = 1.0 if upright else -1.0  # toward q1 + q3 is what R fixes
    rest = wrap(math.atan2(s3, c3) - toward * anchor[0] - anchor[1])
    q1 = anchor[0] + toward * anchor[2] * rest
    q3 = anchor[1] + (1.0 - anchor[2]) * rest
    if anchor[3] < 0:
        return q1, q2, q3
    shift = kept_shift(P, anchor[3], q1, q3, toward)
    return q1 + shift, q2, q3 - toward * shift


@kernel
def kept_shift(P, first, q1, q3, toward):
    """How far q1 has to be turned, and q3 against it, until both are inside their limits; 0 if they cannot be.

    Either joint may be a turn away from its limits.
    """
    best = math.inf
    for turns in range(-2, 3):
        low_3 = P[LOWER + first + 2] + turns * 2.0 * math.pi
        high_3 = P[UPPER + first + 2] + turns * 2.0 * math.pi
        low = max(P[LOWER + first] - q1, q3 - high_3 if toward > 0.0 else low_3 - q3)
        high = min(P[UPPER + first] - q1, q3 - low_3 if toward > 0.0 else high_3 - q3)
        shift = min(max(0.0, low), high)
        # Room for the rounding of a sum that only the limits themselves make.
        if low <= high + P[SLACK_LIMIT] and abs(shift) < abs(best):
            best = shift
    return best if abs(best) < math.inf else 0.0


@kernel
def mirrored(P, k, q):
    """The other solution where axis 2 is perpendicular to axes 1 and 3, away from the singular rotations."""
    return q[0] + math.pi, 2.0 * P[k + PHASE] - q[1], q[2] + math.pi


@kernel
def default_anchor(P, k):
    """Middle of the ranges of joints 1 and 3, and the share of joint 1 in proportion to its range."""
    return (P[k + ANCHOR_1], P[k + ANCHOR_3], P[k + SHARE_1], -1)
