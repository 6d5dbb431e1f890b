"""Poses and postures as they come in: checked, and brought to tuples."""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import FARTHEST, GOOD_POSE, NOT_A_ROTATION, NOT_FINITE, NOT_RIGID, TOO_FAR


@kernel
def read_pose(T):
    """Rotation, position and verdict of the 16 figures of a pose; rounding in the rotation is removed."""
    R = (T[0], T[1], T[2], T[4], T[5], T[6], T[8], T[9], T[10])
    p = (T[3], T[7], T[11])
    total = 0.0 * p[0] + 0.0 * p[1] + 0.0 * p[2]
    for i in range(9):
        total += R[i]
    total += T[12] + T[13] + T[14] + T[15]
    if not math.isfinite(total):
        return R, p, NOT_FINITE
    if max(abs(p[0]), abs(p[1]), abs(p[2])) > FARTHEST:
        return R, p, TOO_FAR
    if max(abs(T[12]), abs(T[13]), abs(T[14]), abs(T[15] - 1.0)) > NOT_A_ROTATION:
        return R, p, NOT_RIGID
    for _ in range(2):
        xx = R[0] * R[0] + R[3] * R[3] + R[6] * R[6] - 1.0
        yy = R[1] * R[1] + R[4] * R[4] + R[7] * R[7] - 1.0
        zz = R[2] * R[2] + R[5] * R[5] + R[8] * R[8] - 1.0
        xy = R[0] * R[1] + R[3] * R[4] + R[6] * R[7]
        yz = R[1] * R[2] + R[4] * R[5] + R[7] * R[8]
        zx = R[2] * R[0] + R[5] * R[3] + R[8] * R[6]
        off = max(abs(xx), abs(yy), abs(zz), abs(xy), abs(yz), abs(zx))
        if off > NOT_A_ROTATION:
            return R, p, NOT_RIGID
        if off < 1e-15:
            break
        # R (3 I - R'R) / 2: the nearest rotation, to second order.
        R = (
            R[0] - 0.5 * (R[0] * xx + R[1] * xy + R[2] * zx),
            R[1] - 0.5 * (R[0] * xy + R[1] * yy + R[2] * yz),
            R[2] - 0.5 * (R[0] * zx + R[1] * yz + R[2] * zz),
            R[3] - 0.5 * (R[3] * xx + R[4] * xy + R[5] * zx),
            R[4] - 0.5 * (R[3] * xy + R[4] * yy + R[5] * yz),
            R[5] - 0.5 * (R[3] * zx + R[4] * yz + R[5] * zz),
            R[6] - 0.5 * (R[6] * xx + R[7] * xy + R[8] * zx),
            R[7] - 0.5 * (R[6] * xy + R[7] * yy + R[8] * yz),
            R[8] - 0.5 * (R[6] * zx + R[7] * yz + R[8] * zz),
        )
        if off < 1e-8:
            break
    determinant = (
        R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6])
    )
    return R, p, (GOOD_POSE if determinant > 0.0 else NOT_RIGID)


@kernel
def is_same_pose(T, other):
    """Whether the 16 figures of two poses are equal."""
    same = True
    for i in range(16):
        same = same and T[i] == other[i]
    return same
