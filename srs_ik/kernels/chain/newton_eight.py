"""Newton's method for eight postures of a near limb in step, at an arm angle: eight cost hardly more than one.

The equations are those of `newton.close_at_angle`, solved without pivots: the three wrist joints are eliminated by the
inverse of their axes, the other four follow by Cramer's rule. Where that divides by almost nothing, next to a
singularity, the steps do not settle, and the posture counts as not met.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from srs_ik.kernels.algebra.joint_vectors import along7, dot7
from srs_ik.kernels.algebra.lane_trig import turned_by, turns_of
from srs_ik.kernels.algebra.lanes import ALL, as_bits, larger, root, where
from srs_ik.kernels.algebra.vectors import add, along, apply, cross, dot, load3, load9, scale, sub, swing
from srs_ik.kernels.chain.kinematics import first_line, joint_line, turn_between
from srs_ik.kernels.chain.newton import BOUNCES, CLOSED, LAST_STEP, MAX_STEP, ON_LINE
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import ELBOW_CENTRE, FAR, SHOULDER_CENTRE, TIP_POSITION, TIP_ROTATION

NOTHING = 1e-15
"""A step this short, rad, need not be taken ..."""

PROBED = 1e-10
"""... nor this one where a posture is only looked at, and closed if it is taken."""

EXPECTED = 300.0
"""The step before the first counts as so many times the root of what need not be taken, rad: a first step below
(EXPECTED * short)^(2/3) is the last."""

SHORT = 0.01
"""After a longer step, rad, the next one but one is not foreseen."""

SMALLEST = (0.1 * CLOSED) ** 2

AS_NOTHING = 1e-30
"""What is smaller counts as this where steps divide by it: exactly singular postures make them long, but numbers."""


@kernel
def inverse(x):
    """One over each of eight floats, which may be as good as nothing."""
    return 1.0 / where(abs(x) > AS_NOTHING, x, 0.0 * x + AS_NOTHING)


@kernel
def largest(d):
    """The largest magnitude of seven in each of eight postures."""
    shoulder = larger(larger(abs(d[0]), abs(d[1])), abs(d[2]))
    return larger(larger(shoulder, abs(d[3])), larger(larger(abs(d[4]), abs(d[5])), abs(d[6])))


@kernel
def all_times(f, d):
    """The steps f d."""
    return f * d[0], f * d[1], f * d[2], f * d[3], f * d[4], f * d[5], f * d[6]


@kernel
def turned_by_all(turns, d):
    """The cosines and sines of eight postures after small steps."""
    return (
        turned_by(turns[0], d[0]),
        turned_by(turns[1], d[1]),
        turned_by(turns[2], d[2]),
        turned_by(turns[3], d[3]),
        turned_by(turns[4], d[4]),
        turned_by(turns[5], d[5]),
        turned_by(turns[6], d[6]),
    )


@kernel
def without_wrist(a, m, wrist, m5, m6, m7):
    """What is left of a motion (a, m) when joints 5 to 7 take its turn a: they are turned by wrist'a."""
    return along(along(along(m, -dot(wrist[0], a), m5), -dot(wrist[1], a), m6), -dot(wrist[2], a), m7)


class Reduced(NamedTuple):
    """Eight postures' equations of a pose, joints 5 to 7 eliminated: what is left of four joints, and of the pose."""

    axes: Any  # of joints 1 to 4
    motions: Any  # of joints 1 to 3, as moments about the base origin
    s: Any  # what is left of the motions of joints 1 to 4
    rest: Any  # what is left of the way to the pose
    wrist: Any  # the inverse of axes 5 to 7
    volume: Any  # what these axes span
    to_position: Any
    angular: Any
    elbow: Any
    forward: Any  # twice the cosine of the turn to the pose: not half a turn away, where sines vanish too


@kernel
def reduced(P, turns, R, p):
    """The equations of a pose at eight postures, given as cosines and sines."""
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
    inverse5 = cross(a6, a7)
    volume = dot(a5, inverse5)
    share = inverse(volume)
    wrist = (scale(share, inverse5), scale(share, cross(a7, a5)), scale(share, cross(a5, a6)))
    s = (
        without_wrist(a1, m1, wrist, m5, m6, m7),
        without_wrist(a2, m2, wrist, m5, m6, m7),
        without_wrist(a3, m3, wrist, m5, m6, m7),
        without_wrist(a4, m4, wrist, m5, m6, m7),
    )
    rest = without_wrist(angular, linear, wrist, m5, m6, m7)
    return Reduced((a1, a2, a3, a4), (m1, m2, m3), s, rest, wrist, volume, to_position, angular, elbow, cosine2)


