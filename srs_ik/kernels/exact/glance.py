"""Eight arm angles at a glance: about how near the joints of shoulder and wrist are to their limits, eight in step.

This is to tell where to look closely: the free split of a singular joint is not told.
"""

import math

from srs_ik.kernels.algebra.lane_trig import angle_of
from srs_ik.kernels.algebra.lanes import eight_of, larger, one_of, where, whole_number
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import A1_A2, A2_A3, FIRST_JOINT, INVERSE_HALF_RANGE, MIDDLE, PHASE, SHOULDER, WRIST
from srs_ik.kernels.limb.spherical import columns_at, eight_middles, sines

TURN = 2.0 * math.pi

GLANCES = 16
"""Arm angles, evenly spaced, that are looked at on each side of the elbow."""

NEXT_GLANCE = TURN / GLANCES
"""From one of them to the next."""

NOWHERE = 1e3
"""Stands for the cost of what does not exist or is not wanted."""


@kernel
def joint_costs(P, joint, q):
    """Minus the margins of a joint at eight angles, in the turn nearest to the middle of its range."""
    off = q - P[MIDDLE + joint]
    return abs(off - TURN * whole_number(off / TURN)) * P[INVERSE_HALF_RANGE + joint] - 1.0


@kernel
def costs_of(P, first, q):
    """Minus the margins of three joints together."""
    both = larger(joint_costs(P, first, q[0]), joint_costs(P, first + 1, q[1]))
    return larger(both, joint_costs(P, first + 2, q[2]))


@kernel
def eight_angles(P, k, v, y, c, s):
    """Eight of `spherical.angles`, about."""
    q1, q2, q3, _ = sines(P, k, v, y, c, s)
    return angle_of(q1[0], q1[1]), angle_of(q2[0], q2[1]), angle_of(q3[0], q3[1])


@kernel
def eight_halves(P, k, motion, c, s):
    """Costs of both solutions of a spherical joint at eight arm angles, given by cosines and sines."""
    v, y = columns_at(motion, c, s)
    first = int(P[k + FIRST_JOINT])
    c_middle, s_middle, missed = eight_middles(P, k, v)
    above = eight_angles(P, k, v, y, c_middle, s_middle)
    if P[k + A1_A2] == 0.0 and P[k + A2_A3] == 0.0:
        below = (above[0] + math.pi, 2.0 * P[k + PHASE] - above[1], above[2] + math.pi)
    else:
        below = eight_angles(P, k, v, y, c_middle, -s_middle)
    return where(missed, NOWHERE, costs_of(P, first, above)), where(missed, NOWHERE, costs_of(P, first, below))


@kernel
def wanted_half(halves, wanted):
    """The better of both solutions, or the wanted one (0 or 1), at eight arm angles."""
    if wanted == 0:
        return halves[0]
    if wanted == 1:
        return halves[1]
    return where(halves[1] < halves[0], halves[1], halves[0])


@kernel
def eight_costs(P, side, c, s, signs):
    """About the costs of shoulder and wrist together at eight arm angles, of the wanted solutions (-1: any)."""
    shoulder = wanted_half(eight_halves(P, SHOULDER, side[1], c, s), signs[0])
    wrist = wanted_half(eight_halves(P, WRIST, side[2], c, s), signs[1])
    return larger(shoulder, wrist)


@kernel
def eight_turns():
    """Cosines and sines of the first half of the arm angles that are looked at."""
    a, b, d = math.cos(NEXT_GLANCE), math.sin(NEXT_GLANCE), math.sqrt(0.5)
    return eight_of(1.0, a, d, b, 0.0, -b, -d, -a), eight_of(0.0, b, d, a, 1.0, a, d, b)


@kernel
def lowest_of(costs, first, known):
    """The lower of eight costs and a known one, with the number of its arm angle."""
    number, least = known
    for i in range(8):
        if one_of(costs, i) < least:
            number, least = first + i, one_of(costs, i)
    return number, least


@kernel
def glance(P, side, signs):
    """Where shoulder and wrist are farthest from their limits at a glance: the arm angle, and about what it costs.

    `signs` are the wanted solutions of shoulder and wrist (-1: any); `side` is `triangle.elbow_side`.
    """
    c, s = eight_turns()
    found = lowest_of(eight_costs(P, side, c, s, signs), 0, (0, 2.0 * NOWHERE))
    number, least = lowest_of(eight_costs(P, side, -c, -s, signs), 8, found)
    return NEXT_GLANCE * number, least
