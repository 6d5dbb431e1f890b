"""Of postures whose largest violation is the same, the one that comes closest on the limits, or is nearest to a seed.

They are common: that of joint 2 is the same for both shoulders, whose joints 1 and 3 stand half a turn apart, and
a joint that stands opposite to the middle of its range may be put on either limit. That of joint 4 is the same at all
arm angles.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, dot7, with_joint
from srs_ik.kernels.chain.closest import surroundings
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.exact.farthest import GAIN_OUTSIDE
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_NEAR, MIDDLE
from srs_ik.kernels.limb.branches import best_branch
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, UNMET, turned
from srs_ik.kernels.limb.limits import TURN, violation

AROUND = 12
"""Arm angles all around at which postures are looked at whose joint 4 is as far out at all of them."""

CLOSER = 1e-9
"""Postures that are closer by less of the measure of `chain.closest`, which has no unit, are equal."""


@kernel
def off_on_limits(P, q, target, goal, J):
    """How far a posture on its limits is from its pose, by the measure of `chain.closest`, or squared from a seed."""
    if goal.seeded:
        away = along7(clipped(P, q), -1.0, goal.seed)
        return dot7(away, away)
    _, _, value = surroundings(P, clipped(P, q), target, 1.0, J)
    return value


@kernel
def closest_turns(P, q, target, goal, worst, J):
    """A posture with the joints outside their limits in the closest turns of those that violate no more than `worst`.

    Also how far it is off.
    """
    least = off_on_limits(P, q, target, goal, J)
    for j in range(7):
        other = with_joint(q, j, q[j] - math.copysign(TURN, q[j] - P[MIDDLE + j]))
        if violation(P, j, q[j]) > 0.0 and violation(P, j, other[j]) <= worst:
            value = off_on_limits(P, other, target, goal, J)
            if value < least - CLOSER:
                q, least = other, value
    return q, least


@kernel
def may_have_equals(P, target, branch, lowest, goal):
    """Whether the least violating posture of a pose, of that cost, is one of several."""
    outside = goal.respect and OUTSIDE <= lowest < UNMET
    return P[IS_NEAR] == 0.0 and branch < 0 and outside and target.place[5] == 0.0


@kernel
def closest_of_equals(P, target, found, goal, anywhere, J):
    """The least violating posture of an exact limb, or one as good at its arm angle that comes closer: q, branch, cost.

    Closer once it is put on the limits, to the pose, or to a seed. One at others, if the arm angle may be any
    (`anywhere`) and joint 4 decides.
    """
    place_, least = target.place, math.inf
    most = found[2] + GAIN_OUTSIDE
    psi = arm_angle(P, found[0], place_[0], place_[1])
    around = AROUND if anywhere and violation(P, 3, found[0][3]) + GAIN_OUTSIDE > found[2] - OUTSIDE else 1
    for i in range(1 + 8 * around):
        q, branch, value = found
        if i > 0:
            branch = (i - 1) % 8
            at = psi + (i - 1) // 8 * (TURN / AROUND)
            q, _, value = best_branch(P, place_, at, branch, False, NO_SEED, True)
            q = turned(P, q, goal.seeded, goal.seed, True)
        if value <= most:
            q, off = closest_turns(P, q, target, goal, most - OUTSIDE, J)
            if off < least - CLOSER:
                found, least = (q, branch, value), off
    return found
