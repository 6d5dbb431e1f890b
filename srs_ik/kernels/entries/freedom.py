"""Entry points: poses that leave a turn free."""

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.freedom import read_freedom
from srs_ik.kernels.freedom.solve import solve_free
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.freedom import SYSTEM, TABLE, Desk
from srs_ik.kernels.pose.solve import own_goal


@entry
def solve_range(family, poses, first, last, freedom, turns, few, seeds, respect, work, starts, out, verdicts):
    """The poses first to last - 1 of (n, 4, 4), each with the same freedom (FREEDOM,), into rows of out (n, ROW).

    Where the axis may lean, postures are looked for at turns (t, 9), rotations in the tip frame: at the first few, and
    at the others where few of these reach. Seeds (m, 7) hold one for all, one a pose, or none; `work` (WORK,) and
    `starts` (MOST_STARTS, START) are work space.
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
    free = read_freedom(row(freedom, 0)), turns, few
    for i in range(first, last):
        verdicts[i] = solve_free(family, row(poses, i), free, own_goal(seeds, i, respect), desk, row(out, i))
