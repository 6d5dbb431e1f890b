"""Postures evenly spaced in arm angle through the intervals of a pose, each in the turns nearest to the one before."""

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, read7, row
from srs_ik.kernels.chain.answer import measure_row_at
from srs_ik.kernels.chain.starts import best_of_all
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import GOOD_POSE, OK, ROW_STATUS
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.limb.branches import NO_BRANCH
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.triangle import read_target
from srs_ik.kernels.near.at_angle import from_curves, solve_at_angle
from srs_ik.kernels.near.band import is_told
from srs_ik.kernels.near.on_curves import EVERY_BRANCH, followed_curves, no_curves, setting_of
from srs_ik.kernels.near.second_attempts import may_be_on_line, stretched
from srs_ik.kernels.pose.on_limits import put_on_limits
from srs_ik.kernels.pose.solve import solve_row_at

INSIDE = 1e-9
"""Samples stay this far inside the ends of an interval, rad; on an end, rounding may put a joint past its limit. An
interval without room for that has one posture."""

MOST_SEARCHES = 4
"""Samples of a pose that are searched for by all means, where neither Newton's method nor a curve leads to them."""


@kernel
def angle_of_sample(interval, i, count):
    """The arm angle of a sample of an interval."""
    lower, upper = interval[1], interval[2]
    if upper - lower <= 2.0 * INSIDE:
        return 0.5 * (lower + upper)
    share = i / (count - 1)
    return (1.0 - share) * (lower + INSIDE) + share * (upper - INSIDE)


@kernel
def self_motion_rows(family, T, intervals, respect, J, A, out):
    """Write as many postures for each interval of a pose as there are rows of out (n, ROW) for it."""
    P = row(family, LIMITED)
    target, verdict = read_target(P, T)
    if verdict != GOOD_POSE:
        return verdict
    count = out.shape[0] // max(intervals.shape[0], 1)
    before = np.zeros((1, 7))
    followed = no_curves()
    known = False
    searches = 0
    for i in range(intervals.shape[0] * count):
        interval = row(intervals, i // count)
        psi, branch = angle_of_sample(interval, i % count, count), int(interval[0])
        seeded = i % count > 0 and out[i - 1, ROW_STATUS] == OK
        goal = Goal(seeded, read7(row(before, 0)), respect)
        if P[IS_NEAR] == 0.0:
            solve_row_at(family, T, psi, branch, goal, J, A, row(out, i))
        else:
            found = (goal.seed, branch, 2.0 * NO_BRANCH)
            if is_told(P, target.place, psi):
                found = best_of_all(P, target, psi, branch, goal, A)
            if found[2] >= OUTSIDE:
                by = setting_of(P, target, J, A)
                if not known:
                    followed = followed_curves(P, by, EVERY_BRANCH)
                    known = True
                found, _ = from_curves(P, by, followed, psi, branch, goal, found)
            if found[2] >= OUTSIDE and searches < MOST_SEARCHES:
                found = solve_at_angle(P, target, psi, branch, goal, J, A)
                searches += 1
            if found[2] >= OUTSIDE and may_be_on_line(P, target.place):
                found = stretched(P, target, psi, branch, goal, J, A)
            found = put_on_limits(P, target, psi, found, goal)
            measure_row_at(P, target, psi, found, respect, row(out, i))
        if out[i, ROW_STATUS] == OK:
            for j in range(7):
                before[0, j] = out[i, j]
    keep(before)
    return GOOD_POSE
