"""Postures taken to poses, eight in step where eight in a row are for the same one."""

from __future__ import annotations

from srs_ik.kernels.algebra.eight import ALL
from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.lanes import as_bits
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.bridge import bridge_to
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.newton_eight import largest
from srs_ik.kernels.curves.in_step import to_curves
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, UPPER
from srs_ik.kernels.limb.poses import read_pose

STEPS_IN_STEP = 6
"""Steps of eight in step, at most: those that need more are led to their pose one by one ..."""

FARTHEST = 0.1
"""... as those that a joint of which would go farther, rad: next to a singularity, where steps have to be damped."""


@kernel
def of_one_pose(poses, first):
    """Whether eight poses from one on are the same."""
    for i in range(first + 1, first + 8):
        for r in range(3):
            for c in range(4):
                if poses[i, r, c] != poses[first, r, c]:
                    return False
    return True


@kernel
def is_inside(P, joint, angles):
    """Which of eight angles of a joint lie inside its limits, and not on them, as bits."""
    return as_bits((angles > P[LOWER + joint]) & (angles < P[UPPER + joint]))


@kernel
def inside_limits(P, q):
    """Which of eight postures lie inside all joint limits, as bits."""
    arm = is_inside(P, 0, q[0]) & is_inside(P, 1, q[1]) & is_inside(P, 2, q[2]) & is_inside(P, 3, q[3])
    return arm & is_inside(P, 4, q[4]) & is_inside(P, 5, q[5]) & is_inside(P, 6, q[6])


@kernel
def bridge_all(P, poses, starts, met, J, A):
    """Take postures (n, 7), in place, to poses (n, 4, 4) inside the limits; `met` (n,) says which meet theirs then."""
    count = starts.shape[0]
    i = 0
    while i < count:
        R, p, _ = read_pose(row(poses, i))
        together, there = 1, 0
        if i + 8 <= count and of_one_pose(poses, i):
            together = 8
            start = take_eight(row(starts, i), 7)
            q, _, there = to_curves(P, R, p, start, ALL, (STEPS_IN_STEP, 0.0))
            there &= inside_limits(P, q) & as_bits(largest(along7(q, -1.0, start)) < FARTHEST)
            put_eight(row(starts, i), 7, there, q)
        for k in range(together):
            met[i + k] = (there >> k) & 1 == 1 or bridge_to(P, R, p, row(starts, i + k), J, A)
        i += together
