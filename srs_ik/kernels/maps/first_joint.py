"""How far joint 1 runs over an interval of arm angles of an exact limb, with both ends and its turning points.

The upper arm's direction v moves on a circle with the arm angle, and b(q1) = rot(a1, q1) a2 has a known product with
it. Joint 1 turns where two arm angles for one q1 become one: where that linear form in cosine and sine of the arm
angle touches its value. With perpendicular axes this is a quadratic form in cosine and sine of q1: two directions.
"""

import math

from srs_ik.kernels.algebra.vectors import across, cross, dot, load3, rotate, swing
from srs_ik.kernels.exact.events import TOUCH
from srs_ik.kernels.exact.gaps import turned_with
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import A1, A1_A2, A2, A2_A3, BOTTOM_GAP, SHOULDER, TOP_GAP
from srs_ik.kernels.limb.spherical import middle_angle, sines
from srs_ik.kernels.limb.splits import split_range

TURN = 2.0 * math.pi

STILL = 1e-10
"""A circle of the upper arm with a smaller radius is a point."""

ROUNDING = 1e-7
"""A step of joint 1 against its direction by less than this, rad, is rounding; by more, the rest of a turn."""

LOOKS = 48
HALVINGS = 50
"""Oblique axes: arm angles at which the direction of joint 1 is looked at, and bisections of a change."""


@kernel
def first_angle(P, motion, psi, sign):
    """Joint 1 at an arm angle in one solution of the shoulder, and the direction b of axis 2 there."""
    v, y = turned_with(motion, psi)
    c, s, _ = middle_angle(P, SHOULDER, v)
    (c1, s1), _, _, _ = sines(P, SHOULDER, v, y, c, s if sign == 0 else -s)
    return math.atan2(s1, c1), rotate(load3(P, SHOULDER + A1), c1, s1, load3(P, SHOULDER + A2))


@kernel
def direction(P, motion, psi, sign):
    """A figure with the sign of d(q1)/d(arm angle): positive where joint 1 grows."""
    v0, _, _ = motion
    c, s = math.cos(psi), math.sin(psi)
    v = swing(v0, c, s)
    dv = (v0[2][0] * c - v0[1][0] * s, v0[2][1] * c - v0[1][1] * s, v0[2][2] * c - v0[1][2] * s)
    _, b = first_angle(P, motion, psi, sign)
    return dot(b, dv) * dot(b, cross(load3(P, SHOULDER + A1), v))


@kernel
def turning_points(P, motion):
    """The arm angles at which joint 1 may turn, of a shoulder with perpendicular axes: how many, and two of them."""
    (v0, vc, vs), _, _ = motion
    a1 = load3(P, SHOULDER + A1)
    e = across(load3(P, SHOULDER + A2), a1)
    f = cross(a1, e)
    e0, ec, es = dot(e, v0), dot(e, vc), dot(e, vs)
    f0, fc, fs = dot(f, v0), dot(f, vc), dot(f, vs)
    ee = ec * ec + es * es - e0 * e0
    ff = fc * fc + fs * fs - f0 * f0
    ef = ec * fc + es * fs - e0 * f0
    half = 0.5 * (ee - ff)
    length = math.hypot(half, ef)
    rest = -0.5 * (ee + ff)
    if length < 1e-15 or abs(rest) > length:
        return 0, 0.0, 0.0
    middle, apart = math.atan2(ef, half), math.acos(rest / length)
    first = touching(0.5 * (middle + apart), e0, ec, es, f0, fc, fs)
    return 2, first, touching(0.5 * (middle - apart), e0, ec, es, f0, fc, fs)


@kernel
def touching(q1, e0, ec, es, f0, fc, fs):
    """The arm angle at which the linear form of a joint angle touches zero."""
    c, s = math.cos(q1), math.sin(q1)
    x0, xc, xs = c * e0 + s * f0, c * ec + s * fc, c * es + s * fs
    return math.atan2(-xs, -xc) if x0 > 0.0 else math.atan2(xs, xc)


@kernel
def step(P, motion, sign, a, b, q_a, q_b):
    """How far joint 1 goes between two arm angles without turning, from its angles there."""
    way = q_b - q_a
    way -= TURN * math.floor(way / TURN + 0.5)
    grows = direction(P, motion, 0.5 * (a + b), sign) > 0.0
    if grows and way < -ROUNDING:
        return way + TURN
    if not grows and way > ROUNDING:
        return way - TURN
    return way


