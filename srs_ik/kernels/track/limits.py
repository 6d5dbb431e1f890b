"""Velocities that a joint may have in the next period: within its limits, and able to stop before its range ends.

A period has one velocity. Accelerations are differences of these over the period, so that the limits hold for the joint
angles as they are sent out, and not for a continuous motion that would lie behind them.
"""

import math

from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, UPPER
from srs_ik.kernels.layout.track import ACCELERATION, PERIOD, SPEED

BRAKE = 1.0 - 2e-6
"""Share of the largest acceleration that is reckoned with for stopping, so that rounding cannot use up what is left."""

PUSH = 1.0 - 1e-6
"""Share of the largest acceleration that is used."""

RUN = 1.0 - 1e-9
"""Share of the largest velocity that is used."""

NO_END = 1e3
"""A joint that may go on this far, rad, is nowhere near an end."""


@kernel
def stopping_speed(room, acceleration, period):
    """The largest velocity for the next period after which a joint can stop within a distance, rad/s.

    With velocities v, v - a T, v - 2 a T, ... the way is (n + 1) v T - a T^2 n (n + 1) / 2, where n periods follow.
    """
    if room <= 0.0:
        return 0.0
    if room > NO_END:
        return math.inf
    most = acceleration * period
    n = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * room / (most * period)) - 1.0))
    return (room / period + 0.5 * most * n * (n + 1.0)) / (n + 1.0)


@kernel
def bound(P, C, q, v, joint, side):
    """The largest velocity of a joint in the next period up (1.0), or the least one, down (-1.0), rad/s."""
    a = C[ACCELERATION + joint]
    room = P[UPPER + joint] - q[joint] if side > 0.0 else q[joint] - P[LOWER + joint]
    stop = stopping_speed(room, BRAKE * a, C[PERIOD])
    return side * min(RUN * C[SPEED + joint], side * v[joint] + PUSH * a * C[PERIOD], stop)


@kernel
def bounds(P, C, q, v, side):
    """`bound` of all joints."""
    found = row(scratch(1, 7), 0)
    for joint in range(7):
        found[joint] = bound(P, C, q, v, joint, side)
    return read7(found)


@kernel
def toward(C, joint, q, goal, rate):
    """The velocity that brings a joint to a goal in the shortest time and stops it there, relative to the goal's own.

    The goal is where it is at the end of the period, rad, and moves at a rate, rad/s.
    """
    period = C[PERIOD]
    behind = goal - q - period * rate
    still = max(1.0 - abs(rate) / (SLOWLY * C[SPEED + joint]), 0.0)
    share = SHARE + (SHARE_STILL - SHARE) * still
    speed = stopping_speed(abs(behind), share * C[ACCELERATION + joint], period)
    return rate + math.copysign(speed, behind)


SHARE, SHARE_STILL = 0.8, 0.98
"""Share of the largest acceleration that is reckoned with for stopping at a goal that moves, the rest being for the
goal's own, and at one that does not."""

SLOWLY = 0.1
"""A goal that moves at this share of a joint's largest velocity moves."""
