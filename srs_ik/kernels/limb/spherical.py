"""A spherical joint made of three axes in any directions: from a rotation to three angles.

R = rot(a1, q1) rot(a2, q2) rot(a3, q3). The cosine a1' R a3 depends on q2 alone and gives two of them; q1 and q3 follow
as one angle about an axis each. (Elias and Wen 2022 decompose inverse kinematics in the same spirit; the forms used
here keep all digits near the singular rotations.) Of R only two columns are needed: v = R a3 and y = R ACROSS_3.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from srs_ik.kernels.algebra.lanes import choose, root, where
from srs_ik.kernels.algebra.vectors import across, add, cross, dot, load3, rotate, sub, swing
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.splits import nearest_split, rest_of, widest_split


@kernel
def columns_at(motion, c, s):
    """R a3 and R ACROSS_3 on the circles of a spherical joint's motion, at one arm angle or at eight."""
    return swing(motion[0], c, s), swing(motion[1], c, s)


@kernel
def middle_angle(P, k, v):
    """Cosine and sine of x = |q2 - PHASE|, and whether v can be reached at all (else x is the nearest)."""
    a1 = load3(P, k + at.A1)
    up = sub(v, a1)
    down = add(v, a1)
    # 1 - m and 1 + m for m = a1'v, as squares of differences: full precision where v is near +-a1.
    top2 = dot(up, up)
    bottom2 = dot(down, down)
    top = 0.5 * top2 - P[k + at.TOP_GAP]
    bottom = 0.5 * bottom2 - P[k + at.BOTTOM_GAP]
    # Beyond an end by an angle e, the gap is negative by e times the sine of the angle between a1 and v.
    reached = True
    if min(top, bottom) < 0.0:
        slack = P[at.SLACK_REACH]
        reached = top >= -slack * math.sqrt(top2) and bottom >= -slack * math.sqrt(bottom2)
        top = max(top, 0.0)
        bottom = max(bottom, 0.0)
    share = 1.0 / (top + bottom)
    return (bottom - top) * share, 2.0 * math.sqrt(top * bottom) * share, reached


class Joint(NamedTuple):
    """The figures of a spherical joint, of one or of eight in step (see the offsets of a block in `layout.limb`)."""

    a1: Any
    a2: Any
    a3: Any
    across_3: Any
    cross_3: Any
    cross_23: Any
    cos_phase: Any
    sin_phase: Any
    top_gap: Any
    bottom_gap: Any
    a2_a3: Any
    singular: Any  # sine of the angle between axes 1 and 3 under which they count as parallel


@kernel
def joint_at(P, k):
    """The spherical joint at block k."""
    return Joint(
        load3(P, k + at.A1),
        load3(P, k + at.A2),
        load3(P, k + at.A3),
        load3(P, k + at.ACROSS_3),
        load3(P, k + at.CROSS_3),
        load3(P, k + at.CROSS_23),
        P[k + at.COS_PHASE],
        P[k + at.SIN_PHASE],
        P[k + at.TOP_GAP],
        P[k + at.BOTTOM_GAP],
        P[k + at.A2_A3],
        P[at.SLACK_SINGULAR],
    )


@kernel
def joints_of(which, one, other):
    """Eight joints, each of two, by a mask."""
    return Joint(
        choose(which, one.a1, other.a1),
        choose(which, one.a2, other.a2),
        choose(which, one.a3, other.a3),
        choose(which, one.across_3, other.across_3),
        choose(which, one.cross_3, other.cross_3),
        choose(which, one.cross_23, other.cross_23),
        where(which, one.cos_phase, other.cos_phase),
        where(which, one.sin_phase, other.sin_phase),
        where(which, one.top_gap, other.top_gap),
        where(which, one.bottom_gap, other.bottom_gap),
        where(which, one.a2_a3, other.a2_a3),
        one.singular,
    )


@kernel
def sines(P, k, v, y, c, s):
    """`sines_of` the joint at block k."""
    return sines_of(joint_at(P, k), v, y, c, s)


