"""Entry points: poses that leave a turn free."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.freedom import read_freedom
from srs_ik.kernels.freedom.solve import solve_free
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.freedom import SYSTEM, TABLE, Desk
from srs_ik.kernels.pose.solve import own_goal


@entry
def solve_range(family, poses, first, last, freedom, turns, seeds, respect, work, starts, out, verdicts):
    """The poses first to last - 1, each with the same freedom.

    Args:
        family: (4, SIZE) packed limb.
        poses: (n, 4, 4).
        first: the first of them.
        last: one behind the last of them.
        freedom: (FREEDOM,) what they leave free.
        turns: (t, 9) rotations at which postures are looked for where the axis may lean, in the tip frame.
        seeds: (m, 7) one for all, one a pose, or none.
        respect: whether joint limits count.
        work: (WORK,) work space.
        starts: (MOST_STARTS, START) work space.
        out: (n, ROW) output.
        verdicts: (n,) verdicts on the poses.
    """
    equations = 49 + SYSTEM * SYSTEM
    solved = equations + SYSTEM * SYSTEM
    shares = solved + SYSTEM * SYSTEM
    desk = Desk(
        work[:49].reshape((7, 7)),
        work[49:equations].reshape((SYSTEM, SYSTEM)),
        work[equations:solved].reshape((SYSTEM, SYSTEM)),
        work[solved:shares].reshape((SYSTEM, SYSTEM)),
        row(work[shares:].reshape((1, TABLE)), 0),
        starts,
    )
    free = read_freedom(row(freedom, 0)), turns
    for i in range(first, last):
        verdicts[i] = solve_free(family, row(poses, i), free, own_goal(seeds, i, respect), desk, row(out, i))
