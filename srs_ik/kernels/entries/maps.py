"""Entry points of reachability and maps, for limbs that the closed form answers."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.maps import CELL_ARCS
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.maps.cells import clear, write_cell
from srs_ik.kernels.maps.reach import reach, room


@entry
def reachable_range(family, poses, first, last, out):
    """Write whether the poses first to last - 1 of (N, 4, 4) are reached into out (N,), as in `layout.maps`."""
    space = room(family)
    for i in range(first, last):
        R, p, verdict = read_pose(row(poses, i))
        if verdict != GOOD_POSE:
            out[i] = -verdict
        else:
            out[i] = reach(family, place(row(family, LIMITED), R, p), space)


@entry
def measure_range(family, poses, first, last, limits, margin, out):
    """Write what a map tells of the poses first to last - 1 of (N, 4, 4) into the rows of out (N, CELL_ARCS + 2 n).

    Args:
        family: packed limbs; for arcs of yaw, with joint 1 free.
        poses: (N, 4, 4) rigid transforms.
        first: first pose.
        last: one behind the last.
        limits: (2,) of joint 1, rad, for arcs of yaw; the columns of out say how many there is room for.
        margin: whether the margin is wanted, 0 or 1.
        out: output.
    """
    space = room(family)
    asked = ((out.shape[1] - CELL_ARCS) // 2, margin == 1)
    for i in range(first, last):
        R, p, verdict = read_pose(row(poses, i))
        if verdict == GOOD_POSE:
            place_ = place(row(family, LIMITED), R, p)
            write_cell(family, place_, (limits[0], limits[1]), asked, space, row(out, i))
        else:
            clear(asked[0], row(out, i))


@entry
def measure_cells(family, points, rotations, limits, margin, out):
    """`measure_range` of every point (n, 3) with every rotation (m, 9) of the tip, into out (n m, ...)."""
    space = room(family)
    asked = ((out.shape[1] - CELL_ARCS) // 2, margin == 1)
    m = rotations.shape[0]
    for i in range(points.shape[0]):
        p = (points[i, 0], points[i, 1], points[i, 2])
        for j in range(m):
            r = row(rotations, j)
            R = (r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8])
            place_ = place(row(family, LIMITED), R, p)
            write_cell(family, place_, (limits[0], limits[1]), asked, space, row(out, i * m + j))