@kernel
def with_wrist(made, turn_, d1, d2, d3, d4):
    """The steps of four joints and what the wrist does about them, to make up for a turn."""
    a1, a2, a3, a4 = made.axes
    w = along(along(along(along(turn_, -d1, a1), -d2, a2), -d3, a3), -d4, a4)
    return d1, d2, d3, d4, dot(made.wrist[0], w), dot(made.wrist[1], w), dot(made.wrist[2], w)


@kernel
def elbow_rates(P, made, b):
    """How joints 1 to 3 move the elbow along a normal of its half-plane, and how far it has to go."""
    a1, a2, a3, _ = made.axes
    m1, m2, m3 = made.motions
    lever = cross(made.elbow, b)
    e1 = dot(b, m1) + dot(lever, a1)
    e2 = dot(b, m2) + dot(lever, a2)
    e3 = dot(b, m3) + dot(lever, a3)
    return e1, e2, e3, -dot(b, sub(made.elbow, load3(P, SHOULDER_CENTRE)))


@kernel
def newton_step(P, turns, R, p, h, b):
    """The step of each joint towards a pose and the half-plane (h, normal b) of an arm angle.

    Returns the steps, the rates with the arm angle at this pose, the square of what the steps have to make up for
    (m, rad), and whether elbow and hand are on the right side.
    """
    made = reduced(P, turns, R, p)
    s1, s2, s3, s4 = made.s
    reach = sub(made.elbow, load3(P, SHOULDER_CENTRE))
    e1, e2, e3, e = elbow_rates(P, made, b)
    # s1 d1 + ... + s4 d4 = rest and e1 d1 + e2 d2 + e3 d3 = e.
    s = made.rest
    g1 = cross(s1, s4)
    g2 = cross(s2, s4)
    g3 = cross(s3, s4)
    n1 = dot(s2, g3)
    n2 = dot(s1, g3)
    n3 = dot(s1, g2)
    share = inverse(e2 * n2 - e1 * n1 - e3 * n3)
    d1 = share * (e2 * dot(s, g3) - e3 * dot(s, g2) - e * n1)
    d2 = share * (e3 * dot(s, g1) - e1 * dot(s, g3) + e * n2)
    d3 = share * (e1 * dot(s, g2) - e2 * dot(s, g1) - e * n3)
    rest = along(along(along(s, -d1, s1), -d2, s2), -d3, s3)
    d = with_wrist(made, made.angular, d1, d2, d3, dot(rest, s4) / dot(s4, s4))
    # The same with nothing to make up for but the elbow's way with the half-plane.
    share = share * dot(h, reach)
    r1 = -share * n1
    r2 = share * n2
    r3 = -share * n3
    turning = along(along(scale(-r1, s1), -r2, s2), -r3, s3)
    rates = with_wrist(made, (0.0, 0.0, 0.0), r1, r2, r3, dot(turning, s4) / dot(s4, s4))
    off2 = dot(made.to_position, made.to_position) + dot(made.angular, made.angular) + e * e
    right = (dot(h, reach) > -ON_LINE * P[FAR]) & (made.forward > 0.0)
    return d, rates, off2, right


