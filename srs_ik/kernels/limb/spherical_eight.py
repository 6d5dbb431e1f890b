"""Eight rotations of a spherical joint at once: `spherical` in step, away from where axes 1 and 3 are parallel."""

from __future__ import annotations

from srs_ik.kernels.algebra.lanes import root, where
from srs_ik.kernels.algebra.vectors import across, add, cross, dot, load3, rotate, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import (
    A1,
    A2,
    A2_A3,
    A3,
    ACROSS_3,
    BOTTOM_GAP,
    COS_PHASE,
    CROSS_3,
    CROSS_23,
    SIN_PHASE,
    SLACK_SINGULAR,
    TOP_GAP,
)


@kernel
def eight_middles(P, k, v):
    """`spherical.middle_angle`: cosines and sines, and a mask of those that may be out of reach."""
    a1 = load3(P, k + A1)
    up, down = sub(v, a1), add(v, a1)
    top, bottom = 0.5 * dot(up, up) - P[k + TOP_GAP], 0.5 * dot(down, down) - P[k + BOTTOM_GAP]
    missed = (top < 0.0) | (bottom < 0.0)
    top, bottom = where(top < 0.0, 0.0, top), where(bottom < 0.0, 0.0, bottom)
    share = 1.0 / (top + bottom)
    return (bottom - top) * share, 2.0 * root(top * bottom) * share, missed


@kernel
def eight_sines(P, k, v, y, c, s):
    """`spherical.sines` of the first solution, or with the sines s negated of the second one: cosine and sine of each.

    The last of the four is the common length that cosine and sine of joint 1 had; 0 where axes 1 and 3 are parallel,
    and the angles mean nothing.
    """
    c2 = P[k + COS_PHASE] * c - P[k + SIN_PHASE] * s
    s2 = P[k + SIN_PHASE] * c + P[k + COS_PHASE] * s
    a1, a2, a3, cross_23 = load3(P, k + A1), load3(P, k + A2), load3(P, k + A3), load3(P, k + CROSS_23)
    t = (1.0 - c2) * P[k + A2_A3]
    u = (
        c2 * a3[0] + s2 * cross_23[0] + t * a2[0],
        c2 * a3[1] + s2 * cross_23[1] + t * a2[1],
        c2 * a3[2] + s2 * cross_23[2] + t * a2[2],
    )
    u_across, v_across = across(u, a1), across(v, a1)
    s1, c1 = dot(a1, cross(u_across, v_across)), dot(u_across, v_across)
    length = root(s1 * s1 + c1 * c1)
    apart = dot(u_across, u_across) > P[SLACK_SINGULAR] * P[SLACK_SINGULAR]
    length = where(apart, length, 0.0)
    share = where(length > 0.0, 1.0 / where(length > 0.0, length, 1.0), 0.0)
    s1, c1 = s1 * share, where(length > 0.0, c1 * share, 1.0)
    z = rotate(a2, c2, -s2, rotate(a1, c1, -s1, y))
    return (c1, s1), (c2, s2), (dot(load3(P, k + ACROSS_3), z), dot(load3(P, k + CROSS_3), z)), length
