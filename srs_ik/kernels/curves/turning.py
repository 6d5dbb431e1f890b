"""Where the arm angle turns around between two postures of a curve."""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import difference, dot7
from srs_ik.kernels.algebra.lanes import eight_of, one_of
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.curves.in_step import between_eight, short_ways
from srs_ik.kernels.curves.told import angle_at, arm_angles
from srs_ik.kernels.jit import kernel

ROUNDS = 16
TURNED = 1e-12
"""Rounds of eight looks, at most, and how well an arm angle is to be foretold, rad."""

CLOSER = 7.0 / 24.0
"""The looks of a round are spread over this part of what is between two of the round before."""

FINEST = 1e-9
"""The turn is between two postures this close together, as a part of the chord."""


@kernel
def lowest_of_eight(heights, met):
    """The lowest of eight heights that are met (bits); -1 where none is."""
    best = -1
    for i in range(8):
        if (met >> i) & 1 == 1 and (best < 0 or one_of(heights, i) < one_of(heights, best)):
            best = i
    return best


@kernel
def turning_between(P, by, a, b, rise):
    """Where the arm angle, from one posture of a curve to another close by, is farthest to one side, and how far ahead.

    Eight postures at a time tell the arm angle and its rate; the cubic around the farthest one foretells the turn, and
    tells where to look next. `rise` is the sign of the side. Returns the share of the chord, and the angle from that
    of the first posture.
    """
    chord = difference(a, b)
    length2 = dot7(chord, chord)
    psi = angle_at(P, by, a)
    share, height = 0.0, 0.0
    low, high = 0.0, 1.0
    begin, apart = 0.0, 1.0 / 7.0
    # A cubic's error is of the fourth order.
    less = 1.0
    steps = eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    for _ in range(ROUNDS):
        q, t, met = between_eight(P, by, a, chord, begin + apart * steps)
        angles, rates = arm_angles(P, by.target.place, q, t)
        heights = -rise * short_ways(angles - psi)
        slopes = -rise * rates * length2 / dot7(t, chord)
        best = lowest_of_eight(heights, met)
        if best < 0:
            break
        other = best + 1 if one_of(slopes, best) < 0.0 else best - 1
        if other < 0:
            high = begin
        elif other > 7:
            low = begin + 7.0 * apart
        else:
            i, j = min(best, other), max(best, other)
            low, high = begin + apart * i, begin + apart * j
            fall, rises = one_of(slopes, i), one_of(slopes, j)
            if (met >> i) & (met >> j) & 1 == 1 and fall < 0.0 < rises:
                before, behind = (low, one_of(heights, i), fall), (high, one_of(heights, j), rises)
                share, foretold = lowest_of_cubic(before, behind, 0.0)
                change, height = abs(foretold - height), foretold
                if change * less < TURNED:
                    break
                less = CLOSER**4 / 7.0**4
                apart = CLOSER / 7.0 * (high - low)
                begin = min(max(share - 3.5 * apart, low), high - 7.0 * apart)
                continue
        share, height = begin + apart * best, one_of(heights, best)
        if high - low < FINEST:
            break
        begin, apart, less = low, (high - low) / 7.0, 1.0
    return share, -rise * height