@kernel
def dot_four(a, b):
    """Scalar products of four figures each."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@kernel
def curve_ways(made):
    """The unit vectors along the curves of eight postures (oriented like `follow.null_vector`)."""
    s1, s2, s3, s4 = made.s
    g12 = cross(s1, s2)
    g34 = cross(s3, s4)
    n = (dot(s2, g34), -dot(s1, g34), dot(s4, g12), -dot(s3, g12))
    along_curve = with_wrist(made, (0.0, 0.0, 0.0), n[0], n[1], n[2], n[3])
    size2 = dot7(along_curve, along_curve)
    return all_times(where(made.volume < 0.0, 0.0 * size2 - 1.0, 0.0 * size2 + 1.0) * inverse(root(size2)), along_curve)


@kernel
def curve_step(P, turns, R, p, d, off):
    """The step of each joint towards a pose in which it goes by `off` in a direction d, and the way of the curve there.

    Returns the steps, the unit vectors along the curves, the square of what the steps have to make up for (m, rad), and
    whether the hand is on the right side.
    """
    made = reduced(P, turns, R, p)
    t = curve_ways(made)
    s1, s2, s3, s4 = made.s
    # The shortest way of four joints to what is left of the pose, by the inverse of S S'.
    x = (s1[0], s2[0], s3[0], s4[0])
    y = (s1[1], s2[1], s3[1], s4[1])
    z = (s1[2], s2[2], s3[2], s4[2])
    xx, yy, zz = dot_four(x, x), dot_four(y, y), dot_four(z, z)
    xy, xz, yz = dot_four(x, y), dot_four(x, z), dot_four(y, z)
    c = made.rest
    cx, cy, cz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    share = inverse(xx * cx + xy * cy + xz * cz)
    u = share * (cx * c[0] + cy * c[1] + cz * c[2])
    v = share * (cy * c[0] + (xx * zz - xz * xz) * c[1] + (xy * xz - xx * yz) * c[2])
    w = share * (cz * c[0] + (xy * xz - xx * yz) * c[1] + (xx * yy - xy * xy) * c[2])
    step = with_wrist(
        made,
        made.angular,
        x[0] * u + y[0] * v + z[0] * w,
        x[1] * u + y[1] * v + z[1] * w,
        x[2] * u + y[2] * v + z[2] * w,
        x[3] * u + y[3] * v + z[3] * w,
    )
    step = along7(step, (off - dot7(d, step)) / dot7(d, t), t)
    off2 = dot(made.to_position, made.to_position) + dot(made.angular, made.angular)
    return step, t, off2, made.forward > 0.0


@kernel
def half_planes(t, h0, turn_):
    """The half-planes of arm angles, given as cosine and sine: directions across S-W, and their normals."""
    c, s = turn_
    b0 = cross(t, h0)
    none = (0.0, 0.0, 0.0)
    return swing((none, h0, b0), c, s), swing((none, b0, h0), c, -s)


@kernel
def close_eight(P, q, R, p, t, h0, psi, steps):
    """Newton's method for eight postures, the pose and one arm angle together: the postures, which are met, as bits."""
    q, _, met = close_in_planes(P, q, R, p, half_planes(t, h0, (math.cos(psi), math.sin(psi))), (steps, NOTHING))
    return q, met


@kernel
def is_foreseen(size, last, short):
    """Whether the steps after those of a size need not be taken, since they will be that short, rad.

    Steps shrink like squares: the next one is known from the last two.
    """
    return (size * size * size < short * last * last) & (last < SHORT)


@kernel
def close_in_planes(P, q, R, p, planes, until):
    """Newton's method for eight postures, the pose and an arm angle together.

    `planes` are those of `half_planes`, `until` the largest number of steps, and how short one need not be taken, rad.
    Returns the postures, their rates with the arm angle before the last step, and as bits which of them meet pose and
    arm angle.
    """
    h, b = planes
    rates = q
    turns = turns_of(q)
    met = 0
    steps, short = until
    last = 0.0 * q[0] + EXPECTED * math.sqrt(short)
    checkpoint = least = last + math.inf
    for step in range(steps):
        d, rates, off2, right = newton_step(P, turns, R, p, h, b)
        size = largest(d)
        # Next to a singularity, rounding may make steps long.
        there = off2 < SMALLEST
        settled = there | is_foreseen(size, last, short)
        f = where(there & (size > LAST_STEP), 0.0 * size, MAX_STEP / larger(size, MAX_STEP + 0.0 * size))
        d = all_times(f, d)
        q = along7(q, 1.0, d)
        last = size
        met = as_bits(settled & right)
        if as_bits(settled) == ALL:
            break
        least = where(off2 < least, off2, least)
        if step % BOUNCES == BOUNCES - 1:
            if as_bits(settled | (least > 0.25 * checkpoint)) == ALL:
                break
            checkpoint = least
        turns = turned_by_all(turns, d)
    return q, rates, met
