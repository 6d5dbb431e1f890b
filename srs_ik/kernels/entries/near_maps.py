"""Entry points of reachability and maps, for near limbs."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.maps import CELL_ARCS
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.maps.cells import clear
from srs_ik.kernels.maps.near_cells import Posed, near_room, reach_near, write_cell_near


@entry
def reachable_range(family, poses, first, last, out):
    """`maps.reachable_range` of a near limb."""
    space = near_room()
    for i in range(first, last):
        T = row(poses, i)
        R, p, verdict = read_pose(T)
        if verdict != GOOD_POSE:
            out[i] = -verdict
        else:
            out[i] = reach_near(family, Posed(T, place(row(family, LIMITED), R, p), R, p), space)


@entry
def measure_range(family, poses, first, last, limits, out):
    """`maps.measure_range` of a near limb, without margins."""
    space = near_room()
    most = (out.shape[1] - CELL_ARCS) // 2
    for i in range(first, last):
        T = row(poses, i)
        R, p, verdict = read_pose(T)
        if verdict == GOOD_POSE:
            pose = Posed(T, place(row(family, LIMITED), R, p), R, p)
            write_cell_near(family, pose, (limits[0], limits[1]), most, space, row(out, i))
        else:
            clear(most, row(out, i))
