"""Targets that leave a turn free: which rotations they allow, and which one they are taken for."""

import math

from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import angle_between, apply, load3, load_pose, norm, rotate, rotation, sub, times
from srs_ik.kernels.chain.freedom import allowed, any_across, as_rotation, free_error, read_freedom, turn_left
from srs_ik.kernels.chain.kinematics import forward_kinematics, pose_error
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import FREE_CONE, Freedom
from srs_ik.kernels.layout.limb import FAR, MISS, NEAR, SHOULDER_CENTRE, WRIST_IN_TIP
from srs_ik.kernels.layout.track import FREE, GOAL, HAS_FREE, ROTATION, STARTED
from srs_ik.kernels.limb.triangle import shoulder_to_wrist

ROLLS, LEANS = 32.0, 96.0
"""So many turns stand for all that are allowed: with the roll alone free, and in a cone."""

SPREAD = (0.8191725, 0.6710436, 0.5497005)
"""Their multiples, without the whole numbers, fill a cube evenly: 1/g, 1/g^2 and 1/g^3, with g^4 = g + 1."""

TURN = 2.0 * math.pi


@kernel
def columns(R):
    """The directions of a frame."""
    return (R[0], R[3], R[6]), (R[1], R[4], R[7]), (R[2], R[5], R[8])


@kernel
def whole_rotation(P, C, q, R):
    """The rotation that a target allows and that is nearest to the tip's, for what knows of no freedom.

    It lies on the edge of a cone. `error_at` takes the target itself: there the cone counts, and nowhere else.
    """
    if C[HAS_FREE] == 0.0:
        return R
    x, y, z, _ = forward_kinematics(P, q)
    return allowed(read_freedom(row(C, FREE)), (x, y, z), R)


@kernel
def free_way(C, T, R):
    """The shortest turn from a rotation of the tip, T, to what a target allows: unit axis, angle."""
    axis, angle, _ = turn_left(read_freedom(row(C, FREE)), columns(T), R)
    return axis, angle


@kernel
def wanted(P, S, C, R):
    """The rotation of a new target without the roll that it leaves free: that nearest to the target before."""
    if C[HAS_FREE] == 0.0:
        return R
    freedom = read_freedom(row(C, FREE))
    before, _ = load_pose(S, ROTATION)
    frame = columns(before)
    if S[STARTED] == 0.0:
        x, y, z, _ = forward_kinematics(P, read7(row(S, GOAL)))
        frame = (x, y, z)
    if freedom.cone >= math.pi:
        return as_rotation(frame)
    return allowed(Freedom(freedom.axis, 0.0), frame, R)


@kernel
def error_left(P, C, q, R, p):
    """Distance (m) and angle (rad) between the tip and a target, but for what that leaves free."""
    if C[HAS_FREE] == 0.0:
        return pose_error(P, q, R, p)
    return free_error(P, q, R, p, read_freedom(row(C, FREE)))


@kernel
def fraction(x):
    """The part of a positive number behind its point."""
    return x - math.floor(x)


@kernel
def allowed_turn(P, C, q, R, k):
    """One after the other of the rotations that a target allows, all over; first that nearest to the tip's at q."""
    if C[HAS_FREE] == 0.0 or k == 0.0:
        return whole_rotation(P, C, q, R)
    freedom = read_freedom(row(C, FREE))
    roll, side = TURN * fraction(k * SPREAD[0]), TURN * fraction(k * SPREAD[1])
    height = fraction(k * SPREAD[2]) * (1.0 - math.cos(freedom.cone))
    c, s = 1.0 - height, math.sqrt(height * (2.0 - height))
    across_axis = rotate(freedom.axis, math.cos(side), math.sin(side), any_across(freedom.axis))
    rolled = rotation(freedom.axis, math.cos(roll), math.sin(roll))
    return times(R, times(rotation(across_axis, c, s), rolled))


@kernel
def turns_to_look_at(C):
    """How many of them stand for all."""
    if C[HAS_FREE] == 0.0:
        return 1.0
    return ROLLS if C[FREE + FREE_CONE] == 0.0 else LEANS


@kernel
def wrist_distances(P, C, pose):
    """Least and largest distance of the wrist from the shoulder, over all turns that a target allows.

    The wrist lies in a ring around the axis, on a sphere around the tip.
    """
    R, p = pose
    if C[HAS_FREE] == 0.0:
        d = norm(shoulder_to_wrist(P, R, p))
        return d, d
    freedom = read_freedom(row(C, FREE))
    from_tip, to_tip = load3(P, WRIST_IN_TIP), sub(p, load3(P, SHOULDER_CENTRE))
    a, b = norm(from_tip), norm(to_tip)
    leaning = angle_between(from_tip, freedom.axis)
    inner, outer = max(leaning - freedom.cone, 0.0), min(leaning + freedom.cone, math.pi)
    along_tip = angle_between(to_tip, apply(R, freedom.axis))
    against_tip = math.pi - along_tip
    least = max(along_tip - outer, inner - along_tip, 0.0)
    most = math.pi - max(against_tip - outer, inner - against_tip, 0.0)
    near = max(a * a + b * b + 2.0 * a * b * math.cos(most), 0.0)
    far = max(a * a + b * b + 2.0 * a * b * math.cos(least), 0.0)
    return math.sqrt(near), math.sqrt(far)


@kernel
def out_of_reach(P, C, pose):
    """Whether at all turns the wrist is farther from the shoulder than the arm is long, or too close."""
    near, far = wrist_distances(P, C, pose)
    slack = 8.0 * P[MISS] + 1e-9 * P[FAR]
    return near > P[FAR] + slack or far < P[NEAR] - slack
