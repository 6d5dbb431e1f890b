"""Waves around a turn, of eight figures: what is between these, and where it is zero."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from srs_ik.kernels.algebra.lane_trig import turn, turned_by
from srs_ik.kernels.algebra.lanes import eight_of, one_of, smaller, where
from srs_ik.kernels.jit import kernel

PIECES = 32
"""Pieces of a turn, on which zeros are looked for."""

HALF_ROOT = math.sqrt(0.5)


class Waves(NamedTuple):
    """A constant, three waves, each of a cosine and a sine, and how much of a fourth there is."""

    constant: Any
    first: Any
    second: Any
    third: Any
    fourth: Any


@kernel
def waves_of(figures):
    """The waves of eight figures around a turn."""
    plus_0, minus_0 = one_of(figures, 0) + one_of(figures, 4), one_of(figures, 0) - one_of(figures, 4)
    plus_1, minus_1 = one_of(figures, 1) + one_of(figures, 5), one_of(figures, 1) - one_of(figures, 5)
    plus_2, minus_2 = one_of(figures, 2) + one_of(figures, 6), one_of(figures, 2) - one_of(figures, 6)
    plus_3, minus_3 = one_of(figures, 3) + one_of(figures, 7), one_of(figures, 3) - one_of(figures, 7)
    less, more = HALF_ROOT * (minus_1 - minus_3), HALF_ROOT * (minus_1 + minus_3)
    return Waves(
        0.125 * (plus_0 + plus_1 + plus_2 + plus_3),
        (0.25 * (minus_0 + less), 0.25 * (more + minus_2)),
        (0.25 * (plus_0 - plus_2), 0.25 * (plus_1 - plus_3)),
        (0.25 * (minus_0 - less), 0.25 * (more - minus_2)),
        0.125 * abs(plus_0 - plus_1 + plus_2 - plus_3),
    )


@kernel
def size_of(wave):
    """The most that a wave comes to."""
    return math.sqrt(wave[0] * wave[0] + wave[1] * wave[1])


@kernel
def along_waves(waves, turn_):
    """The sum of constant and three waves at eight angles, given as cosines and sines, and its rate."""
    first, second, third = waves.first, waves.second, waves.third
    c, s = turn_
    c2, s2 = c * c - s * s, 2.0 * s * c
    c3, s3 = c2 * c - s2 * s, s2 * c + c2 * s
    value = first[0] * c + first[1] * s + second[0] * c2 + second[1] * s2 + third[0] * c3 + third[1] * s3
    rate = first[1] * c - first[0] * s + 2.0 * (second[1] * c2 - second[0] * s2) + 3.0 * (third[1] * c3 - third[0] * s3)
    return waves.constant + value, rate


@kernel
def zeros_of(waves):
    """How many zeros three waves have, and how close to zero, at the least, they turn around, or almost."""
    step = 2.0 * math.pi / PIECES
    # No rate changes its own rate by more: with a higher one at an end, they turn around once at most on a piece.
    bends = size_of(waves.first) + 8.0 * size_of(waves.second) + 27.0 * size_of(waves.third)
    slow = step * step * bends
    at = step * eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    none = 0.0 * at
    changes, nearest = none, none + math.inf
    for k in range(PIECES // 8):
        here = turn(at + 8.0 * k * step)
        a, rate_a = along_waves(waves, here)
        b, rate_b = along_waves(waves, turned_by(here, none + step))
        changes = changes + where((a < 0.0) & (b > 0.0) | (a > 0.0) & (b < 0.0), none + 1.0, none)
        # The waves are on one side of their tangents at both ends of a piece, which meet here.
        bend = rate_b - rate_a
        meet = a + rate_a * (step * rate_b - (b - a)) / where(abs(bend) > 0.0, bend, none + 1.0)
        least = smaller(smaller(abs(a), abs(b)), abs(meet))
        least = where(smaller(a * b, a * meet) > 0.0, least, none)
        nearest = where(rate_a * rate_b > 0.0, nearest, smaller(nearest, least))
        nearest = where(abs(rate_a) > slow, nearest, smaller(nearest, abs(a)))
    count, closest = 0.0, math.inf
    for i in range(8):
        count += one_of(changes, i)
        closest = min(closest, one_of(nearest, i))
    return int(count), closest
