"""Self-motion: how the joints move when the arm angle changes and the tip stands still."""

import math

from srs_ik.kernels.algebra.vectors import cross, dot, load3, rotate, scale
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import A1, A2, A3, SHOULDER, WRIST

SINGULAR_RATE = 1e-9
"""Below this triple product of the three axes of a spherical joint, its joint rates are not determined."""


@kernel
def turned_rates(P, k, turn1, turn2, w):
    """`spherical_rates` by cosines and sines of two joints, all times the triple product of the axes; and that."""
    a1 = load3(P, k + A1)
    c1, s1 = turn1
    a2 = rotate(a1, c1, s1, load3(P, k + A2))
    a3 = rotate(a1, c1, s1, rotate(load3(P, k + A2), turn2[0], turn2[1], load3(P, k + A3)))
    n1 = cross(a2, a3)
    return dot(w, n1), dot(w, cross(a3, a1)), dot(w, cross(a1, a2)), dot(a1, n1)


@kernel
def spherical_rates(P, k, q1, q2, w):
    """Rates of the three joints at block k that turn the outer side with angular velocity w, in the frame of axis 1."""
    turn1, turn2 = (math.cos(q1), math.sin(q1)), (math.cos(q2), math.sin(q2))
    r1, r2, r3, volume = turned_rates(P, k, turn1, turn2, w)
    if abs(volume) < SINGULAR_RATE:
        return 0.0, 0.0, 0.0, False
    return r1 / volume, r2 / volume, r3 / volume, True


@kernel
def rates(P, q, t, w):
    """Derivative of q by the arm angle on the exact limb: seven rates, and whether they are determined.

    The arm turns about the direction S-W: t in the base frame, w in the frame of axis 5 (the forearm at zero wrist
    angles). What the arm turns, the wrist turns back.
    """
    r1, r2, r3, good_s = spherical_rates(P, SHOULDER, q[0], q[1], t)
    r5, r6, r7, good_w = spherical_rates(P, WRIST, q[4], q[5], scale(-1.0, w))
    return (r1, r2, r3, 0.0, r5, r6, r7), good_s and good_w