@kernel
def run_between(P, motion, sign, a, b, run):
    """The run of joint 1, as (angle now, lowest, highest), after it has gone on from arm angle a to b."""
    now, lowest, highest = run
    if b <= a:
        return run
    q_a, _ = first_angle(P, motion, a, sign)
    q_b, _ = first_angle(P, motion, b, sign)
    now += step(P, motion, sign, a, b, q_a, q_b)
    return now, min(lowest, now), max(highest, now)


@kernel
def ahead(psi, lower):
    """The turn of an arm angle that comes first from a lower end on."""
    return psi - TURN * math.floor((psi - lower) / TURN)


@kernel
def is_still(motion):
    """Whether the upper arm stands still: a straight elbow."""
    _, vc, vs = motion[0]
    return dot(vc, vc) + dot(vs, vs) < STILL * STILL


@kernel
def first_range(P, motion, turns, sign, lower, upper):
    """The lowest and the highest angle of joint 1 over an interval of arm angles without a singularity inside.

    `turns` are those of `turning_points`. Both may be any number of turns away from the limits.
    """
    q, _ = first_angle(P, motion, lower, sign)
    if upper <= lower or is_still(motion):
        return q, q
    if P[SHOULDER + A1_A2] != 0.0 or P[SHOULDER + A2_A3] != 0.0:
        return oblique_range(P, motion, sign, lower, upper, q)
    count, x, y = turns
    run = (q, q, q)
    if count == 0:
        if upper - lower >= TURN - TOUCH:
            return q - math.pi, q + math.pi
        run = run_between(P, motion, sign, lower, upper, run)
        return run[1], run[2]
    x, y = ahead(x, lower), ahead(y, lower)
    x, y = min(min(x, y), upper), min(max(x, y), upper)
    run = run_between(P, motion, sign, lower, x, run)
    run = run_between(P, motion, sign, x, y, run)
    run = run_between(P, motion, sign, y, upper, run)
    return run[1], run[2]


@kernel
def oblique_range(P, motion, sign, lower, upper, q):
    """`first_range` where axes are oblique: each change of direction is bracketed and bisected."""
    count = 2 + int((upper - lower) / TURN * LOOKS)
    run = (q, q, q)
    begin = lower
    a, was = lower, direction(P, motion, lower, sign) > 0.0
    changes = 0
    for i in range(1, count + 1):
        b = lower + (upper - lower) * i / count
        grows = direction(P, motion, b, sign) > 0.0
        if grows != was:
            low, high = a, b
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if (direction(P, motion, middle, sign) > 0.0) == was:
                    low = middle
                else:
                    high = middle
            run = run_between(P, motion, sign, begin, low, run)
            begin = low
            changes += 1
        a, was = b, grows
    if changes == 0 and upper - lower >= TURN - TOUCH:
        return q - math.pi, q + math.pi
    run = run_between(P, motion, sign, begin, upper, run)
    return run[1], run[2]


@kernel
def singular_angle(P, motion, end):
    """Where the outer axes of the shoulder come into line, pointing the same way (end 0) or not: arm angle, whether."""
    if P[SHOULDER + (TOP_GAP if end == 0 else BOTTOM_GAP)] > TOUCH:
        return 0.0, False
    toward = 1.0 if end == 0 else -1.0
    a1 = load3(P, SHOULDER + A1)
    v0, vc, vs = motion[0]
    constant, c, s = toward * dot(a1, v0), toward * dot(a1, vc), toward * dot(a1, vs)
    if constant + math.hypot(c, s) <= 1.0 - TOUCH:
        return 0.0, False
    return math.atan2(s, c), True


@kernel
def split_angles(P, motion, psi, end):
    """The lowest and highest angle of joint 1 with joint 3 inside its limits, where only their sum is fixed."""
    v, y = turned_with(motion, psi)
    c, s, _ = middle_angle(P, SHOULDER, v)
    _, _, (c3, s3), length = sines(P, SHOULDER, v, y, c, s)
    toward = 1.0 if end == 0 else -1.0
    total = math.atan2(s3, c3)
    if length > 0.0:
        q, _ = first_angle(P, motion, psi, 0)
        total += toward * q
    low, high = split_range(P, 0, total, toward)
    if not math.isfinite(high - low):
        return -math.pi, math.pi
    return (low, high) if toward > 0.0 else (-high, -low)
