"""Entry points of reachability and maps."""

from srs_ik.kernels.algebra.pointers import row, scratch
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.layout.maps import CELL_ARCS
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.maps.cells import margin_of_poses, measure_poses, write_cell
from srs_ik.kernels.maps.near_cells import measure_near_poses, near_room, reach_near_poses
from srs_ik.kernels.maps.reach import reach_poses, room


@entry
def reachable_range(family, poses, first, last, out):
    """Write whether the poses first to last - 1 of (N, 4, 4) are reached into out (N,), as in `layout.maps`."""
    if row(family, LIMITED)[IS_NEAR] == 0.0:
        reach_poses(family, poses, first, last, out)
    else:
        reach_near_poses(family, poses, first, last, scratch(6, 7), scratch(16, 9), out)


@entry
def margin_range(family, poses, first, last, out):
    """Write the largest margin to the limits of poses first to last - 1 of (N, 4, 4) into out (N,); exact limbs."""
    margin_of_poses(family, poses, first, last, out)


@entry
def measure_range(family, poses, first, last, limits, margin, out):
    """Write what a map tells of the poses first to last - 1 of (N, 4, 4) into the rows of out (N, CELL_ARCS + 2 n).

    For arcs of yaw the family has joint 1 free, within limits (2,), rad; the columns of out say how many there is room
    for. The margin is wanted or not, 1 or 0; near limbs have none here.
    """
    most = (out.shape[1] - CELL_ARCS) // 2
    if row(family, LIMITED)[IS_NEAR] == 0.0:
        measure_poses(family, poses, first, last, (limits[0], limits[1]), (most, margin == 1), out)
    else:
        space = near_room(family, scratch(6, 7), scratch(16, 9))
        measure_near_poses(family, poses, first, last, (limits[0], limits[1]), most, space, out)


@entry
def measure_cells(family, points, rotations, limits, margin, out):
    """`measure_range` of an exact limb at every point (n, 3) with every rotation (m, 9), into out (n m, ...)."""
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
