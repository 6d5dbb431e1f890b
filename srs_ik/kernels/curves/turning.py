"""Where the arm angle turns around between two postures of a curve."""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import difference, dot7
from srs_ik.kernels.algebra.lanes import eight_of, one_of
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.chain.newton_eight import all_along, dot_seven
from srs_ik.kernels.curves.in_step import between_eight, short_ways
from srs_ik.kernels.curves.told import LITTLE, angle_at, arm_angles
from srs_ik.kernels.jit import kernel

ROUNDS = 12
TURNED = 1e-12
"""Rounds of eight looks, at most, and how well an arm angle is to be foretold, rad."""

CLOSER = 1.0 / 24.0
LESS = CLOSER**4
WIDER = 4.0
"""Looks of the next round are closer together by the first; what a cubic foretells is wrong by less by the second. They
are farther apart by the third where the turn lies beyond them."""


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
    begin, apart = 0.0, 1.0 / 7.0
    ahead = eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    for _ in range(ROUNDS):
        q, t, met = between_eight(P, by, a, chord, begin + apart * ahead)
        angles = arm_angles(P, by.target.place, q)
        rates = short_ways(arm_angles(P, by.target.place, all_along(q, LITTLE, t)) - angles) / LITTLE
        heights = -rise * short_ways(angles - psi)
        slopes = -rise * rates * length2 / dot_seven(t, chord)
        best = -1
        for i in range(8):
            if (met >> i) & 1 == 1 and (best < 0 or one_of(heights, i) < one_of(heights, best)):
                best = i
        if best < 0:
            break
        other = best + 1 if one_of(slopes, best) < 0.0 else best - 1
        first, last = min(best, other), max(best, other)
        before = (begin + apart * first, one_of(heights, first), one_of(slopes, first))
        behind = (begin + apart * last, one_of(heights, last), one_of(slopes, last))
        inside = first >= 0 and last < 8
        if inside and (met >> first) & (met >> last) & 1 == 1 and before[2] < 0.0 < behind[2]:
            share, foretold = lowest_of_cubic(before, behind, 0.0)
            change, height = abs(foretold - height), foretold
            if change * LESS < TURNED and apart < 0.1:
                break
            apart *= CLOSER
        else:
            share, height = begin + apart * best, one_of(heights, best)
            if inside:
                # Next to a singularity, where Newton's method in step fails.
                share = 0.5 * (before[0] + behind[0])
                apart = apart / 7.0
            elif share < CLOSER * apart or share > 1.0 - CLOSER * apart:
                break
            else:
                # It is farther along the chord.
                apart = min(WIDER * apart, 1.0 / 7.0)
        begin = min(max(share - 3.5 * apart, 0.0), 1.0 - 7.0 * apart)
    return share, -rise * height
