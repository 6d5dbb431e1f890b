"""The turns about a free axis that leave the elbow inside its limits: exactly, from the distance shoulder-wrist.

The wrist moves on a circle with the roll, so the square of that distance is a cosine of it, and the elbow's angle is
known by the distance alone. A pose out of the elbow's range but for a narrow range of rolls is so found at once.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import with_joint
from srs_ik.kernels.algebra.vectors import along, apply, cross, dot, load3, norm, scale, sub
from srs_ik.kernels.freedom.constraints import THIN
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import Liking
from srs_ik.kernels.layout.limb import FAR, IS_CLOSED, LOWER, NEAR, SHOULDER_CENTRE, STRAIGHT, UPPER, WRIST_IN_TIP

ROLLS, ROLLS_WITHOUT_SEED = 24, 16
"""Rolls that are looked at, of a turn: with a seed small sets of postures on limits count, without one wide ones."""

FEWEST = 3
"""The same, in each strip of them."""

CONSTANT = 1e-9
"""A circle of the wrist this small, by the squared reach, leaves the elbow's angle as it is."""

HARDLY = 1e-9
"""By so much of the squared reach rounding may put a wrist beyond what the elbow's limits allow, and more."""

ALMOST_STRAIGHT = 1e-5
"""An elbow bent by less, rad, is straight: the wrist is off by less than rounding."""

SLACK = 0.2
SPARE = 0.02
"""A near limb's elbow may be this far from that of its nearest exact limb, rad, and the square of its reach by this
part of it."""

TURN = 2.0 * math.pi


@kernel
def square_at(P, bend):
    """Square of the distance shoulder-wrist at a bend of the elbow."""
    far, near = P[FAR] * P[FAR], P[NEAR] * P[NEAR]
    return far + 0.5 * (far - near) * (math.cos(bend) - 1.0)


@kernel
def strip_count(lower, upper, seeded):
    """How many rolls of a strip are looked at."""
    rolls = ROLLS if seeded else ROLLS_WITHOUT_SEED
    return int(max(math.ceil(rolls * (upper - lower) / TURN), FEWEST))


@kernel
def both_sides(nearest, farthest, middle, side):
    """The rolls between two angles away from a middle one, as one strip (side 0) or two: whether, and which."""
    if nearest <= 0.0:
        return side == 0, (middle - farthest, middle + farthest)
    if farthest >= math.pi:
        return side == 0, (middle + nearest, middle + TURN - nearest)
    if side == 0:
        return True, (middle + nearest, middle + farthest)
    return True, (middle - farthest, middle - nearest)


@kernel
def circle_of_wrist(P, pose, axis):
    """Square of the distance shoulder-wrist over rolls: its mean, its amplitude, and where it is largest."""
    R, p = pose
    w = load3(P, WRIST_IN_TIP)
    on = scale(dot(axis, w), axis)
    off = sub(w, on)
    start = sub(along(p, 1.0, apply(R, on)), load3(P, SHOULDER_CENTRE))
    a, b = apply(R, off), apply(R, cross(axis, off))
    constant = dot(start, start) + dot(off, off)
    c, s = 2.0 * dot(start, a), 2.0 * dot(start, b)
    return constant, math.sqrt(c * c + s * s), math.atan2(s, c)


@kernel
def held_straight(P, pose, axis, liking):
    """Limits that hold the elbow where it is straight at every roll: no step would find that it has to stay so."""
    constant, swing, _ = circle_of_wrist(P, pose, axis)
    far = P[FAR] * P[FAR]
    if P[IS_CLOSED] != 1.0 or swing > HARDLY * far or constant < square_at(P, ALMOST_STRAIGHT):
        return liking
    e = P[STRAIGHT] + TURN * math.floor((liking.posture[3] - P[STRAIGHT]) / TURN + 0.5)
    e = min(max(e, liking.lower[3]), liking.upper[3])
    lower, upper = with_joint(liking.lower, 3, e), with_joint(liking.upper, 3, e)
    return Liking(liking.posture, liking.weights, lower, upper, liking.rival, liking.rival_posture)


@kernel
def strip(P, pose, freedom, elbow, i):
    """Rolls about an axis of the tip at which one side of the elbow keeps its limits: strip i of at most `STRIPS`.

    A thin cone is searched as its roll; that its axis leans puts the wrist elsewhere.

    Returns:
        Whether there is such a strip; its first and last roll.
    """
    constant, swing, middle = circle_of_wrist(P, pose, freedom.axis)
    sign = 1.0 if elbow == 0 else -1.0
    slack, spare = (0.0, HARDLY) if P[IS_CLOSED] == 1.0 else (SLACK, SPARE)
    leant = freedom.cone * norm(load3(P, WRIST_IN_TIP)) if freedom.cone <= THIN else 0.0
    spare = (spare * P[FAR] + 2.0 * leant) * P[FAR]
    turns, side = i // 2 - 1, i % 2
    low = P[LOWER + 3] - P[STRAIGHT] + TURN * turns - slack
    high = P[UPPER + 3] - P[STRAIGHT] + TURN * turns + slack
    least = max(low if sign > 0.0 else -high, 0.0)
    most = min(high if sign > 0.0 else -low, math.pi)
    if least > most:
        return False, (0.0, 0.0)
    if swing < CONSTANT * P[FAR] * P[FAR]:
        there = square_at(P, most) - spare <= constant + swing and square_at(P, least) + spare >= constant - swing
        found, ends = both_sides(0.0, math.pi, middle, side)
        return there and found, ends
    # The nearest wrist is where the elbow is bent most.
    largest = (square_at(P, least) + spare - constant) / swing
    smallest = (square_at(P, most) - spare - constant) / swing
    if smallest > 1.0 or largest < -1.0:
        return False, (0.0, 0.0)
    return both_sides(math.acos(min(largest, 1.0)), math.acos(max(smallest, -1.0)), middle, side)
