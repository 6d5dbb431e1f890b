"""Entry points: tasks read, postures for them, and joint angles."""

from srs_ik.kernels.algebra.pointers import row, scratch
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.pose.solve import own_goal
from srs_ik.kernels.task.posture import plan_given, read_task, write_posture
from srs_ik.kernels.task.solve import solve_task_one


@entry
def read_tasks(raw, given, out):
    """Read many tasks, (N, TASK) both; return the first row that is wrong, and what is (0: nothing)."""
    for i in range(raw.shape[0]):
        fault = read_task(raw[i], given, out[i])
        if fault:
            return i, fault
    return 0, 0


@entry
def posture(family, H, x, given, side, tie, out):
    """Write the posture of one task row."""
    P = row(family, LIMITED)
    write_posture(P, plan_given(P, H, x, given, side, tie), out)


@entry
def posture_range(family, H, tasks, first, last, given, side, tie, out):
    """Write the postures of the task rows first to last - 1."""
    P = row(family, LIMITED)
    hand = row(H, 0)
    for i in range(first, last):
        write_posture(P, plan_given(P, hand, row(tasks, i), given, side, tie), row(out, i))


@entry
def solve_tasks(family, H, tasks, first, last, given, side, tie, seeds, respect, out):
    """Solve the task rows first to last - 1; seeds are one for all, one a task, or none."""
    hand, J, A = row(H, 0), scratch(6, 7), scratch(16, 9)
    for i in range(first, last):
        goal = own_goal(seeds, i, respect)
        solve_task_one(family, hand, row(tasks, i), given, side, tie, goal, J, A, row(out, i))
