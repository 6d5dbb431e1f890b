"""The axis of joint 7 free: the posture nearest to a seed at poses where searches over arm angles are not enough.

That joint makes the roll alone, so the others are nearest over arm angle and branch, at the roll that leaves joint 7
where the seed has it. With this roll held a pose has nothing free, and its nearest posture of all is known: also next
to singular joints, along whose free splits no grid of arm angles comes, and where the elbow of a near limb passes its
limit to and fro. From each such posture the roll follows.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import with_joint
from srs_ik.kernels.chain.freedom import allowed
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.exact.nearest import HARDLY, between_limbs
from srs_ik.kernels.freedom.settle import settle
from srs_ik.kernels.freedom.starts import NONE_LEFT
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.layout.freedom import Found, Freedom
from srs_ik.kernels.layout.limb import FAR, IS_CLOSED, MISS, STRAIGHT
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.in_line import may_line_up
from srs_ik.kernels.limb.limits import beyond, turn_to_middle
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.pose.solve import best_posture

ALMOST_SINGULAR = 1e-3
"""Where outer axes come so close to one line, by the cosines of their angles, or elbows are bent by less, rad, a grid
of arm angles may pass over what is nearest."""

SLACK = 2.0
"""An elbow of a limb with rounded figures passes its limit to and fro where its nearest exact limb's is this close to
it, by what the two differ in."""

ROUNDS, GAIN = 4, 1e-6
"""Times that the roll follows joint 7, and the least that this is worth, squared rad."""


@kernel
def hides_postures(P, pose):
    """Whether searches from a grid of arm angles may pass over postures of a pose."""
    place_ = place(P, pose[0], pose[1])
    one, other = elbow_side(P, place_, 0)[0], elbow_side(P, place_, 1)[0]
    if abs(math.sin(one - P[STRAIGHT])) < ALMOST_SINGULAR or may_line_up(P, place_, ALMOST_SINGULAR):
        return True
    rounded = P[IS_CLOSED] != 1.0 and P[MISS] < HARDLY * P[FAR]
    width = SLACK * between_limbs(P)
    off, other_off = beyond(P, 3, turn_to_middle(P, 3, one)), beyond(P, 3, turn_to_middle(P, 3, other))
    return rounded and min(abs(off), abs(other_off)) < width


@kernel
def with_roll_held(family, P, pose, freedom, goal, liking, desk):
    """The nearest posture at rolls that leave joint 7 where the seed has it, and around it."""
    roll = Freedom(freedom.axis, 0.0)
    best = Found(liking.posture, NONE_LEFT, False)
    J, A = np.empty((6, 7)), np.empty((16, 9))
    seventh = min(max(liking.posture[6], liking.lower[6]), liking.upper[6])
    for _ in range(ROUNDS):
        x, y, z, _ = forward_kinematics(P, with_joint(best.q, 6, seventh))
        R = allowed(roll, (x, y, z), pose[0])
        q, _, value = best_posture(family, Target(R, pose[1], place(P, R, pose[1])), -1, goal, J, A)
        there, cost, error, _ = settle(P, q, pose, roll, liking, desk)
        if error < SOLVED and cost < value:
            q, value = there, cost
        gained = best.cost - value
        if value < OUTSIDE and gained > 0.0:
            best = Found(q, value, True)
        if value >= OUTSIDE or gained < GAIN:
            break
    return best
