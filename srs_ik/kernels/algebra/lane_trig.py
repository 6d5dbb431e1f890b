"""Cosines and sines of eight angles at once: of a call of `math` each, the eight would take most of the time."""

import math

from srs_ik.kernels.algebra.lanes import eight_of, one_of, where, whole_number
from srs_ik.kernels.jit import kernel

HALF_PI = 0.5 * math.pi
TAN_SIXTEENTH = 0.41421356237309503
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
def angle_of(c, s):
    """The angle of a cosine and a sine of any length, in [-pi, pi]; zero where both are zero.

    Angles are taken from the nearest multiple of an eighth of a turn, where the power series of the arctangent, its
    last terms fitted, has all digits.
    """
    x, y = abs(c), abs(s)
    less, more = where(x < y, x, y), where(x < y, y, x)
    slanting = less > TAN_SIXTEENTH * more
    t = where(slanting, less - more, less) / (where(slanting, less + more, more) + TINY)
    z = t * t
    rest = -0.06640233842869744 + z * (0.056883487686028446 - z * (0.04348050891958043 - z * 0.02113535694575133))
    rest = 0.11111106180425145 - z * (0.09090773074092884 - z * (0.07689953486227682 + z * rest))
    rest = 0.3333333333332844 - z * (0.199999999988551 - z * (0.1428571418097571 - z * rest))
    angle = t - t * (z * rest)
    angle = where(slanting, HALF_PI * 0.5 + angle, angle)
    angle = where(x < y, HALF_PI - angle, angle)
    angle = where(c < 0.0, 2.0 * HALF_PI - angle, angle)
    return where(s < 0.0, -angle, angle)


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
