"""A spherical joint made of three axes in any directions: from a rotation to three angles.

R = rot(a1, q1) rot(a2, q2) rot(a3, q3). Then a1' R a3 = OFFSET + GAIN cos(q2 - PHASE) gives two q2, and q1 and q3 follow
as one angle about an axis each. (Elias and Wen 2022 decompose inverse kinematics in the same spirit; the forms used here
keep all digits near the singular rotations.)
"""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import (
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
    PHASE,
    SHARE_1,
    SIN_PHASE,
    SLACK_REACH,
    SLACK_SINGULAR,
    TOP_GAP,
)
from srs_ik.kernels.vectors import across, add, apply, cross, dot, load3, rotate, sub


@kernel
def wrap(angle):
    """The angle in [-pi, pi]."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def middle_angle(P, k, R):
    """Cosine and sine of x = |q2 - PHASE|, and whether R can be reached at all (else x is the nearest)."""
    a1 = load3(P, k + A1)
    v = apply(R, load3(P, k + A3))
    up = sub(v, a1)
    down = add(v, a1)
    # 1 - m and 1 + m for m = a1'v, as squares of differences: full precision where v is near +-a1.
    top2 = dot(up, up)
    bottom2 = dot(down, down)
    top = 0.5 * top2 - P[k + TOP_GAP]
    bottom = 0.5 * bottom2 - P[k + BOTTOM_GAP]
    # Beyond an end by an angle e, the gap is negative by e times the sine of the angle between a1 and v.
    slack = P[SLACK_REACH]
    reached = top >= -slack * math.sqrt(top2) and bottom >= -slack * math.sqrt(bottom2)
    top = max(top, 0.0)
    bottom = max(bottom, 0.0)
    total = top + bottom
    return (bottom - top) / total, 2.0 * math.sqrt(top * bottom) / total, reached


@kernel
def outer_angles(P, k, R, c2, s2, anchor):
    """Angles q1 and q3 for a rotation and the cosine and sine of q2.

    Where axes 1 and 3 are parallel, q1 and q3 are free but for one sum: `anchor` = (q1, q3, share) says where they like
    to be and which share of the way from there joint 1 takes.
    """
    a1 = load3(P, k + A1)
    a2 = load3(P, k + A2)
    a3 = load3(P, k + A3)
    v = apply(R, a3)
    y = apply(R, load3(P, k + ACROSS_3))
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
    if size2 > P[SLACK_SINGULAR] * P[SLACK_SINGULAR]:
        s1 = dot(a1, cross(u_across, v_across))
        c1 = dot(u_across, v_across)
        length = math.sqrt(s1 * s1 + c1 * c1)
        q1 = math.atan2(s1, c1)
        if length > 0.0:
            s1 /= length
            c1 /= length
        else:
            s1 = 0.0
            c1 = 1.0
        z = rotate(a2, c2, -s2, rotate(a1, c1, -s1, y))
        return q1, math.atan2(dot(load3(P, k + CROSS_3), z), dot(load3(P, k + ACROSS_3), z))
    z = rotate(a2, c2, -s2, y)
    turn = math.atan2(dot(load3(P, k + CROSS_3), z), dot(load3(P, k + ACROSS_3), z))
    sign = 1.0 if dot(u, a1) > 0.0 else -1.0  # sign q1 + q3 = turn
    rest = wrap(turn - sign * anchor[0] - anchor[1])
    return anchor[0] + sign * anchor[2] * rest, anchor[1] + (1.0 - anchor[2]) * rest


@kernel
def default_anchor(P, k):
    """Middle of the ranges of joints 1 and 3, and the share of joint 1 in proportion to its range."""
    return (P[k + ANCHOR_1], P[k + ANCHOR_3], P[k + SHARE_1])


@kernel
def decompose(P, k, R, c, s, sign, anchor):
    """One decomposition of R by the spherical joint at block k: (q1, q2, q3), q2 above (sign 0) or below its phase (1).

    c and s are the cosine and sine of |q2 - PHASE|, from `middle_angle`.
    """
    if sign == 1:
        s = -s
    cp = P[k + COS_PHASE]
    sp = P[k + SIN_PHASE]
    q1, q3 = outer_angles(P, k, R, cp * c - sp * s, sp * c + cp * s, anchor)
    return (q1, P[k + PHASE] + math.atan2(s, c), q3)
