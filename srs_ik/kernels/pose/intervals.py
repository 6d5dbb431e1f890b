"""Feasible arm angles of one pose, either kind of limb."""

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row, scratch
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import arm_angle, clipped
from srs_ik.kernels.exact.flat import HIDING, exact_intervals, intervals_around
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES, SOLVED
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import FREE, IS_NEAR, LIMITED, SIZE
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import may_split
from srs_ik.kernels.limb.limits import tighten
from srs_ik.kernels.near.at_angle import may_reach
from srs_ik.kernels.near.band import ALMOST_NOTHING, band_of, widen, widest
from srs_ik.kernels.near.intervals import intervals_through, true_intervals, with_on_line
from srs_ik.kernels.near.predicted import predicted_intervals
from srs_ik.kernels.near.predicted_best import search_true
from srs_ik.kernels.near.second_attempts import may_be_on_line
from srs_ik.kernels.pose.search import search_exact


@kernel
def may_be_hidden(F, target, J, A):
    """Whether a pose of a near limb without intervals may have postures all the same: with limits a little farther out.

    Or next to a singularity, where the curves may have been lost.
    """
    if not may_reach(F, target.place):
        return False
    if may_split(F, target.place):
        return True
    box, found = row(scratch(1, SIZE), 0), np.empty((8 * MAX_PIECES, 3))
    band = band_of(F, target.place)
    if widest(band) < ALMOST_NOTHING:
        # Limits may leave one of both limbs a point where the other has nothing, or points that no sample meets.
        widen(F, band, 1.0, box)
        hidden = find_intervals(box, target.place, -1, found) > 0
    else:
        tighten(F, NO_SEED, math.inf, HIDING, box)
        hidden = predicted_intervals(box, target, found, J, A) != 0
    return hidden


@kernel
def interval_alone(family, target, out):
    """The interval of the one posture of a closed limb that rounding leaves between its limits; the number of rows."""
    P = row(family, LIMITED)
    q, branch, _ = search_exact(family, target, -1, Goal(False, NO_SEED, True))
    # Put on its limits, as answers are.
    q = clipped(P, q)
    if max(*pose_error(P, q, target.R, target.p)) >= SOLVED:
        return 0
    return intervals_around(family, target.place, (branch, arm_angle(P, q, target.place[0], target.place[1])), out)


@kernel
def closed_intervals(family, target, respect, out):
    """Feasible intervals of one pose of a closed limb; the number of rows."""
    n, told = exact_intervals(family, target, respect, out)
    return n if told else interval_alone(family, target, out)


@kernel
def is_feasible(family, target, psi, branch):
    """Whether an interval of a closed limb inside its limits holds an arm angle, in a branch (-1: any)."""
    found = np.empty((8 * MAX_PIECES, 3))
    for i in range(closed_intervals(family, target, True, found)):
        if branch < 0 or found[i, 0] == branch:
            ahead = psi - found[i, 1]
            if ahead - 2.0 * math.pi * math.floor(ahead / (2.0 * math.pi)) <= found[i, 2] - found[i, 1]:
                return True
    return False


@kernel
def all_intervals(family, target, respect, J, A, out):
    """Feasible intervals of one pose on the true chain; none where the pose is out of reach."""
    P, F = row(family, LIMITED), row(family, LIMITED if respect else FREE)
    if P[IS_NEAR] == 0.0:
        return closed_intervals(family, target, respect, out)
    n = predicted_intervals(F, target, out, J, A)
    if n < 0:
        n = true_intervals(P, target, respect, out, J, A)
    if may_be_on_line(P, target.place):
        n = with_on_line(P, target, respect, J, A, out, n)
    if n == 0 and may_be_hidden(F, target, J, A):
        q, _, lowest = search_true(P, target, -1, Goal(False, NO_SEED, respect), J, A)
        if lowest < OUTSIDE:
            n = intervals_through(P, target, q, respect, out, J, A)
    return n
