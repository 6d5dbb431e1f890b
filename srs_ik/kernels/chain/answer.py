"""Answers: a posture, measured on the true chain, with the status that follows, written as a row."""

import math

from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import answer as at
from srs_ik.kernels.layout.limb import IS_CLOSED
from srs_ik.kernels.limb.branches import NO_BRANCH, branch_of, is_on_border
from srs_ik.kernels.limb.goal import OUTSIDE, tightest_joint


@kernel
def write_row(place_, q, branch, psi, errors, forbidden, out):
    """Write a posture with its measured errors (m, rad), and the status that follows from them.

    `forbidden` says whether the limits forbid a posture that exists, and the joint that stands out (0: none).
    """
    position, orientation = errors
    outside, joint = forbidden
    for i in range(7):
        out[at.ROW_Q + i] = q[i]
    out[at.ROW_POSITION_ERROR] = position
    out[at.ROW_ORIENTATION_ERROR] = orientation
    out[at.ROW_ARM_ANGLE] = psi - 2.0 * math.pi * math.floor((psi + math.pi) / (2.0 * math.pi))
    out[at.ROW_BRANCH] = branch
    out[at.ROW_JOINT] = joint
    if max(position, orientation) < at.SOLVED:
        out[at.ROW_STATUS] = at.OK
    elif outside and place_[5] == 0.0:
        out[at.ROW_STATUS] = at.OUT_OF_LIMITS
    else:
        out[at.ROW_STATUS] = at.UNREACHABLE


@kernel
def measure_row(P, target, q, branch, lowest, respect, out):
    """Measure a posture on the true chain and write its row; outside its limits, it is put on them first."""
    measure_row_at(P, target, None, (q, branch, lowest), respect, out)


@kernel
def measure_row_at(P, target, psi, found, respect, out):
    """The same for a posture that has the arm angle psi where it meets its pose (None: not known).

    `found` holds the posture, its branch and its cost.
    """
    R, p, place_ = target
    q, branch, lowest = found
    outside = respect and lowest >= OUTSIDE
    joint = 0
    if outside:
        joint = tightest_joint(P, q)
        q = clipped(P, q)
    position, orientation = pose_error(P, q, R, p)
    if P[IS_CLOSED] != 1.0 and not is_on_border(P, q, branch):
        branch = branch_of(P, q)
    if psi is None:
        angle = arm_angle(P, q, place_[0], place_[1])
    else:
        solved = max(position, orientation) < at.SOLVED
        angle = psi if solved else arm_angle(P, q, place_[0], place_[1])
    write_row(place_, q, branch, angle, (position, orientation), (outside and lowest < NO_BRANCH, joint), out)
