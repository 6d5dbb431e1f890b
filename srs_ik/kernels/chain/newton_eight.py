"""Newton's method for eight postures of a near limb in step, at an arm angle: eight cost hardly more than one.

The equations are those of `newton.close_at_angle`, solved without pivots: the three wrist joints are eliminated by the
inverse of their axes, the other four follow by Cramer's rule. Where that divides by almost nothing, next to a
singularity, the steps do not settle, and the posture counts as not met.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lane_trig import turned_by, turns_of
from srs_ik.kernels.algebra.lanes import as_bits, where
from srs_ik.kernels.algebra.vectors import add, along, apply, cross, dot, load3, load9, scale, sub
from srs_ik.kernels.chain.kinematics import first_line, joint_line, turn_between
from srs_ik.kernels.chain.newton import CLOSED, LAST_STEP, MAX_STEP, ON_LINE
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import ELBOW_CENTRE, SHOULDER_CENTRE, TIP_POSITION, TIP_ROTATION

ALL = 0b11111111

NOTHING = 1e-15
"""A step this short, rad, need not be taken."""

SHORT = 0.01
"""After a longer step, rad, the next one but one is not foreseen."""

SMALLEST = (0.1 * CLOSED) ** 2


@kernel
def larger(a, b):
    """The larger of each two floats."""
    return where(a > b, a, b)


@kernel
def without_wrist(a, m, wrist, m5, m6, m7):
    """What is left of a motion (a, m) when joints 5 to 7 take its turn a: they are turned by wrist'a."""
    return along(along(along(m, -dot(wrist[0], a), m5), -dot(wrist[1], a), m6), -dot(wrist[2], a), m7)


@kernel
def newton_step(P, turns, R, p, h, b):
    """The step of each joint towards a pose and the half-plane (h, normal b) of an arm angle.

    Returns the steps, the square of what they have to make up for (m, rad), and whether elbow and hand are on the right
    side: not half a turn away, where sines vanish too.
    """
    a1, m1, M, shift = first_line(P, turns[0])
    a2, m2, M, shift = joint_line(P, 1, turns[1], M, shift)
    a3, m3, M, shift = joint_line(P, 2, turns[2], M, shift)
    elbow = add(apply(M, load3(P, ELBOW_CENTRE)), shift)
    a4, m4, M, shift = joint_line(P, 3, turns[3], M, shift)
    a5, m5, M, shift = joint_line(P, 4, turns[4], M, shift)
    a6, m6, M, shift = joint_line(P, 5, turns[5], M, shift)
    a7, m7, M, shift = joint_line(P, 6, turns[6], M, shift)
    H = load9(P, TIP_ROTATION)
    x = apply(M, (H[0], H[3], H[6]))
    y = apply(M, (H[1], H[4], H[7]))
    position = add(apply(M, load3(P, TIP_POSITION)), shift)
    sine2, cosine2 = turn_between(x, y, cross(x, y), R)
    # Half an angle for its half sine, and two terms of the series between them.
    angular = scale(0.5 + dot(sine2, sine2) * (1.0 / 48.0), sine2)
    to_position = sub(p, position)
    linear = add(to_position, cross(position, angular))
    reach = sub(elbow, load3(P, SHOULDER_CENTRE))
    lever = cross(elbow, b)
    e1 = dot(b, m1) + dot(lever, a1)
    e2 = dot(b, m2) + dot(lever, a2)
    e3 = dot(b, m3) + dot(lever, a3)
    e = -dot(b, reach)

    inverse5 = cross(a6, a7)
    share = 1.0 / dot(a5, inverse5)
    wrist = (scale(share, inverse5), scale(share, cross(a7, a5)), scale(share, cross(a5, a6)))
    s1 = without_wrist(a1, m1, wrist, m5, m6, m7)
    s2 = without_wrist(a2, m2, wrist, m5, m6, m7)
    s3 = without_wrist(a3, m3, wrist, m5, m6, m7)
    s4 = without_wrist(a4, m4, wrist, m5, m6, m7)
    s = without_wrist(angular, linear, wrist, m5, m6, m7)
    # s1 d1 + ... + s4 d4 = s and e1 d1 + e2 d2 + e3 d3 = e.
    g1 = cross(s1, s4)
    g2 = cross(s2, s4)
    g3 = cross(s3, s4)
    n1 = dot(s2, g3)
    n2 = dot(s1, g3)
    n3 = dot(s1, g2)
    share = 1.0 / (e2 * n2 - e1 * n1 - e3 * n3)
    d1 = share * (e2 * dot(s, g3) - e3 * dot(s, g2) - e * n1)
    d2 = share * (e3 * dot(s, g1) - e1 * dot(s, g3) + e * n2)
    d3 = share * (e1 * dot(s, g2) - e2 * dot(s, g1) - e * n3)
    rest = along(along(along(s, -d1, s1), -d2, s2), -d3, s3)
    d4 = dot(rest, s4) / dot(s4, s4)
    w = along(along(along(along(angular, -d1, a1), -d2, a2), -d3, a3), -d4, a4)
    off2 = dot(to_position, to_position) + dot(angular, angular) + e * e
    right = (dot(h, reach) > -ON_LINE) & (cosine2 > 0.0)
    return (d1, d2, d3, d4, dot(wrist[0], w), dot(wrist[1], w), dot(wrist[2], w)), off2, right


@kernel
def close_eight(P, q, R, p, t, h0, psi, steps):
    """Newton's method for eight postures, the pose and the arm angle together.

    Args:
        P: packed limb.
        q: seven times eight joint angles to start from.
        R: rotation of the wanted tip pose.
        p: position of the wanted tip pose.
        t: direction S-W of the pose.
        h0: zero direction of the arm angle.
        psi: wanted arm angle.
        steps: largest number of steps.

    Returns:
        The postures, and as bits which of them meet pose and arm angle.
    """
    h = along(scale(math.cos(psi), h0), math.sin(psi), cross(t, h0))
    b = cross(t, h)
    turns = turns_of(q)
    met = 0
    last = 0.0 * q[0]
    for _ in range(steps):
        d, off2, right = newton_step(P, turns, R, p, h, b)
        size = larger(larger(larger(abs(d[0]), abs(d[1])), larger(abs(d[2]), abs(d[3]))), larger(abs(d[4]), abs(d[5])))
        size = larger(size, abs(d[6]))
        # Steps shrink like squares, so the next one is foreseen. Next to a singularity, rounding may make them long.
        there = off2 < SMALLEST
        settled = there | ((size * size * size < NOTHING * last * last) & (last < SHORT))
        f = where(there & (size > LAST_STEP), 0.0 * size, MAX_STEP / larger(size, MAX_STEP + 0.0 * size))
        d = (f * d[0], f * d[1], f * d[2], f * d[3], f * d[4], f * d[5], f * d[6])
        q = (q[0] + d[0], q[1] + d[1], q[2] + d[2], q[3] + d[3], q[4] + d[4], q[5] + d[5], q[6] + d[6])
        last = size
        met = as_bits(settled & right)
        if as_bits(settled) == ALL:
            break
        turns = (
            turned_by(turns[0], d[0]),
            turned_by(turns[1], d[1]),
            turned_by(turns[2], d[2]),
            turned_by(turns[3], d[3]),
            turned_by(turns[4], d[4]),
            turned_by(turns[5], d[5]),
            turned_by(turns[6], d[6]),
        )
    return q, met
