"""Cosines and sines of eight angles at once: of a call of `math` each, the eight would take most of the time."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lanes import eight_of, one_of, where, whole_number
from srs_ik.kernels.jit import kernel

HALF_PI = 0.5 * math.pi
TINY = 1e-300
QUARTER = 1.5707963267341256
QUARTER_REST = 6.077100506506192e-11
"""A quarter of a turn: its first 33 bits, of which small multiples are exact, and the rest of it."""


@kernel
def small_turn(x):
    """Cosine and sine of angles up to 0.8 rad, by their power series."""
    z = x * x
    c = 1.0 / 479001600.0 - z * (1.0 / 87178291200.0 - z * (1.0 / 20922789888000.0))
    c = 1.0 / 720.0 - z * (1.0 / 40320.0 - z * (1.0 / 3628800.0 - z * c))
    s = 1.0 / 39916800.0 - z * (1.0 / 6227020800.0 - z * (1.0 / 1307674368000.0))
    s = 1.0 / 120.0 - z * (1.0 / 5040.0 - z * (1.0 / 362880.0 - z * s))
    return 1.0 - z * (0.5 - z * (1.0 / 24.0 - z * c)), x - x * (z * (1.0 / 6.0 - z * s))


@kernel
def turn(q):
    """Cosine and sine of angles: of what is left of them beside whole quarters of a turn, turned by the quarters."""
    quarters = whole_number(q / QUARTER)
    c, s = small_turn((q - quarters * QUARTER) - quarters * QUARTER_REST)
    halves = whole_number(0.5 * quarters)
    odd = quarters - 2.0 * halves  # -1, 0 or 1
    turned = abs(odd) > 0.5
    sign = 1.0 - 2.0 * abs(halves - 2.0 * whole_number(0.5 * halves))
    return where(turned, -sign * odd * s, sign * c), where(turned, sign * odd * c, sign * s)


@kernel
def rough_angle(c, s):
    """The angle of a cosine and a sine of any length, in [-pi, pi], to 2e-6 rad; any where both are zero."""
    flat = abs(c) > abs(s)
    t = where(flat, s, c) / (where(flat, c, s) + TINY)
    z = t * t
    rough = t * (0.99997726 - z * (0.33262347 - z * (0.19354346 - z * (0.11643287 - z * (0.05265332 - z * 0.0117212)))))
    quarter = where(s < 0.0, 0.0 * s - HALF_PI, 0.0 * s + HALF_PI)
    return where(flat, where(c < 0.0, rough + 2.0 * quarter, rough), quarter - rough)


@kernel
def angle_of(c, s):
    """The angle of a cosine and a sine, in [-pi, pi]: a rough one, and what a turn back by it leaves."""
    rough = rough_angle(c, s)
    cosine, sine = turn(rough)
    left = s * cosine - c * sine
    return rough + left * (1.0 + left * left * (1.0 / 6.0))


@kernel
def turns_of(q):
    """Cosines and sines of seven times eight angles."""
    return turn(q[0]), turn(q[1]), turn(q[2]), turn(q[3]), turn(q[4]), turn(q[5]), turn(q[6])


@kernel
def turned_by(turn_, x):
    """Cosine and sine after a turn by a small angle x."""
    c, s = small_turn(x)
    return turn_[0] * c - turn_[1] * s, turn_[1] * c + turn_[0] * s


@kernel
def seven_turns(q):
    """Cosine and sine of each of seven angles."""
    c, s = turn(eight_of(q[0], q[1], q[2], q[3], q[4], q[5], q[6], 0.0))
    return (
        (one_of(c, 0), one_of(s, 0)),
        (one_of(c, 1), one_of(s, 1)),
        (one_of(c, 2), one_of(s, 2)),
        (one_of(c, 3), one_of(s, 3)),
        (one_of(c, 4), one_of(s, 4)),
        (one_of(c, 5), one_of(s, 5)),
        (one_of(c, 6), one_of(s, 6)),
    )
