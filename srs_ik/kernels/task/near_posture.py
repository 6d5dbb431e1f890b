"""The posture of a task on the true chain of a near limb.

A near limb has no lengths of its own: as its axes pass their centres at a distance, S-E and E-W change by millimetres
with the configuration. Its posture is a triangle with the lengths that the true chain has in that very posture. So the
triangle is laid, the chain closed on it and measured, and the triangle laid anew, until the lengths no longer change.
"""

from srs_ik.kernels.algebra.vectors import load3, norm, sub, times_transposed
from srs_ik.kernels.chain.newton import STEPS, close_at_angle, elbow_position
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import SHOULDER_CENTRE
from srs_ik.kernels.layout.task import HAND_LENGTH, TASK_POSITION
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import cost, turned
from srs_ik.kernels.limb.triangle import shoulder_to_wrist, target_frame
from srs_ik.kernels.task.posture import plan, planned_arm_angle, tip_axes

PASSES = 30
"""So often a triangle is laid at most; each pass leaves a few hundredths of the change of the one before."""

SETTLED = 1e-14
"""A hand that turns by less than this, rad, no longer changes the lengths."""


@kernel
def true_lengths(P, H, q, to_wrist, grasped):
    """Lengths of the true chain, as in `posture.lengths_of`."""
    to_elbow = sub(elbow_position(P, q), load3(P, SHOULDER_CENTRE))
    upper = norm(to_elbow)
    forearm = norm(sub(to_wrist, to_elbow))
    lower = forearm if grasped else forearm + H[HAND_LENGTH]
    return upper, forearm, abs(upper - lower), upper + lower


@kernel
def settle_posture(P, H, x, grasped, phi, side, tie, found, hand_axes, q, seeded, seed, respect, A):
    """Bring a posture and joint angles q near it to agree on the true chain, the roll of the hand fixed by phi.

    `x` is the task row, `found` the posture of the nearest exact limb, from `posture.plan`, `hand_axes` those of the
    hand in the tip frame; side and tie are 1.0 or -1.0. Where there is a seed, its turns are wanted. Returns the
    posture, the rotation of the tip, the joint angles, and their cost: NO_BRANCH where they do not agree.
    """
    p = load3(x, TASK_POSITION)
    R = times_transposed(tip_axes(found[5], phi), hand_axes)
    for _ in range(PASSES):
        to_wrist = shoulder_to_wrist(P, R, p)
        _, t, h0 = target_frame(P, to_wrist)
        psi = planned_arm_angle(t, h0, found[3])
        q, closed = close_at_angle(P, q, R, p, t, h0, psi, STEPS, A)
        if not closed:
            break
        direction = found[5]
        found = plan(P, H, x, grasped, phi, True, side, tie, true_lengths(P, H, q, to_wrist, grasped))
        if norm(sub(found[5], direction)) < SETTLED:
            q = turned(P, q, seeded, seed, respect)
            return found, R, q, cost(P, q, seeded, seed, respect)
        R = times_transposed(tip_axes(found[5], phi), hand_axes)
    return found, R, q, NO_BRANCH
