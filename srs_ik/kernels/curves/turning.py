"""Where the arm angle turns around between two postures of a curve."""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.curves.follow import between, null_vector, tangent_at
from srs_ik.kernels.curves.told import LITTLE, angle_at
from srs_ik.kernels.jit import kernel

TURNING_STEPS = 16
TURNED = 1e-12
"""Looks at most, and how well an arm angle that was foretold is met by the last, rad."""


@kernel
def height_of(P, by, q, t, chord, zero):
    """How far the arm angle of a posture is below one, and how that changes along a chord.

    Args:
        P: packed limb.
        by: how curves are followed.
        q: the posture.
        t: the unit vector along the curve there, either way.
        chord: the chord.
        zero: the arm angle, and the sign with which it is approached from below.
    """
    psi, rise = zero
    angle = angle_at(P, by, q)
    rate = short_way(angle_at(P, by, along7(q, LITTLE, t)) - angle) / LITTLE
    return -rise * short_way(angle - psi), -rise * rate * dot7(chord, chord) / dot7(t, chord)


@kernel
def turning_between(P, by, a, b, rise):
    """The posture at which the arm angle, from one posture of a curve to another close by, is farthest to one side.

    The curve goes through the zero of the arm angle's rate, which cubics between two postures foretell. `rise` is the
    sign of the side.
    """
    chord = difference(a, b)
    zero = angle_at(P, by, a), rise
    t, _ = tangent_at(P, by, a)
    at, rate = height_of(P, by, a, t, chord, zero)
    first = (0.0, at, rate)
    t, _ = tangent_at(P, by, b)
    at, rate = height_of(P, by, b, t, chord, zero)
    last = (1.0, at, rate)
    best, lowest = (a, first[1]) if first[1] < last[1] else (b, last[1])
    for _ in range(TURNING_STEPS):
        told = first[2] < 0.0 < last[2]
        share, foretold = lowest_of_cubic(first, last, 0.0) if told else (0.5 * (first[0] + last[0]), 0.0)
        q, met = between(P, by, a, b, share)
        if not met:
            break
        t, _ = null_vector(by.J, chord, by.A)
        at, rate = height_of(P, by, q, t, chord, zero)
        if at < lowest:
            best, lowest = q, at
        if told and abs(at - foretold) < TURNED:
            break
        if rate < 0.0:
            first = (share, at, rate)
        else:
            last = (share, at, rate)
    return best
