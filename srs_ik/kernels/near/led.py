"""The next posture along a curve of a near limb: Newton's method leads to it from the one before.

Where a posture at an arm angle is asked for alone, close to a singularity, all curves of its pose are followed to tell
which postures there are. Along one curve, the posture before tells which one is meant.
"""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import difference, dot7
from srs_ik.kernels.chain.answer import measure_row_at
from srs_ik.kernels.chain.newton import STEPS, close_at_angle
from srs_ik.kernels.curves.lowest import cost_of_turn
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import OK, ROW_STATUS
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import OUTSIDE

NEXT = 1.0
"""The next posture is no farther than this from the one before, rad squared."""


@kernel
def led_to(P, target, psi, branch, before, A):
    """The posture of a branch at an arm angle to which one close by leads, and whether it does."""
    u, v = target.place[0], target.place[1]
    q, closed = close_at_angle(P, before, target.R, target.p, u, v, psi, STEPS, A)
    moved = difference(before, q)
    return q, closed and dot7(moved, moved) < NEXT and branch_of(P, q) == branch


@kernel
def lead_row(P, target, at, before, goal, A, out):
    """Write the row of that posture at an arm angle of a branch, in the turns of a goal; whether it is a solution."""
    psi, branch = at
    q, met = led_to(P, target, psi, branch, before, A)
    if not met:
        return False
    q, cost = cost_of_turn(P, q, goal)
    if cost >= OUTSIDE:
        return False
    measure_row_at(P, target, psi, (q, branch, cost), goal.respect, out)
    return out[ROW_STATUS] == OK
