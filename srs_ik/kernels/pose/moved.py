"""Postures of eight poses moved along their curves on the true chain, in step."""

from srs_ik.kernels.algebra.joint_vectors import along7, dot7
from srs_ik.kernels.algebra.lane_trig import turns_of
from srs_ik.kernels.algebra.lanes import as_bits, gather, where
from srs_ik.kernels.algebra.vectors import store_pose
from srs_ik.kernels.chain.newton_eight import curve_step, largest
from srs_ik.kernels.curves.in_step import between_eight, on_way
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Setting, Target
from srs_ik.kernels.layout.limb import LOWER, UPPER
from srs_ik.kernels.layout.path import TIP
from srs_ik.kernels.limb.poses import read_pose


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
