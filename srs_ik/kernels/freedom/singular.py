"""Starts where shoulder or wrist is singular.

Where joint 7 makes the roll, an arm angle at which one of them is singular, or almost, leaves the split of a sum or
joint 5 open. A grid of arm angles passes over that.

At a roll, both may be singular at once: joints 1 and 3 share a sum, and 5 and 7 another one. All splits of both are a
surface of postures that meets those around it along a curve only. No grid over rolls and arm angles comes near the rest
of it. At which rolls the shoulder may be singular, the wrist's height along axis 1 tells; the best split is known in
closed form.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import add, dot, load3, rotate, rotation, swing, times
from srs_ik.kernels.freedom.halves import STEEP
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import MOST_STARTS, MOST_TAKEN, START_COST
from srs_ik.kernels.layout.limb import A1, A3, AXES, FAR, FOREARM, MISS, NEAR, SHOULDER, UPPER_ARM, WRIST
from srs_ik.kernels.limb.branches import NO_BRANCH, anchor
from srs_ik.kernels.limb.goal import OUTSIDE, cost, turned
from srs_ik.kernels.limb.in_line import ROUNDED, closest, comes_in_line
from srs_ik.kernels.limb.limits import violation
from srs_ik.kernels.limb.spherical import angles, middle_angle
from srs_ik.kernels.limb.triangle import elbow_side, place, shoulder_to_wrist

WIDE = 0.1
"""Outer axes that come this close to one line, rad, may do so between two arm angles of a grid."""

STILL = 1e-9
"""A roll that changes the height by less, by the reach, leaves the wrist in its place."""

NEARLY = 1e-3
"""Axes that come this close to one line, rad, are taken for singular: searches find the rest."""

TOUCHES = 1.0 + NEARLY * NEARLY
"""A cosine up to this is one: where the tip lies on axis 7, the height touches zero as the wrist becomes singular."""


@kernel
def rolled(pose, axis, roll):
    """A pose rolled about an axis of the tip."""
    return times(pose[0], rotation(axis, math.cos(roll), math.sin(roll))), pose[1]


@kernel
def height(P, pose, end):
    """How far the wrist is along axis 1, less how far it is with the shoulder singular: zero where it may be so."""
    sw = shoulder_to_wrist(P, pose[0], pose[1])
    far, near = P[FAR] * P[FAR], P[NEAR] * P[NEAR]
    bend = 1.0 + 2.0 * (dot(sw, sw) - far) / (far - near)
    w = add(load3(P, UPPER_ARM), rotate(load3(P, AXES + 9), bend, 0.0, load3(P, FOREARM)))
    sign = 1.0 if end == 0 else -1.0
    return dot(load3(P, SHOULDER + A1), sw) - sign * dot(load3(P, SHOULDER + A3), w)


@kernel
def wave(a, b, c):
    """Constant and amplitude of a wave over a turn, and where it is largest, from its figures at 0, 90 and 180 deg."""
    constant = 0.5 * (a + c)
    return constant, math.hypot(0.5 * (a - c), b - constant), math.atan2(b - constant, 0.5 * (a - c))


@kernel
def singular_shoulder(P, pose, given):
    """Where the shoulder is closest to singular: elbow, motions of shoulder and wrist, arm angle, how far off, rad."""
    q4, shoulder, wrist, _ = elbow_side(P, place(P, pose[0], pose[1]), given[0])
    psi, off, _ = closest(P, SHOULDER, shoulder, given[1])
    return q4, shoulder, wrist, (math.cos(psi), math.sin(psi)), off


@kernel
def at_angle(motion, turn):
    """What a spherical joint has to make at an arm angle."""
    v, y, _ = motion
    return swing(v, turn[0], turn[1]), swing(y, turn[0], turn[1])


@kernel
def wrist_cosine(P, pose, given):
    """Cosine of the angle between the outer axes of the wrist, with the shoulder singular."""
    _, _, wrist, turn, _ = singular_shoulder(P, pose, given)
    v, _ = at_angle(wrist, turn)
    return dot(load3(P, WRIST + A1), v)


@kernel
def add_at(P, pose, given, sought, starts, n):
    """Write the best split of a pose if shoulder and wrist are singular there; return the number of starts."""
    q4, shoulder, wrist, turn, off = singular_shoulder(P, pose, given)
    v, y = at_angle(wrist, turn)
    cosine = dot(load3(P, WRIST + A1), v)
    if off > NEARLY or 1.0 - abs(cosine) > 0.5 * NEARLY * NEARLY or n >= MOST_STARTS - MOST_TAKEN:
        return n
    seeded, wish = sought.seeded, sought.wish
    b = angles(P, WRIST, v, y, math.copysign(1.0, cosine), 0.0, 0, anchor(4, seeded, wish, True))
    v, y = at_angle(shoulder, turn)
    a = angles(P, SHOULDER, v, y, 1.0 if given[1] == 0 else -1.0, 0.0, 0, anchor(0, seeded, wish, True))
    q = turned(P, (a[0], a[1], a[2], q4, b[0], b[1], b[2]), seeded, wish, True)
    value = cost(P, q, seeded, wish, True)
    if value >= OUTSIDE:
        return n
    for j in range(7):
        starts[n, j] = q[j]
    starts[n, START_COST] = value
    return n + 1


@kernel
def rolls_of(P, pose, axis, given):
    """Two rolls at which shoulder and wrist may be singular at once, and whether there are any."""
    quarter, half = rolled(pose, axis, 0.5 * math.pi), rolled(pose, axis, math.pi)
    end = given[1]
    mean, size, top = wave(height(P, pose, end), height(P, quarter, end), height(P, half, end))
    if size > STILL * P[FAR]:
        away = math.acos(min(max(-mean / size, -1.0), 1.0))
        return top - away, top + away, abs(mean) < TOUCHES * size
    # The wrist stays in its place: the roll turns its axes.
    _, _, top = wave(wrist_cosine(P, pose, given), wrist_cosine(P, quarter, given), wrist_cosine(P, half, given))
    return top, top + math.pi, abs(mean) < NEARLY * P[FAR]


@kernel
def add_both_singular(P, pose, axis, sought, starts, n):
    """Write the best splits at all rolls at which shoulder and wrist are singular; return the number of starts."""
    if P[MISS] > ROUNDED * P[FAR] or not (comes_in_line(P, WRIST, 0) or comes_in_line(P, WRIST, 1)):
        return n
    for elbow in range(2):
        for end in range(2):
            if comes_in_line(P, SHOULDER, end):
                given = elbow, end
                one, other, any_ = rolls_of(P, pose, axis, given)
                if any_:
                    n = add_at(P, rolled(pose, axis, one), given, sought, starts, n)
                    n = add_at(P, rolled(pose, axis, other), given, sought, starts, n)
    return n


@kernel
def write_singular(P, side, turn, branch, sought, start):
    """Write the posture of a branch at an arm angle, joint 7 and splits as they are wanted, and what it costs."""
    q4, shoulder, wrist, _ = side
    wish = sought.wish
    v, y = at_angle(shoulder, turn)
    c, s, reached = middle_angle(P, SHOULDER, v)
    if s < NEARLY:
        c, s = math.copysign(1.0, c), 0.0
    a = angles(P, SHOULDER, v, y, c, s, branch >> 1, anchor(0, True, wish, True))
    v, y = at_angle(wrist, turn)
    c, s, ends = middle_angle(P, WRIST, v)
    b = angles(P, WRIST, v, y, c, s, branch & 1, anchor(4, True, wish, True))
    fifth = wish[4] if s < NEARLY else b[0]
    q = turned(P, (a[0], a[1], a[2], q4, fifth, b[1], wish[6]), True, wish, True)
    value = 0.0
    for j in range(7):
        start[j] = q[j]
        value += (q[j] - wish[j]) ** 2 + STEEP * violation(P, j, q[j])
    start[START_COST] = value if reached and ends else NO_BRANCH


@kernel
def add_singular(P, pose, sought, starts, n):
    """Write starts at arm angles where shoulder or wrist is singular, or almost, and joint 7 makes the roll."""
    place_ = place(P, pose[0], pose[1])
    for elbow in range(2):
        side = elbow_side(P, place_, elbow)
        for i in range(4):
            k, motion = (SHOULDER, side[1]) if i < 2 else (WRIST, side[2])
            psi, off, _ = closest(P, k, motion, i % 2)
            if off < WIDE and comes_in_line(P, k, i % 2) and n < MOST_STARTS - MOST_TAKEN - 4:
                for branch in range(4):
                    write_singular(P, side, (math.cos(psi), math.sin(psi)), branch, sought, row(starts, n + branch))
                n += 4
    return n
