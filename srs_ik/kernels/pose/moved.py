"""Postures taken to poses next to theirs: moved along the curves of eight in step, or bridged where strips miss some.

Where joints lie on several limits at once, or an elbow is straight, a pose may have a single posture, or an interval
that rounding takes away. Whoever comes from a posture next to it finds it, by damped steps inside the limits. Where
eight postures in a row are for one pose, eight are taken there in step first, by Newton's method.
"""

from srs_ik.kernels.algebra.joint_vectors import along7, dot7, store7
from srs_ik.kernels.algebra.lane_trig import turns_of
from srs_ik.kernels.algebra.lanes import ALL, as_bits, gather, where
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import store_pose
from srs_ik.kernels.chain.eight import put_eight, take_eight
from srs_ik.kernels.chain.newton import LEFT, clipped, close_gently
from srs_ik.kernels.chain.newton_eight import curve_step, largest
from srs_ik.kernels.curves.in_step import between_eight, on_way, to_curves
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Setting, Target
from srs_ik.kernels.layout.limb import LOWER, UPPER
from srs_ik.kernels.layout.path import TIP
from srs_ik.kernels.limb.poses import read_pose

STEPS_IN_STEP = 6
"""Steps of eight in step, at most: those that need more are led to their pose one by one ..."""

FARTHEST = 0.1
"""... as those that a joint of which would go farther, rad: next to a singularity, where steps have to be damped."""


@kernel
def write_tip(T, out):
    """Write the rotation and position of a pose (TIP,)."""
    R, p, _ = read_pose(T)
    store_pose(out, 0, R, p)


@kernel
def gather3(rows, k, width):
    """Three figures from column k on, of eight rows."""
    return gather(rows, k, width), gather(rows, k + 1, width), gather(rows, k + 2, width)


@kernel
def eight_poses(tips):
    """Rotations and positions of eight poses."""
    return gather3(tips, 0, TIP) + gather3(tips, 3, TIP) + gather3(tips, 6, TIP), gather3(tips, 9, TIP)


@kernel
def ways_of_eight(P, tips, q):
    """The unit vectors along the curves of eight poses at a posture of each, and as bits where there are any."""
    R, p = eight_poses(tips)
    _, t, _, _ = curve_step(P, turns_of(q), R, p, q, 0.0 * q[0])
    return t, as_bits(abs(dot7(t, t) - 1.0) < 0.5)


@kernel
def moved_eight(P, poses, q, moves):
    """Postures moved some ways along directions of the curves of their poses, and as bits, which meet their poses.

    `poses` are eight rotations and positions, or one, with a posture each; `moves` directions, and how far along them.
    """
    by = Setting(Target(poses[0], poses[1], 0.0), 0.0, True, 0.0, 0.0)
    there, _, met = between_eight(P, by, on_way(q, moves[0], moves[1]), moves[0])
    return there, met


@kernel
def joint_within(P, joint, x):
    """Eight angles of a joint, those beyond a limit put on it."""
    low, high = 0.0 * x + P[LOWER + joint], 0.0 * x + P[UPPER + joint]
    return where(x < low, low, where(x > high, high, x))


@kernel
def within(P, q, slack):
    """Eight postures, joints beyond a limit put on it, and as bits, which are beyond by rounding alone, `slack` rad."""
    inside = (
        joint_within(P, 0, q[0]),
        joint_within(P, 1, q[1]),
        joint_within(P, 2, q[2]),
        joint_within(P, 3, q[3]),
        joint_within(P, 4, q[4]),
        joint_within(P, 5, q[5]),
        joint_within(P, 6, q[6]),
    )
    return inside, as_bits(largest(along7(inside, -1.0, q)) < slack)


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
            eight, _, there = to_curves(P, R, p, start, ALL, (STEPS_IN_STEP, 0.0))
            there &= inside_limits(P, eight) & as_bits(largest(along7(eight, -1.0, start)) < FARTHEST)
            put_eight(row(starts, i), 7, there, eight)
        for k in range(together):
            met[i + k] = (there >> k) & 1 == 1
            if not met[i + k]:
                q, error = close_gently(P, clipped(P, read7(row(starts, i + k))), R, p, True, J, A)
                store7(row(starts, i + k), 0, q)
                met[i + k] = error < LEFT
        i += together