@kernel
def sines_of(joint, v, y, c, s):
    """One solution, or eight in step, as cosine and sine of each angle, and the common length that those of q1 had.

    c and s come from `middle_angle`, for which q2 lies above its phase; with -s it lies below. Where axes 1 and 3 are
    parallel the length is 0, q1 is taken as zero, and the last pair belongs to the sum or difference of q1 and q3.
    """
    c2 = joint.cos_phase * c - joint.sin_phase * s
    s2 = joint.sin_phase * c + joint.cos_phase * s
    a1, a2, a3, cross_23 = joint.a1, joint.a2, joint.a3, joint.cross_23
    t = (1.0 - c2) * joint.a2_a3
    u = (
        c2 * a3[0] + s2 * cross_23[0] + t * a2[0],
        c2 * a3[1] + s2 * cross_23[1] + t * a2[1],
        c2 * a3[2] + s2 * cross_23[2] + t * a2[2],
    )
    # Project before multiplying: u and v may both be almost a1, and the small parts across a1 hold the answer.
    u_across, v_across = across(u, a1), across(v, a1)
    s1, c1 = dot(a1, cross(u_across, v_across)), dot(u_across, v_across)
    apart = dot(u_across, u_across) > joint.singular * joint.singular
    length = where(apart, root(s1 * s1 + c1 * c1), 0.0)
    share = where(length > 0.0, 1.0 / where(length > 0.0, length, 1.0), 0.0)
    s1, c1 = s1 * share, where(length > 0.0, c1 * share, 1.0)
    z = rotate(a2, c2, -s2, rotate(a1, c1, -s1, y))
    return (c1, s1), (c2, s2), (dot(joint.across_3, z), dot(joint.cross_3, z)), length


@kernel
def eight_middles(P, k, v):
    """`middles_of` the joint at block k."""
    return middles_of(joint_at(P, k), v)


@kernel
def middles_of(joint, v):
    """`middle_angle` of eight directions: cosines and sines, and a mask of those that may be out of reach."""
    up, down = sub(v, joint.a1), add(v, joint.a1)
    top, bottom = 0.5 * dot(up, up) - joint.top_gap, 0.5 * dot(down, down) - joint.bottom_gap
    missed = (top < 0.0) | (bottom < 0.0)
    top, bottom = where(top < 0.0, 0.0, top), where(bottom < 0.0, 0.0, bottom)
    share = 1.0 / (top + bottom)
    return (bottom - top) * share, 2.0 * root(top * bottom) * share, missed


@kernel
def angles(P, k, v, y, c, s, sign, anchor):
    """One solution as angles (q1, q2, q3), q2 above its phase (sign 0) or below (1).

    Where axes 1 and 3 are parallel, q1 and q3 are free but for one sum: `anchor` = (seeded, q1, q3, respect) asks for
    the split nearest to a seed, inside the limits if they are respected, or for the one farthest from the limits.
    """
    one, two, three, length = sines(P, k, v, y, c, s if sign == 0 else -s)
    q2, q3 = math.atan2(two[1], two[0]), math.atan2(three[1], three[0])
    if length > 0.0:
        return math.atan2(one[1], one[0]), q2, q3
    toward = 1.0 if c > 0.0 else -1.0
    q1, q3 = split(P, k, q3, toward, anchor)
    return q1, q2, q3


@kernel
def split(P, k, total, toward, anchor):
    """Joints 1 and 3 where only the sum of toward q1 and q3 is known."""
    seeded, seed_1, seed_3, respect = anchor
    first = int(P[k + at.FIRST_JOINT])
    if not seeded:
        return widest_split(P, k, first, total, toward)
    if respect:
        return nearest_split(P, k, first, total, toward, seed_1, seed_3)
    half = 0.5 * rest_of(total, toward, seed_1, seed_3)
    return seed_1 + toward * half, seed_3 + half


@kernel
def mirrored(phase, q):
    """The other solution where axis 2, singular at a phase, is perpendicular to axes 1 and 3, away from there."""
    return q[0] + math.pi, 2.0 * phase - q[1], q[2] + math.pi


@kernel
def middle_anchor():
    """The anchor of the split that is farthest from the limits."""
    return False, 0.0, 0.0, True
